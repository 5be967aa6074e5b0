"""Main loop of every process of the graph: clean exit on SIGINT and SIGTERM."""

import sys
from collections.abc import Callable, Sequence

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node

from friction_runtime.parameters import ParameterError

_WAKE_PERIOD = 0.2
"""[s] EventsExecutor.spin() does not return on a signal; waking up now and then does."""


def run(make_node: Callable[[], Node], args: Sequence[str] | None = None) -> int:
    """Make the node and spin it until a signal, or until it calls rclpy.try_shutdown().

    Returns:
        Exit code: 0, or 2 when a parameter is bad (which is printed).
    """
    rclpy.init(args=None if args is None else list(args))
    node: Node | None = None
    try:
        node = make_node()
        executor = EventsExecutor()
        executor.add_node(node)
        while rclpy.ok():
            executor.spin_once(timeout_sec=_WAKE_PERIOD)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except ParameterError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except Exception:
        # A signal in the middle of a call surfaces as one of several errors; only those of a live context are ours.
        if rclpy.ok():
            raise
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
    return 0
