"""Estimates of every wheel in, friction_state out: one message for each stamp of wheel_states."""

from collections.abc import Mapping
from math import nan
from typing import Any, Final

from friction_msgs.msg import (
    FrictionCurve,
    FrictionSlope,
    FrictionState,
    SupervisorState,
    TyreForce,
    WheelSlip,
    WheelState,
)
from sensor_msgs.msg import JointState
from visualization_msgs.msg import MarkerArray

from friction_runtime.aligned_processor import AlignedProcessor, Primary
from friction_runtime.aligner import AlignedInput, AlignedSample
from friction_runtime.messages import header_at, to_nanoseconds
from friction_runtime.processor import Level, Output, Report, silent
from friction_runtime.wheel_inputs import WHEEL_STATES
from friction_state.history import History
from friction_state.parameters import FrictionStateParameters
from friction_state.ros.force_markers import force_markers
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import Vehicle

FRICTION_STATE: Final = "friction_state"
FORCE_MARKERS: Final = "force_markers"
_MARKER_PERIOD: Final = NANOSECONDS // 20
"""Time between markers [ns]: as often as an eye can use."""
_FORCE: Final = "tyre_force"
_TYPES: Final[Mapping[str, type]] = {
    "slip": WheelSlip,
    "friction_slope": FrictionSlope,
    "friction_curve": FrictionCurve,
    "abs_supervisor": SupervisorState,
    _FORCE: TyreForce,
}
"""Estimates of a wheel."""
_HELD: Final = (_FORCE, "friction_curve")
"""Estimates that count for a while: forces, and curves fitted to them, come once per revolution."""
_FIELDS: Final[Mapping[str, Mapping[str, str]]] = {
    "slip": {"slip": "slip", "slip_stddev": "slip_stddev"},
    "friction_slope": {"slope_sign": "sign"},
    "friction_curve": {name: name for name in ("lambda_max", "lambda_max_stddev", "mu_max", "mu_max_stddev")},
    "abs_supervisor": {"supervisor_state": "state", "command": "command"},
    _FORCE: {name: name for name in ("fx", "fx_stddev", "fz", "fz_stddev")},
}
"""Fields of WheelState and those of the estimate they are taken from."""
_VALID: Final[Mapping[str, str]] = {
    "slip": "slip_valid",
    "friction_slope": "slope_valid",
    "friction_curve": "curve_valid",
    "abs_supervisor": "supervisor_valid",
    _FORCE: "force_valid",
}
"""Field of WheelState with the validity of an estimate."""
_UNKNOWN: Final[Mapping[str, int]] = {
    "slope_sign": 0,
    "supervisor_state": int(WheelState.UNKNOWN),
    "command": int(WheelState.UNKNOWN),
}
"""Values of fields without an estimate; NaN for all others."""
_FIRST_ANSWER: Final = round(1.0 * NANOSECONDS)
"""Time since the first sample from which an estimator that has never answered is not waited for [ns]."""


class StateProcessor(AlignedProcessor[None]):
    """Layer 2 of friction_state: fires on wheel_states once every estimator that runs has answered its stamp."""

    def __init__(self, vehicle: Vehicle, parameters: FrictionStateParameters, report: Report = silent) -> None:
        """Build for a vehicle; `report` is the log function."""
        self._p = parameters
        self._wheels = vehicle.wheel_names
        self.sensors: Mapping[str, type] = {WHEEL_STATES: JointState}
        self.estimates: Mapping[str, type] = {
            f"{wheel}/{name}": kind for wheel in self._wheels for name, kind in _TYPES.items()
        }
        self._vehicle = vehicle
        self.outputs: Mapping[str, type] = {FRICTION_STATE: FrictionState}
        if parameters.publish_markers:
            self.outputs = {**self.outputs, FORCE_MARKERS: MarkerArray}
        self._aligned = tuple(topic for topic in self.estimates if not topic.endswith(_FORCE))
        primary = Primary(WHEEL_STATES, "vehicle", report)
        aligned = [AlignedInput(topic) for topic in self._aligned]
        super().__init__("vehicle", primary, aligned, parameters.deadline, optional=tuple(self.estimates))
        self._forget()

    def _forget(self) -> None:
        self._first: int | None = None
        self._unheard = set(self._aligned)
        self._stood_in: dict[str, int] = {}
        self._histories: dict[str, History[Any]] = {topic: History() for topic in self.estimates}
        self._known: dict[str, int] = {}
        self._last_marked: int | None = None

    def _payload(self, message: JointState) -> None:
        stamp = to_nanoseconds(message.header.stamp)
        if self._first is None or stamp < self._first:
            self._first = stamp
        if stamp - self._first > _FIRST_ANSWER:
            for topic in self._unheard:  # an empty answer in place of an estimator that does not run
                self._aligner.offer(topic, stamp, ())
                self._stood_in[topic] = stamp

    def _take(self, topic: str, message: Any) -> str | None:
        stamp = to_nanoseconds(message.header.stamp)
        self._histories[topic].put(stamp, message)
        if topic not in self._aligned:
            return None
        self._unheard.discard(topic)
        stood_in = self._stood_in.get(topic)
        if stood_in is not None and stamp <= stood_in:
            return None
        self._stood_in.pop(topic, None)
        return self._aligner.offer(topic, stamp, ())

    def _start_again(self, stamp: int) -> None:
        """Keep everything: a history forgets what lies before a jump back when its own topic jumps."""

    def _state(self) -> tuple[Level, str]:
        if len(self._unheard) == len(self._aligned):
            return Level.WARN, "no estimate of any wheel yet"
        return Level.OK, ""

    def _values(self) -> dict[str, str]:
        return {f"wheels with {name}": str(count) for name, count in self._known.items()}

    def _fire(self, sample: AlignedSample[None]) -> list[Output]:
        self._known = dict.fromkeys(_TYPES, 0)
        message = FrictionState(header=header_at(sample.stamp, "base_link"))
        message.wheels = [self._wheel_state(wheel, sample.stamp) for wheel in self._wheels]
        outputs: list[Output] = [(FRICTION_STATE, message)]
        if self._p.publish_markers and sample.stamp // _MARKER_PERIOD != self._last_marked:
            self._last_marked = sample.stamp // _MARKER_PERIOD
            outputs.append((FORCE_MARKERS, force_markers(message, self._vehicle)))
        return outputs

    def _wheel_state(self, wheel: str, stamp: int) -> WheelState:
        state = WheelState(wheel=wheel)
        for name, fields in _FIELDS.items():
            timeout = self._p.hold if name in _HELD else 0.0
            estimate = self._histories[f"{wheel}/{name}"].at(stamp, timeout)
            self._known[name] += estimate is not None
            setattr(state, _VALID[name], estimate is not None and estimate.validity.valid)
            for field, source in fields.items():
                value = _UNKNOWN.get(field, nan) if estimate is None else getattr(estimate, source)
                setattr(state, field, value)
        return state


def build(parameters: FrictionStateParameters, vehicle: Vehicle, report: Report = silent) -> list[StateProcessor]:
    """Make the processors: one for the whole vehicle."""
    return [StateProcessor(vehicle, parameters, report)]
