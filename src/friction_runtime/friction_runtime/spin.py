"""Main loop of every process of the graph: clean exit on SIGINT and SIGTERM."""

import signal
import sys
from collections.abc import Callable, Sequence
from threading import Event

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from friction_runtime.parameters import ParameterError

_WAKE_PERIOD = 0.2
"""[s] EventsExecutor.spin() does not return on a signal; waking up now and then does."""


def run(make_node: Callable[[], Node], args: Sequence[str] | None = None) -> int:
    """Make the node and spin it until a signal, or until it calls rclpy.try_shutdown().

    Returns:
        Exit code: 0, or 2 when a parameter is bad (which is printed).
    """
    stop = stop_on_signals()
    rclpy.init(args=None if args is None else list(args), signal_handler_options=SignalHandlerOptions.NO)
    node: Node | None = None
    try:
        node = make_node()
        executor = EventsExecutor()
        executor.add_node(node)
        while rclpy.ok() and not stop.is_set():
            executor.spin_once(timeout_sec=_WAKE_PERIOD)
    except ExternalShutdownException:
        pass  # the node has called try_shutdown()
    except ParameterError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
    return 0


def stop_on_signals() -> Event:
    """Event that is set by SIGINT or SIGTERM.

    Neither an exception nor the end of the context comes in the middle of a call, as with the handlers of rclpy.
    """
    stop = Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    return stop
