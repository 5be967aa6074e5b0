"""Requirements of the single-wheel methods on the vehicle file: which values are not exact.

The methods of the chapter reckon with one wheel and its share of the car, and with torque, mass and radius as if they
were exact: their intervals hold where that is so, and miss the truth where it is not.
"""

from friction_curve_id.interface import CurveEstimate, CurveEstimator, Refusal, Sample
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Deviations, Vehicle

_OF_WHEEL = ("radius", "inertia", "brake_gain")
_OF_CAR = ("mass", "brake_pressure_delay")


def not_known(vehicle: Vehicle) -> str:
    """Return what is not known exactly or moves the load of a wheel, in words; empty where there is nothing.

    Known exactly is what the vehicle file gives a standard deviation of zero. What it gives none is not known.
    """
    for name in _OF_CAR:
        if not _exact(vehicle.deviations, name):
            return _text(name, vehicle.deviations)
    for wheel in vehicle.wheels:
        for name in _OF_WHEEL:
            if not _exact(wheel.deviations, name):
                return f"{_text(name, wheel.deviations)}, at {wheel.name}"
    if any(wheel.driven for wheel in vehicle.wheels):
        if not _exact(vehicle.deviations, "engine_drag_torque"):
            return _text("engine_drag_torque", vehicle.deviations)
        if vehicle.engine_drag_torque > 0.0:
            return "the engine brakes too"
    if any(vehicle.transfer_shares):
        return "braking moves load between the axles"
    return ""


class InexactVehicle:
    """CurveEstimator of one wheel of a vehicle that is not known exactly: its curves are never valid."""

    def __init__(self, estimator: CurveEstimator, unknown: str) -> None:
        """Wrap the estimator; `unknown` is what `not_known` returned."""
        self._estimator = estimator
        self._text = f"{unknown}: the interval does not count that, method 'car' does"

    def update(self, sample: Sample) -> CurveEstimate | Refusal:
        """Take the next sample; never raises on bad data."""
        answer = self._estimator.update(sample)
        if isinstance(answer, CurveEstimate) and answer.valid:
            return answer._replace(reason=Reason.UNKNOWN_CAR, text=self._text)
        return answer

    def reset(self) -> None:
        """Forget everything; the next estimate reports a restart on request."""
        self._estimator.reset()


def _exact(deviations: Deviations, name: str) -> bool:
    return name in deviations and deviations[name].stddev == 0.0


def _text(name: str, deviations: Deviations) -> str:
    stated = f"has the stddev {deviations[name].stddev:.3g}" if name in deviations else "has no stddev"
    return f"'{name}' {stated} in the vehicle file"
