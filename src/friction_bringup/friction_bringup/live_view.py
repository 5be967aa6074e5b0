"""Present messages of the graph, wheel by wheel: a table on a terminal, lines elsewhere."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from math import isfinite, nan
from time import monotonic
from typing import Any

from friction_msgs.msg import BrakeCommand, FrictionCurve, FrictionSlope, SupervisorState, TyreForce, WheelSlip
from rclpy.node import Node
from rich.box import SIMPLE_HEAD
from rich.console import JustifyMethod
from rich.markup import escape
from rich.table import Table
from rich.text import Text
from sensor_msgs.msg import FluidPressure, JointState

from friction_bringup.graph import VEHICLE
from friction_runtime import qos
from friction_runtime.messages import to_nanoseconds
from vehicle_models.nanoseconds import NANOSECONDS

TOPICS: dict[str, type] = {
    "slip": WheelSlip,
    "friction_slope": FrictionSlope,
    "friction_curve": FrictionCurve,
    "abs_supervisor": SupervisorState,
    "brake_command": BrakeCommand,
    "brake_pressure": FluidPressure,
    "tyre_force": TyreForce,
}
"""Types of a wheel's topics, by the name after that of the wheel."""
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
_LIMITED = "bold red"
_RELEASES = {
    SupervisorState.RELEASE_NOT_WANTED: ("–", "dim"),
    SupervisorState.RELEASE_BY_SLIP: ("slip", "yellow"),
    SupervisorState.RELEASE_BY_DECELERATION: ("decel.", "yellow"),
    SupervisorState.RELEASE_REFUSED: ("refused", _LIMITED),
    SupervisorState.RELEASE_REFERENCE: ("reference", "yellow"),
}
_CAPS = {
    SupervisorState.CAP_CONTINUOUS: ("too long", _LIMITED),
    SupervisorState.CAP_SHARE: ("too often", _LIMITED),
    SupervisorState.CAP_RETURN: ("return", _LIMITED),
    SupervisorState.CAP_LOW_SPEED: ("driver", "dim"),
}
_DISCOVERY_PERIOD = 0.1
"""Period of looking for new topics [s]."""
_BAR_CELLS = 10
_BAR_FULL_SLIP = 0.4
_LINE_CELL = 19
_Columns = tuple[tuple[str, int, JustifyMethod], ...]
_TABLE_COLUMNS: _Columns = (
    ("wheel", 11, "left"),
    ("slip", 5, "right"),
    ("sign", 4, "center"),
    ("state", 11, "left"),
    ("command", 8, "left"),
    ("p [bar]", 7, "right"),
)
_BAR_COLUMN: _Columns = (("", _BAR_CELLS, "left"),)
_FORCE_COLUMNS: _Columns = (("Fx [kN]", 7, "right"), ("Fz [kN]", 7, "right"))


@dataclass
class WheelView:
    """The last message of each topic of one wheel, and its text."""

    messages: dict[str, Any] = field(default_factory=dict)
    arrivals: dict[str, float] = field(default_factory=dict)
    """Arrival of the last message of each topic by the steady clock [s]."""

    def number(self, topic: str, name: str, form: str, scale: float = 1.0) -> str:
        """Return a field as text: a dash where the topic is silent or not valid, or the value is not finite."""
        message = self.messages.get(topic)
        usable = message is not None and _is_valid(message)
        return number(scale * getattr(message, name), form) if usable else "–"

    @property
    def sign(self) -> Text:
        """Sign of the friction curve's slope; a question mark where it is not known."""
        slope = self.messages.get("friction_slope")
        text, style = _SIGNS[slope.sign if slope is not None and slope.validity.valid else 0]
        return Text(text, style=style)

    @property
    def state(self) -> Text:
        """State of the supervisor; where the law on the curve is in force, the slip that it holds."""
        supervisor = self.messages.get("abs_supervisor")
        if supervisor is None:
            return Text("–")
        if isfinite(supervisor.slip_set_point) and supervisor.law == SupervisorState.LAW_CURVE:
            return Text(f"curve {supervisor.slip_set_point:.3f}", style="green")
        return Text.styled(*_STATES[supervisor.state])

    @property
    def command(self) -> str:
        """Command to the brake; "silent" where there is none."""
        command = self.messages.get("brake_command")
        return "silent" if command is None else _COMMANDS[command.command]

    @property
    def release(self) -> Text:
        """What the envelope lets a release pass by, or the cap in force; a dash where there is neither."""
        supervisor = self.messages.get("abs_supervisor")
        if supervisor is None:
            return Text("–")
        text, style = _CAPS.get(supervisor.cap, _RELEASES[supervisor.release])
        return Text(text, style=style)

    @property
    def reasons(self) -> list[str]:
        """Return what cannot be estimated, and why."""
        texts = (message.validity.text for message in self.messages.values() if not _is_valid(message))
        return list(dict.fromkeys(text for text in texts if text))


