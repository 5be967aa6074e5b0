"""Present messages of the graph, wheel by wheel: a table with 95 % intervals on a terminal, lines elsewhere."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from math import isfinite, nan
from time import monotonic
from typing import Any

from friction_msgs.msg import BrakeCommand, FrictionCurve, FrictionSlope, Grip, SupervisorState, TyreForce, WheelSlip
from rclpy.node import Node
from rich.console import Group
from rich.markup import escape
from rich.table import Table
from rich.text import Text
from sensor_msgs.msg import FluidPressure, JointState

from friction_bringup.graph import VEHICLE
from friction_runtime import qos
from friction_runtime.messages import to_nanoseconds
from friction_runtime.reports import INTERVAL_95, plain_reason
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
    SupervisorState.RELEASE_BY_ROAD_TORQUE: ("torque", "yellow"),
    SupervisorState.RELEASE_REFUSED: ("refused", _LIMITED),
    SupervisorState.RELEASE_SPEED_PROBE: ("probe", "yellow"),
}
_LIMITS = {
    SupervisorState.LIMIT_NO_SPIN_UP: ("no spin-up", _LIMITED),
    SupervisorState.LIMIT_BUDGET: ("budget", _LIMITED),
    SupervisorState.LIMIT_RETURN: ("return", _LIMITED),
    SupervisorState.LIMIT_LOW_SPEED: ("driver", "dim"),
}
_DISCOVERY_PERIOD = 0.1
"""Period of looking for new topics [s]."""
_LINE_CELL = 34
_STALE = 0.5
"""Age [s] from which a topic counts as silent."""
_FORCE, _CURVE = "tyre_force", "friction_curve"


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
        """Verdict on a release, or the limit in force; a dash where there is neither."""
        supervisor = self.messages.get("abs_supervisor")
        if supervisor is None:
            return Text("–")
        text, style = _LIMITS.get(supervisor.limit, _RELEASES[supervisor.release])
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
        self._grip: Grip | None = None
        qos.subscribe(self, JointState, "wheel_states", self._on_wheel_states, qos.SENSOR)
        qos.subscribe(self, Grip, "grip", self._on_grip, qos.SENSOR)
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

    def _on_grip(self, message: Grip) -> None:
        self._grip = message

    def _sample(self, stamp: int) -> None:
        if self.samples == 0 or stamp < self._last_stamp:
            self._first_stamp = stamp
        self._last_stamp = stamp
        self.samples += 1

    def _discover(self) -> None:
        """Subscribe to topics of wheels as they appear, before the first sample comes."""
        for topic, _ in self.get_topic_names_and_types():
            wheel, _, name = topic.removeprefix(self.get_namespace()).strip("/").rpartition("/")
            if name not in TOPICS or topic in self._listening or not self.count_publishers(topic):
                continue  # a topic that nobody publishes is one that somebody would hear
            if "truth" not in wheel.split("/"):
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

    def title(self, name: str) -> str:
        """Return a name with message time, vehicle speed and grip."""
        return f"{name}   t = {self.time:6.2f} s   v = {number(self.speed, '5.2f')} m/s{self.grip}"

    @property
    def grip(self) -> str:
        """Friction used and proven, to be appended to a line; empty before the first message."""
        if self._grip is None:
            return ""
        used, proven = number(self._grip.vehicle.mu_used, ".2f"), number(self._grip.mu_proven, ".2f")
        return f"   µ used {used}, proven {proven}"

    def header(self) -> str:
        """Return the header of the lines."""
        return f"  t [s]  v [m/s]  {'  '.join(f'{wheel:{_LINE_CELL}}' for wheel in self._real_wheels)}"

    def line(self) -> str:
        """Return the wheels as one line: slip, slope and peak; of a single wheel the supervisor's state too."""
        cells = []
        for view in self._real_wheels.values():
            if "slip" in view.messages or _FORCE not in view.messages:
                peak = [view.number(_CURVE, "lambda_max", ".3f"), view.number(_CURVE, "mu_max", ".2f")]
                slip = view.number("slip", "slip", ".3f")
                cells.append("slip {:>6} slope {} λ {:>5} µ {:>4}".format(slip, view.sign.plain, *peak))
            else:
                forces = [view.number(_FORCE, name, ".2f", 1e-3) for name in ("fx", "fz")]
                cells.append("Fx {:>6} Fz {:>5} kN".format(*forces).ljust(_LINE_CELL))
        if len(cells) == 1:
            pressure = view.number("brake_pressure", "fluid_pressure", ".1f", 1e-5)
            cells.append(f"{view.state.plain:11}  {view.command:8}  {pressure:>6} bar")
        return f"{self.time:7.2f}  {number(self.speed, '7.2f'):>7}  {'  '.join(cells)}"


