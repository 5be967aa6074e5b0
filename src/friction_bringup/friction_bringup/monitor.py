"""A view of every wheel on a plain terminal; it keeps running when nodes end."""

from __future__ import annotations

import select
import sys
import termios
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic

import rclpy
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.signals import SignalHandlerOptions
from rich.console import Console
from rich.live import Live
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from friction_bringup.live_view import LiveView, WheelView
from friction_runtime.spin import stop_on_signals, take_down

_PERIOD = 0.1
_STALE = 0.5
"""Age [s] from which a topic counts as silent."""
_COLUMNS = (
    *("wheel", "speed [m/s]", "slip", "slope", "state", "command"),
    *("λ_max", "µ_max", "Fx [kN]", "Fz [kN]", "age [s]", "not valid, or silent"),
)


def run_monitor() -> int:
    """Show the graph until q, Ctrl-C or SIGTERM; return the exit code 0."""
    console = Console()
    stop = stop_on_signals()
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    view = LiveView()
    executor = EventsExecutor()
    executor.add_node(view)
    try:
        with _pressed_keys() as key, Live(console=console, auto_refresh=False, screen=console.is_terminal) as live:
            while key() != "q" and not stop.is_set():
                until = monotonic() + _PERIOD
                while (remaining := until - monotonic()) > 0.0 and not stop.is_set():
                    executor.spin_once(timeout_sec=remaining)
                live.update(wheels_table(view.wheels, monotonic()), refresh=True)
    finally:
        take_down(view, executor)
    return 0


def wheels_table(wheels: dict[str, WheelView], now: float) -> Table:
    """Return a table of all wheels.

    Args:
        wheels: views of the wheels by name.
        now: present time of the steady clock [s], for the age of messages.
    """
    table = Table(title="Friction graph (q quits)", expand=True)
    for heading in _COLUMNS:
        table.add_column(escape(heading), no_wrap=heading != _COLUMNS[-1], ratio=1 if heading == _COLUMNS[-1] else None)
    for wheel, view in wheels.items():
        ages = {topic: now - arrival for topic, arrival in view.arrivals.items()}
        silent = [f"{topic} silent for {age:.1f} s" for topic, age in ages.items() if age > _STALE]
        youngest = min(ages.values(), default=float("inf"))
        table.add_row(
            wheel,
            view.number("slip", "vehicle_speed", ".2f"),
            view.number("slip", "slip", ".3f"),
            view.sign,
            view.state,
            _with_release(view),
            _with_deviation(view, "friction_curve", "lambda_max", ".3f"),
            _with_deviation(view, "friction_curve", "mu_max", ".2f"),
            _with_deviation(view, "tyre_force", "fx", ".2f", 1e-3),
            _with_deviation(view, "tyre_force", "fz", ".2f", 1e-3),
            Text(f"{youngest:.2f}", style="bold red" if youngest > _STALE else ""),
            escape("\n".join([*silent, *view.reasons, *_refused(view)])),
            style="dim" if youngest > _STALE else "",
        )
    if not wheels:
        table.caption = "no wheel yet: waiting for a topic such as front_left/slip on this ROS_DOMAIN_ID"
    return table


def _with_release(view: WheelView) -> Text:
    """Return the command, and below it what the envelope says of a release if the law asks for one."""
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