class LiveView(Node):
    """Subscribes to every wheel of the graph and keeps the last values."""

    def __init__(self) -> None:
        """Subscribe to wheel_states; the wheels follow as their topics appear."""
        super().__init__("live_view")
        self.wheels: dict[str, WheelView] = {}
        self.samples = 0
        """Messages of wheel_states so far; of tyre_force where there are none."""
        self._wheels_turn = False
        self._first_stamp = 0
        self._last_stamp = 0
        self._listening: set[str] = set()
        qos.subscribe(self, JointState, "wheel_states", self._on_wheel_states, qos.SENSOR)
        self.create_timer(_DISCOVERY_PERIOD, self._discover)

    @property
    def time(self) -> float:
        """Message time since the first sample [s]; it starts again after a jump back in time."""
        return (self._last_stamp - self._first_stamp) / NANOSECONDS

    @property
    def speed(self) -> float:
        """Vehicle speed as estimated [m/s]; NaN where it is not known."""
        slips = (view.messages.get("slip") for view in self.wheels.values())
        return next((slip.vehicle_speed for slip in slips if slip is not None), nan)

    @property
    def _real_wheels(self) -> dict[str, WheelView]:
        return {wheel: view for wheel, view in self.wheels.items() if wheel != VEHICLE}

    def _on_wheel_states(self, message: JointState) -> None:
        self._wheels_turn = True
        self._sample(to_nanoseconds(message.header.stamp))

    def _sample(self, stamp: int) -> None:
        if self.samples == 0 or stamp < self._last_stamp:
            self._first_stamp = stamp
        self._last_stamp = stamp
        self.samples += 1

    def _discover(self) -> None:
        """Subscribe to topics of wheels as they appear, before the first sample comes."""
        for topic, _ in self.get_topic_names_and_types():
            wheel, _, name = topic.removeprefix(self.get_namespace()).strip("/").rpartition("/")
            if name in TOPICS and topic not in self._listening and "truth" not in wheel.split("/"):
                self._listening.add(topic)
                self.wheels.setdefault(wheel, WheelView())
                self.wheels = dict(sorted(self.wheels.items()))
                qos.subscribe(self, TOPICS[name], topic, partial(self._on_message, wheel, name), qos.SENSOR)

    def _on_message(self, wheel: str, name: str, message: Any) -> None:
        view = self.wheels[wheel]
        view.messages[name] = message
        view.arrivals[name] = monotonic()
        if name == "tyre_force" and not self._wheels_turn:
            self._sample(max(to_nanoseconds(message.header.stamp), self._last_stamp))

    def table(self, title: str) -> Table:
        """Return the wheels as a table for a terminal of 80 columns."""
        heading = f"{title}   t = {self.time:6.2f} s   v = {number(self.speed, '5.2f')} m/s"
        table = Table(title=heading, title_justify="left", box=SIMPLE_HEAD, pad_edge=False)
        forces = any("tyre_force" in view.messages for view in self._real_wheels.values())
        for name, width, justify in (*_TABLE_COLUMNS, *(_FORCE_COLUMNS if forces else _BAR_COLUMN)):
            table.add_column(escape(name), min_width=width, justify=justify, no_wrap=True)
        for wheel, view in self._real_wheels.items():
            sign = view.sign
            table.add_row(
                wheel,
                view.number("slip", "slip", ".3f"),
                sign,
                view.state,
                Text(view.command, style=_LIMITED if view.release.style == _LIMITED else ""),
                view.number("brake_pressure", "fluid_pressure", ".1f", 1e-5),
                *(_forces(view) if forces else [Text(_bar(view), style="green" if sign.plain != "−" else "bold red")]),
            )
        reasons = dict.fromkeys(reason for view in self.wheels.values() for reason in view.reasons)
        table.caption = escape("\n".join(reasons)) or " "
        table.caption_justify = "left"
        return table

    def header(self) -> str:
        """Return the header of the lines."""
        return f"  t [s]  v [m/s]  {'  '.join(f'{wheel:{_LINE_CELL}}' for wheel in self._real_wheels)}"

    def line(self) -> str:
        """Return the wheels as one line: slip, sign of the slope, forces; of a single wheel the supervisor's state."""
        cells = []
        for view in self._real_wheels.values():
            slip = view.number("slip", "slip", ".3f")
            forces = "  Fx {:>6} Fz {:>5} kN".format(*_forces(view)) if "tyre_force" in view.messages else ""
            cells.append(f"slip {slip:>6} slope {view.sign.plain}".ljust(_LINE_CELL) + forces)
        if len(cells) == 1:
            pressure = view.number("brake_pressure", "fluid_pressure", ".1f", 1e-5)
            cells.append(f"{view.state.plain:11}  {view.command:8}  {pressure:>6} bar")
        return f"{self.time:7.2f}  {number(self.speed, '7.2f'):>7}  {'  '.join(cells)}"


def _is_valid(message: Any) -> bool:
    return not hasattr(message, "validity") or message.validity.valid


def number(value: float, form: str) -> str:
    """Return a number as text, a dash where it is not finite."""
    return f"{value:{form}}" if isfinite(value) else "–"


def _forces(view: WheelView) -> list[str]:
    return [view.number("tyre_force", name, ".2f", 1e-3) for name in ("fx", "fz")]


def _bar(view: WheelView) -> str:
    slip = view.messages.get("slip")
    if slip is None or not slip.validity.valid or not isfinite(slip.slip):
        return ""
    return "█" * round(_BAR_CELLS * min(max(slip.slip, 0.0), _BAR_FULL_SLIP) / _BAR_FULL_SLIP)
