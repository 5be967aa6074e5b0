"""A view of every wheel while the graph runs, for the monitor and the demo; it keeps running when nodes end."""

from __future__ import annotations

import select
import sys
import termios
import tty
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from time import monotonic

import rclpy
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.signals import SignalHandlerOptions
from rich.console import Console
from rich.live import Live

from friction_bringup.live_view import LiveView, wheels_view
from friction_runtime.spin import stop_on_signals, take_down

_PERIOD = 0.1
_LINE_PERIOD = 0.25
"""Time between two lines where the output is no terminal [s]."""


def add_arguments(_: ArgumentParser) -> None:
    """There are none."""


def run(_: Namespace, of_ros: Sequence[str]) -> int:
    """Show the graph until q, Ctrl-C or SIGTERM: a table on a terminal, lines elsewhere; return the exit code 0.

    Args:
        of_ros: arguments of ROS, from --ros-args on.
    """
    console = Console()
    stop = stop_on_signals()
    rclpy.init(args=list(of_ros), signal_handler_options=SignalHandlerOptions.NO)
    view = LiveView()
    executor = EventsExecutor()
    executor.add_node(view)

    def spin(period: float) -> None:
        until = monotonic() + period
        while (remaining := until - monotonic()) > 0.0 and not stop.is_set():
            executor.spin_once(timeout_sec=remaining)

    try:
        with _pressed_keys() as key:
            show_live(console, view, "q quits", spin, lambda: stop.is_set() or key() == "q", screen=True)
    finally:
        take_down(view, executor)
    return 0


def show_live(
    console: Console,
    view: LiveView,
    name: str,
    spin: Callable[[float], None],
    done: Callable[[], bool],
    *,
    screen: bool = False,
) -> None:
    """Show the graph until `done`: a table on a terminal; elsewhere a line now and then, and a header for new wheels.

    Args:
        console: where it is shown.
        view: the node that listens.
        name: begins the title.
        spin: lets the node listen for a time [s].
        done: returns whether it is enough.
        screen: whether the table has the whole terminal, and leaves nothing behind.
    """
    if console.is_terminal:
        with Live(console=console, auto_refresh=False, screen=screen) as live:
            while not done():
                spin(_PERIOD)
                live.update(wheels_view(view.wheels, monotonic(), console.width, view.title(name)), refresh=True)
        return
    header, shown = "", 0
    while not done():
        spin(_LINE_PERIOD)
        if view.samples != shown and not done():
            shown = view.samples
            if view.header() != header:
                header = view.header()
                print(header)
            print(view.line(), flush=True)


@contextmanager
def _pressed_keys() -> Iterator[Callable[[], str]]:
    """Yield a function that returns the key pressed since the last call, an empty string for none."""
    if not sys.stdin.isatty():
        yield lambda: ""
        return
    settings = termios.tcgetattr(sys.stdin)
    tty.setcbreak(sys.stdin)
    try:
        yield lambda: sys.stdin.read(1) if select.select([sys.stdin], [], [], 0.0)[0] else ""
    finally:
        termios.tcsetattr(sys.stdin, termios.TCSADRAIN, settings)
