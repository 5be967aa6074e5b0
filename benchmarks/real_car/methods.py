"""The estimators of all wheels of a car, by name: what is judged."""

from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.car import CarEstimator, CarSample
from friction_curve_id.interface import CurveEstimate, Refusal, Sample
from friction_curve_id.methods import DEFAULT, make_estimator
from vehicle_models.vehicle import Vehicle

Array = NDArray[np.float64]


class CarMethod(Protocol):
    """Friction curves of all wheels of a car without a speed sensor."""

    def update(
        self, time: float, wheel_speed: Array, brake_pressure: Array, acceleration: float
    ) -> Sequence[CurveEstimate | Refusal]:
        """Take the next sample [s, rad/s, Pa, m/s^2]; return an answer for each wheel, in the order of the wheels."""


class WheelByWheel:
    """One estimator for each wheel, with its share of the nominal car; the acceleration is not used."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Make them of method `default` with their shipped parameters."""
        self._gains = [wheel.brake_gain for wheel in vehicle.wheels]
        self._estimators = [make_estimator(DEFAULT, vehicle.corner(name)) for name in vehicle.wheel_names]

    def update(
        self, time: float, wheel_speed: Array, brake_pressure: Array, acceleration: float
    ) -> Sequence[CurveEstimate | Refusal]:
        """See CarMethod."""
        del acceleration
        parts = zip(self._estimators, self._gains, wheel_speed, brake_pressure, strict=True)
        return [
            estimator.update(Sample(time, float(omega), None, gain * float(pressure)))
            for estimator, gain, omega, pressure in parts
        ]


class WholeCar:
    """friction_curve_id.car: all wheels at once."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Make it with its shipped parameters."""
        self._estimator = CarEstimator(vehicle)

    def update(
        self, time: float, wheel_speed: Array, brake_pressure: Array, acceleration: float
    ) -> Sequence[CurveEstimate | Refusal]:
        """See CarMethod."""
        return self._estimator.update(CarSample(time, wheel_speed, brake_pressure, acceleration))


METHODS: dict[str, Callable[[Vehicle], CarMethod]] = {DEFAULT: WheelByWheel, "car": WholeCar}
"""What may be judged."""
