"""A view of every wheel on a terminal of any width, lines elsewhere; it keeps running when nodes end."""

from __future__ import annotations

import select
import sys
import termios
import tty
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from time import monotonic

import rclpy
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.signals import SignalHandlerOptions
from rich.console import Console, Group
from rich.live import Live
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from friction_bringup.live_view import LiveView, WheelView
from friction_runtime.reports import plain_reason
from friction_runtime.spin import stop_on_signals, take_down

_PERIOD = 0.1
_STALE = 0.5
"""Age [s] from which a topic counts as silent."""
_LINE_PERIOD = 0.5
"""Time between two lines where the output is no terminal [s]."""
_FORCE = "tyre_force"


@dataclass(frozen=True)
class _Column:
    """A column of the table."""

    heading: str
    cell: Callable[[WheelView], str | Text]
    from_width: int = 0
    """Width of the terminal [characters] from which it is shown."""
    below_width: int = 1000
    """Width from which a wider column stands in its place."""


_COLUMNS = (
    _Column("v [m/s]", lambda view: view.number("slip", "vehicle_speed", ".2f"), 100),
    _Column("slip", lambda view: view.number("slip", "slip", ".3f")),
    _Column("sign", lambda view: view.sign),
    _Column("state", lambda view: view.state),
    _Column("command", lambda view: _with_release(view)),
    _Column("λ_max", lambda view: view.number("friction_curve", "lambda_max", ".3f"), 0, 130),
    _Column("λ_max", lambda view: _with_deviation(view, "friction_curve", "lambda_max", ".3f"), 130),
    _Column("µ_max", lambda view: view.number("friction_curve", "mu_max", ".2f"), 100, 130),
    _Column("µ_max", lambda view: _with_deviation(view, "friction_curve", "mu_max", ".2f"), 130),
)
_FORCE_COLUMNS = (
    _Column("Fx [kN]", lambda view: view.number(_FORCE, "fx", ".2f", 1e-3), 0, 130),
    _Column("Fz [kN]", lambda view: view.number(_FORCE, "fz", ".2f", 1e-3), 0, 130),
    _Column("Fx [kN]", lambda view: _with_deviation(view, _FORCE, "fx", ".2f", 1e-3), 130),
    _Column("Fz [kN]", lambda view: _with_deviation(view, _FORCE, "fz", ".2f", 1e-3), 130),
)


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
        if console.is_terminal:
            with _pressed_keys() as key, Live(console=console, auto_refresh=False, screen=True) as live:
                while key() != "q" and not stop.is_set():
                    spin(_PERIOD)
                    live.update(wheels_view(view.wheels, monotonic(), console.width), refresh=True)
        else:
            _print_lines(view, spin, stop.is_set)
    finally:
        take_down(view, executor)
    return 0


def _print_lines(view: LiveView, spin: Callable[[float], None], stopped: Callable[[], bool]) -> None:
    """Print a line for the wheels now and then, and the header before it where the wheels are others."""
    header = ""
    while not stopped():
        spin(_LINE_PERIOD)
        if view.samples and not stopped():
            if view.header() != header:
                header = view.header()
                print(header)
            print(view.line(), flush=True)


def wheels_view(wheels: dict[str, WheelView], now: float, width: int) -> Group:
    """Return a table of all wheels, and below it a line for whatever is not valid or silent.

    Args:
        wheels: views of the wheels by name.
        now: present time of the steady clock [s], for the age of messages.
        width: of the terminal [characters].
    """
    forces = any(_FORCE in view.messages for view in wheels.values())
    chosen = (*_COLUMNS, *(_FORCE_COLUMNS if forces else ()))
    columns = [each for each in chosen if each.from_width <= width < each.below_width]
    table = Table(
        title="Friction graph (q quits)", title_justify="left", box=None, collapse_padding=True, pad_edge=False
    )
    for heading in ("wheel", *(each.heading for each in columns), "age [s]"):
        table.add_column(escape(heading), no_wrap=True)
    said: list[Text] = []
    for wheel, view in wheels.items():
        ages = {topic: now - arrival for topic, arrival in view.arrivals.items()}
        silent = [f"{topic} silent for {age:.1f} s" for topic, age in ages.items() if age > _STALE]
        youngest = min(ages.values(), default=float("inf"))
        table.add_row(
            wheel,
            *(each.cell(view) for each in columns),
            Text(f"{youngest:.2f}", style="bold red" if youngest > _STALE else ""),
            style="dim" if youngest > _STALE else "",
        )
        reasons = (plain_reason(reason, wheel) for reason in view.reasons)
        said += [Text(f"{wheel}: {text}") for text in dict.fromkeys((*silent, *reasons, *_refused(view)))]
    if not wheels:
        table.caption = "no wheel yet: waiting for a topic such as front_left/slip on this ROS_DOMAIN_ID"
    return Group(table, *said)


def _with_release(view: WheelView) -> Text:
    """Return the command, and below it the verdict of the envelope if the law requests a release."""
    release = view.release
    return Text(view.command) if release.plain == "–" else Text.assemble(view.command, "\n", release)


def _refused(view: WheelView) -> list[str]:
    supervisor = view.messages.get("abs_supervisor")
    count = 0 if supervisor is None else supervisor.refused_releases
    return [f"releases refused so far: {count}"] if count else []


def _with_deviation(view: WheelView, topic: str, name: str, form: str, scale: float = 1.0) -> str:
    value = view.number(topic, name, form, scale)
    return value if value == "–" else f"{value} ± {view.number(topic, f'{name}_stddev', form, scale)}"


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
