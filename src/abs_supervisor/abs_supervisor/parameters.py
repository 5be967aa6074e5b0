"""Parameters of abs_supervisor, of the node, the bag runner and the parameter file; detection of braking."""

from collections.abc import Mapping
from dataclasses import dataclass

from abs_supervisor.axle import NO_AXLE, SELECT_LOW
from abs_supervisor.state_machine import Thresholds
from friction_parameters.generated import ShippedFile
from friction_parameters.parameter import constant, deadline_parameter, group, parameter
from friction_runtime.filters import Debounce
from vehicle_models.brake_actuator import ActuatorParameters
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle_file import vehicle_file_parameter

SLOPE_SIGN, CURVE = "slope_sign", "curve"


@dataclass(frozen=True)
class PressureParameters:
    """When braking is over, judged by the wheel's own brake pressure."""

    release_torque: float = parameter(
        20.0, "braking is over some time below this torque", unit="N m", minimum=0.0, maximum=1e4, read_only=True
    )
    release_hold: float = constant(0.2, "that time, longer than the supervisor's own release", unit="s")


class TorqueWithHysteresis:
    """Whether the driver brakes, from the wheel's own torque; for a car without a demand topic.

    The supervisor's release takes that torque to zero. So braking begins at the upper threshold, and is over when the
    torque has been below the lower one for the hold time, which is longer than a release.
    """

    def __init__(self, begin: float, end: PressureParameters) -> None:
        """Start not braking; it begins at the torque `begin`, T-bar [N m], above the release torque of `end`."""
        self._begin, self._end = begin, end.release_torque
        self._below = Debounce(round(end.release_hold * NANOSECONDS))
        self.reset()

    def reset(self) -> None:
        """Forget the past."""
        self._braking = False
        self._below.reset()

    def update(self, stamp: int, torque: float) -> bool:
        """Take the torque [N m] at a stamp [ns]; return whether the driver brakes."""
        over = self._below.update(stamp, torque < self._end)
        self._braking = torque >= self._begin or (self._braking and not over)
        return self._braking


@dataclass(frozen=True)
class SupervisorParameters:
    """Parameters of the node."""

    vehicle_file: str = vehicle_file_parameter()
    shadow: bool = parameter(True, "publish the state, never a command", read_only=True)
    real_time: bool = parameter(
        True,
        "stamps progress with the steady clock, an input whose stamps do not is lost; false for a plant in lock-step",
        read_only=True,
    )
    valid_for: float = parameter(
        0.1, "validity of a command after its stamp", unit="s", minimum=0.02, maximum=1.0, read_only=True
    )
    law: str = parameter(
        SLOPE_SIGN,
        "controller: the state machine on the slope sign, or slip control on the identified curve",
        choices=(SLOPE_SIGN, CURVE),
        read_only=True,
    )
    select_low: str = parameter(
        NO_AXLE,
        "axle whose wheels both get the pressure of the one with less grip",
        choices=SELECT_LOW,
        read_only=True,
    )
    speed_probe: bool = parameter(
        True,
        "brake one rear wheel less for a moment, where the speed of the car is unsure in a long slide",
        read_only=True,
    )
    braking_source: str = parameter(
        "demand",
        "signal of the driver's braking: brake_demand, or <wheel>/brake_pressure with hysteresis",
        choices=("demand", "pressure"),
        read_only=True,
    )
    braking_torque: float = parameter(
        50.0, "T-bar: braking begins at this torque", unit="N m", minimum=1.0, maximum=1e4, read_only=True
    )
    pressure: PressureParameters = group(PressureParameters(), selector="braking_source", methods=("pressure",))
    thresholds: Thresholds = group(Thresholds())
    actuator: ActuatorParameters = group(ActuatorParameters())
    tolerance: float = parameter(
        0.02,
        "message time of invalid input after which the fail-safe acts",
        unit="s",
        minimum=0.0,
        maximum=1.0,
        read_only=True,
    )
    stale_after: float = parameter(
        0.1,
        "silence of the votes (steady clock) after which the fail-safe acts, with 'shadow' or without 'real_time'",
        unit="s",
        minimum=0.02,
        maximum=60.0,
        read_only=True,
    )
    demand_timeout: float = constant(0.08, "demand or pressure is held this long where no newer one comes", unit="s")
    deadline: float = deadline_parameter(0.02, read_only=True)

    def __post_init__(self) -> None:
        """Refuse a hysteresis whose thresholds are in the wrong order."""
        if self.braking_source == "pressure" and not self.pressure.release_torque < self.braking_torque:
            raise ValueError(
                f"parameter 'pressure.release_torque' = {self.pressure.release_torque} must be below "
                f"'braking_torque' = {self.braking_torque}"
            )


SHIPPED: Mapping[str, ShippedFile] = {
    "abs_supervisor": ShippedFile(
        "One set for all roads; it goes with VoteTuning of friction_slope.\n"
        "No shipped file commands a brake: the README describes how to do it on purpose.",
        SupervisorParameters(),
    ),
}
