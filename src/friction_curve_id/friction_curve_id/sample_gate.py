"""Gate of the samples of a fit: finite, in order of time, moving, without a gap."""

from dataclasses import dataclass
from math import isfinite

from friction_curve_id.interface import Refusal, Sample
from friction_curve_id.stamp_order import Admission, StampOrder
from friction_parameters.parameter import constant, minimum_speed_parameter
from vehicle_models.reason import Reason


@dataclass(frozen=True)
class GateParameters:
    """Limits for samples that may enter a fit."""

    minimum_speed: float = minimum_speed_parameter(3.0)
    max_gap: float = constant(0.025, "longest time between two samples of an input that is bridged", unit="s")


class SampleGate:
    """Admits samples one by one, see StampOrder for their stamps."""

    def __init__(self, radius: float, parameters: GateParameters = GateParameters()) -> None:
        """Make a gate for a wheel of effective radius `radius` [m]."""
        self._radius = radius
        self._parameters = parameters
        self._order = StampOrder(parameters.max_gap)

    def reset(self) -> None:
        """Forget the stamps seen."""
        self._order.reset()

    def admit(self, sample: Sample) -> Admission | Refusal:
        """Return how `sample` follows the admitted ones, or why it must not enter."""
        refusal = self._refuse_values(sample)
        return self._order.admit(sample.time) if refusal is None else refusal

    def _refuse_values(self, sample: Sample) -> Refusal | None:
        speed, torque = sample.vehicle_speed, sample.brake_torque
        if torque is None:
            return Refusal(Reason.NO_PRESSURE, "brake torque is missing")
        if not (isfinite(sample.time) and isfinite(sample.wheel_speed) and isfinite(torque)):
            values = {"time": sample.time, "wheel speed": sample.wheel_speed, "brake torque": torque}
            bad = next(f"{name} is {value}" for name, value in values.items() if not isfinite(value))
            return Refusal(Reason.BAD_INPUT, bad)
        if sample.wheel_speed <= 0.0:
            return Refusal(Reason.LOW_SPEED, f"wheel speed {sample.wheel_speed:.3g} rad/s is not positive")
        if speed is None:
            return None
        if not isfinite(speed):
            return Refusal(Reason.BAD_INPUT, f"vehicle speed is {speed}")
        limit = self._parameters.minimum_speed
        if speed < limit:
            return Refusal(Reason.LOW_SPEED, f"vehicle speed {speed:.2f} m/s is below {limit:.2f} m/s")
        slip = 1.0 - sample.wheel_speed * self._radius / speed
        if not -1.0 < slip < 1.0:
            return Refusal(Reason.NO_SLIP, f"slip {slip:.2f} is outside (-1, 1)")
        return None