def _is_valid(message: Any) -> bool:
    return not hasattr(message, "validity") or message.validity.valid


def number(value: float, form: str) -> str:
    """Return a number as text, a dash where it is not finite."""
    return f"{value:{form}}" if isfinite(value) else "–"


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
    _Column("slip", lambda view: view.number("slip", "slip", ".3f")),
    _Column("sign", lambda view: view.sign),
    _Column("state", lambda view: view.state),
    _Column("command", lambda view: _with_release(view)),
    _Column("p [bar]", lambda view: view.number("brake_pressure", "fluid_pressure", ".1f", 1e-5), 100),
    _Column("µ_max", lambda view: view.number(_CURVE, "mu_max", ".2f"), 0, 100),
    _Column("µ_max", lambda view: _with_interval(view, _CURVE, "mu_max", ".2f"), 100),
    _Column("λ_max", lambda view: view.number(_CURVE, "lambda_max", ".3f"), 0, 100),
    _Column("λ_max", lambda view: _with_interval(view, _CURVE, "lambda_max", ".3f"), 100),
)
_FORCE_COLUMNS = (
    _Column("Fx [kN]", lambda view: view.number(_FORCE, "fx", ".2f", 1e-3), 0, 130),
    _Column("Fz [kN]", lambda view: view.number(_FORCE, "fz", ".2f", 1e-3), 0, 130),
    _Column("Fx [kN]", lambda view: _with_interval(view, _FORCE, "fx", ".2f", 1e-3), 130),
    _Column("Fz [kN]", lambda view: _with_interval(view, _FORCE, "fz", ".2f", 1e-3), 130),
)


def wheels_view(wheels: dict[str, WheelView], now: float, width: int, title: str) -> Group:
    """Return a table of all wheels, and below it a line for whatever is not valid or silent.

    Args:
        wheels: views of the wheels by name.
        now: present time of the steady clock [s], for the age of messages.
        width: of the terminal [characters].
        title: title of the table.
    """
    forces = any(_FORCE in view.messages for view in wheels.values())
    chosen = (*_COLUMNS, *(_FORCE_COLUMNS if forces else ()))
    columns = [each for each in chosen if each.from_width <= width < each.below_width]
    table = Table(title=escape(title), title_justify="left", box=None, collapse_padding=True, pad_edge=False)
    for heading in ("wheel", *(each.heading for each in columns), "age"):
        table.add_column(escape(heading), no_wrap=True)
    said: list[Text] = []
    for wheel, view in wheels.items():
        ages = {topic: now - arrival for topic, arrival in view.arrivals.items()}
        silent = [f"{topic} silent for {age:.1f} s" for topic, age in ages.items() if age > _STALE]
        youngest = min(ages.values(), default=float("inf"))
        table.add_row(
            wheel,
            *(each.cell(view) for each in columns),
            Text(f"{youngest:.1f} s", style="bold red" if youngest > _STALE else ""),
            style="dim" if youngest > _STALE else "",
        )
        reasons = (plain_reason(reason, wheel) for reason in view.reasons)
        said += [Text(f"{wheel}: {text}") for text in dict.fromkeys((*silent, *reasons, *_refused(view)))]
    if not wheels:
        table.caption = "no wheel yet: waiting for a topic such as front_left/slip on this ROS_DOMAIN_ID"
    return Group(table, *said)


def _with_release(view: WheelView) -> Text:
    """Return the command, and below it the verdict of the intervention if the law requests a release."""
    release = view.release
    return Text(view.command) if release.plain == "–" else Text.assemble(view.command, "\n", release)


def _refused(view: WheelView) -> list[str]:
    supervisor = view.messages.get("abs_supervisor")
    count = 0 if supervisor is None else supervisor.refused_releases
    return [f"releases refused so far: {count}"] if count else []


def _with_interval(view: WheelView, topic: str, name: str, form: str, scale: float = 1.0) -> str:
    value = view.number(topic, name, form, scale)
    return value if value == "–" else f"{value}±{view.number(topic, f'{name}_stddev', form, scale * INTERVAL_95)}"
