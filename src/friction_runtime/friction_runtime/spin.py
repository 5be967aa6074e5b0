"""Main loop of every process of the graph: clean exit on SIGINT and SIGTERM."""

import faulthandler
import gc
import signal
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from queue import Empty, SimpleQueue
from tempfile import TemporaryDirectory
from typing import Protocol, TypeVar

import rclpy
from rclpy.exceptions import NameValidationException, ParameterException
from rclpy.executors import Executor, ExternalShutdownException
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.qos_overriding_options import InvalidQosOverridesError
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from friction_parameters.parameter import ParameterError
from friction_runtime.parameters import with_checked_parameters


class StopFlag:
    """Asks a loop to end.

    Not a threading.Event: its lock is not reentrant, so that a handler which runs while `wait` holds it waits forever.
    """

    def __init__(self) -> None:
        """Begin with the flag not set."""
        self._is_set = False
        self._wake: SimpleQueue[None] = SimpleQueue()

    def set(self) -> None:
        """Set the flag; may be called anywhere, also in a signal handler."""
        self._is_set = True
        self._wake.put(None)

    def is_set(self) -> bool:
        """Whether the flag is set."""
        return self._is_set

    def wait(self, timeout: float) -> bool:
        """Return at once when the flag is or becomes set, else after `timeout` [s], >= 0; return whether it is set.

        One thread may wait at a time.
        """
        if not self._is_set:
            with suppress(Empty):
                self._wake.get(timeout=timeout)
        return self._is_set


_LONGEST_WAIT = 0.2
"""Time between two looks at whether a signal has come [s]: the executor does not return on one by itself."""
_TAKE_DOWN_LIMIT = 3.0
"""Longest time for taking a node down [s]."""
_STDERR = 2
Made = TypeVar("Made")
_REFUSALS = (
    rclpy_implementation.RCLError,
    rclpy_implementation.UnknownROSArgsError,
    NameValidationException,
    ParameterException,
    InvalidQosOverridesError,
)
"""Exceptions of the middleware for a command line or a ROS parameter that it does not accept."""


def run(name: str, parameter_class: type, make_node: Callable[[], Node], args: Sequence[str] | None = None) -> int:
    """Run one node, as run_nodes does.

    Args:
        name: name of the node, unless it is remapped.
        parameter_class: dataclass of its parameters.
        make_node: makes the node; rclpy is initialised.
        args: command line, that of the process if None.

    Returns:
        Exit code.
    """
    return run_nodes({name: parameter_class}, lambda: _Alone([make_node()]), args)


class Nodes(Protocol):
    """The nodes of a process."""

    @property
    def nodes(self) -> Sequence[Node]:
        """The nodes."""

    def spin(self, executor: Executor, seconds: float) -> None:
        """Serve what arrives for about some time [s]; the executor holds the nodes."""


@dataclass(frozen=True)
class _Alone:
    """One node."""

    nodes: Sequence[Node]

    def spin(self, executor: Executor, seconds: float) -> None:
        executor.spin_until_future_complete(Future(), timeout_sec=seconds)  # spin_once returns after each callback


def run_nodes(
    parameter_classes: Mapping[str, type], make_nodes: Callable[[], Nodes], args: Sequence[str] | None = None
) -> int:
    """Check the parameters, make the nodes and spin them until a signal, or until one calls rclpy.try_shutdown().

    Args:
        parameter_classes: dataclass of the parameters of each node, by its name unless it is remapped.
        make_nodes: makes the nodes; rclpy is initialised.
        args: command line, that of the process if None.

    Returns:
        Exit code: 0, or 2 when an argument, a parameter or a file is bad (which is printed in one line).
    """
    stop = stop_on_signals()
    executor: Executor | None = None
    held: Nodes = _Alone([])
    try:
        with TemporaryDirectory() as directory:
            given = sys.argv if args is None else args
            start_middleware(with_checked_parameters(given, parameter_classes, Path(directory)))
        executor = EventsExecutor()
        held = made(make_nodes)
        for node in held.nodes:
            executor.add_node(node)
        gc.freeze()  # what has been loaded stays: to look for garbage in it takes 40 ms each time
        while rclpy.ok() and not stop.is_set():
            held.spin(executor, _LONGEST_WAIT)
    except ExternalShutdownException:
        pass  # the node has called try_shutdown()
    except ParameterError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    finally:
        _take_down(held.nodes, executor)
    return 0


def start_middleware(arguments: Sequence[str]) -> None:
    """Initialise rclpy without its signal handlers.

    Raises:
        ParameterError: it does not accept the arguments.
    """
    try:
        rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
    except _REFUSALS as error:
        raise ParameterError(str(error)) from error


def made(make: Callable[[], Made]) -> Made:
    """Make a node, or something on it.

    Raises:
        ParameterError: the middleware does not accept a name, a parameter or a QoS override.
    """
    try:
        return make()
    except _REFUSALS as error:
        raise ParameterError(str(error)) from error


def take_down(node: Node | None, executor: Executor | None = None) -> None:
    """Take down a node and the middleware of this process, after everything has been published or written.

    Fast DDS can wait for itself forever when other processes vanish while it removes its participant (seen in 2 of 800
    exits, of many nodes at once). Such a process reports that on stderr and ends with exit code 1, instead of never.
    """
    _take_down([] if node is None else [node], executor)


def _take_down(nodes: Sequence[Node], executor: Executor | None) -> None:
    sys.stdout.flush()
    faulthandler.dump_traceback_later(_TAKE_DOWN_LIMIT, exit=True, file=_STDERR)
    try:
        if executor is not None:
            executor.shutdown()  # it would keep the node's participant until it is gone itself
        for node in nodes:
            node.destroy_node()
        rclpy.try_shutdown()
    finally:
        faulthandler.cancel_dump_traceback_later()


def stop_on_signals() -> StopFlag:
    """Return a flag that is set by SIGINT or SIGTERM.

    Unlike with the handlers of rclpy, no exception and no end of the context comes in the middle of a call.
    """
    stop = StopFlag()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    return stop
