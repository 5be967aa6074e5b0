"""What the graph says right now, wheel by wheel: a table on a terminal, lines elsewhere."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from math import isfinite, nan
from typing import Any

from friction_msgs.msg import BrakeCommand, FrictionSlope, SupervisorState, WheelSlip
from rclpy.node import Node
from rich.table import Table
from rich.text import Text
from sensor_msgs.msg import FluidPressure, JointState

from friction_runtime import qos
from friction_runtime.stamps import NANOSECONDS, to_nanoseconds

_SIGNS = {1: ("+", "green"), 0: ("?", "dim"), -1: ("−", "bold red")}
_STATES = {
    SupervisorState.S0: ("S0 idle", "dim"),
    SupervisorState.S1: ("S1 increase", "green"),
    SupervisorState.S21: ("S21 wait", "red"),
    SupervisorState.S22: ("S22 release", "yellow"),
}
_COMMANDS = {
    BrakeCommand.NONE: "none",
    BrakeCommand.INCREASE: "increase",
    BrakeCommand.HOLD: "hold",
    BrakeCommand.DECREASE: "decrease",
}
_DISCOVERY_PERIOD = 0.1
"""[s]"""
_BAR_CELLS = 20
_BAR_FULL_SLIP = 0.4
_LINE_CELL = 19


@dataclass
class WheelView:
    """The last message of each kind of one wheel."""

    wheel_speed: float = nan
    slip: WheelSlip = field(default_factory=WheelSlip)
    slope: FrictionSlope = field(default_factory=FrictionSlope)
    supervisor: SupervisorState = field(default_factory=SupervisorState)
    command: BrakeCommand | None = None
    pressure: float = nan


class LiveView(Node):
    """Listens to every wheel of the graph and keeps the last values."""

    def __init__(self) -> None:
        """Subscribe to wheel_states; the wheels follow as their topics appear."""
        super().__init__("live_view")
        self.wheels: dict[str, WheelView] = {}
        self.samples = 0
        """Messages of wheel_states so far."""
        self._first_stamp = 0
        self._last_stamp = 0
        qos.subscribe(self, JointState, "wheel_states", self._on_wheel_states, qos.SENSOR)
        self.create_timer(_DISCOVERY_PERIOD, self._discover)

    @property
    def time(self) -> float:
        """Message time since the first sample [s]; a jump back in time starts it anew."""
        return (self._last_stamp - self._first_stamp) / NANOSECONDS

    @property
    def speed(self) -> float:
        """Vehicle speed as estimated [m/s]; NaN where it is not known."""
        return next((view.slip.vehicle_speed for view in self.wheels.values() if view.slip.header.stamp.sec), nan)

    def _on_wheel_states(self, message: JointState) -> None:
        stamp = to_nanoseconds(message.header.stamp)
        if self.samples == 0 or stamp < self._last_stamp:
            self._first_stamp = stamp
        self._last_stamp = stamp
        self.samples += 1
        for wheel, wheel_speed in zip(message.name, message.velocity, strict=False):
            if wheel in self.wheels:
                self.wheels[wheel].wheel_speed = wheel_speed

    def _discover(self) -> None:
        """Subscribe to the wheels that wheel_slip speaks of, before the first sample comes."""
        for topic, _ in self.get_topic_names_and_types():
            wheel, _, name = topic.removeprefix(self.get_namespace()).strip("/").rpartition("/")
            if name == "slip" and wheel not in self.wheels and not wheel.startswith("truth/"):
                self._add(wheel)

    def _add(self, wheel: str) -> None:
        self.wheels[wheel] = WheelView()
        for kind, topic in (
            (WheelSlip, "slip"),
            (FrictionSlope, "friction_slope"),
            (SupervisorState, "abs_supervisor"),
            (BrakeCommand, "brake_command"),
            (FluidPressure, "brake_pressure"),
        ):
            qos.subscribe(self, kind, f"{wheel}/{topic}", partial(self._on_message, wheel), qos.SENSOR)

    def _on_message(self, wheel: str, message: Any) -> None:
        view = self.wheels[wheel]
        if isinstance(message, WheelSlip):
            view.slip = message
        elif isinstance(message, FrictionSlope):
            view.slope = message
        elif isinstance(message, SupervisorState):
            view.supervisor = message
        elif isinstance(message, BrakeCommand):
            view.command = message
        else:
            view.pressure = message.fluid_pressure

    def table(self, title: str) -> Table:
        """Show the wheels as a table for a terminal."""
        table = Table(title=f"{title}   t = {self.time:6.2f} s   v = {_number(self.speed, '5.2f')} m/s", expand=False)
        table.add_column("wheel", no_wrap=True)
        for heading in ("speed ω [rad/s]", "slip", "", "slope", "indicator", "state", "command", "pressure [bar]"):
            table.add_column(heading, justify="left" if heading in ("", "state", "command") else "right", no_wrap=True)
        table.columns[3].min_width = _BAR_CELLS
        for wheel, view in self.wheels.items():
            slip = view.slip.slip if view.slip.valid else nan
            sign, sign_style = _SIGNS[view.slope.sign if view.slope.valid else 0]
            state, state_style = _STATES[view.supervisor.state]
            table.add_row(
                wheel,
                f"{view.wheel_speed:.1f}",
                _number(slip, ".3f"),
                Text(_bar(slip), style="bold red" if sign == "−" else "green"),
                Text(sign, style=sign_style),
                _number(view.slope.indicator if view.slope.valid else nan, ".0f"),
                Text(state, style=state_style),
                _command(view),
                _bar_pressure(view),
            )
        table.caption = "\n".join(self.reasons()) or None
        return table

    def header(self) -> str:
        """Name the columns of the lines."""
        return f"  t [s]  v [m/s]  {'  '.join(f'{wheel:{_LINE_CELL}}' for wheel in self.wheels)}"

    def line(self) -> str:
        """Show the wheels as one line: slip, slope's sign, and for a single wheel what the supervisor does."""
        cells = []
        for view in self.wheels.values():
            slip = _number(view.slip.slip if view.slip.valid else nan, "5.3f")
            sign = _SIGNS[view.slope.sign if view.slope.valid else 0][0]
            cells.append(f"{f'slip {slip:>6} slope {sign}':{_LINE_CELL}}")
        if len(self.wheels) == 1:
            cells.append(f"{_STATES[view.supervisor.state][0]:11}  {_command(view):8}  {_bar_pressure(view):>6} bar")
        return f"{self.time:7.2f}  {_number(self.speed, '7.2f'):>7}  {'  '.join(cells)}"

    def reasons(self) -> list[str]:
        """Name what cannot be estimated at this moment, and why."""
        texts = (
            message.reason_text
            for view in self.wheels.values()
            for message in (view.slip, view.slope)
            if not message.valid and message.reason_text
        )
        return list(dict.fromkeys(texts))


def _number(value: float, form: str) -> str:
    return f"{value:{form}}" if isfinite(value) else "–"


def _command(view: WheelView) -> str:
    return "silent" if view.command is None else _COMMANDS[view.command.command]


def _bar_pressure(view: WheelView) -> str:
    return _number(1e-5 * view.pressure, ".1f")


def _bar(slip: float) -> str:
    filled = round(_BAR_CELLS * min(max(slip, 0.0), _BAR_FULL_SLIP) / _BAR_FULL_SLIP) if isfinite(slip) else 0
    return "█" * filled
