"""Reference forces of one wheel from the motion of the car: static load and mass times acceleration."""

from math import hypot

from vehicle_models.constants import GRAVITY
from vehicle_models.vehicle import FRONT, REAR, Vehicle, Wheel, absolute_deviation, mass_deviation, relative_deviation
from vehicle_models.wheel_forces import wheel_forces

_DRIVING_STDDEV = 0.02
"""Relative deviation of what the engine gives to one of the driven wheels."""


class Reference:
    """Reference of one wheel. Deviations are relative, and the same for all revolutions."""

    def __init__(self, car: Vehicle, wheel: Wheel) -> None:
        """Take the vehicle file's values and deviations, or the defaults for those that it does not state."""
        self._car, self._axle = car, wheel.axle
        self.static_load = car.corner(wheel.name).vertical_load
        """[N]"""
        mass = mass_deviation(car)
        front = car.front_load_share
        share = front if wheel.axle == FRONT else 1.0 - front
        moved = absolute_deviation(car.deviations, "front_load_share") / share if front < 1.0 else 0.0
        self.load_stddev = hypot(mass, moved)
        """Of the static load."""
        mounting = car.accelerometer.deviations
        pitch = GRAVITY * absolute_deviation(mounting, "pitch_gain")
        self.common_stddev = hypot(mass, absolute_deviation(mounting, "scale"), pitch)
        """Of mass times acceleration."""
        self.driving_stddev = _DRIVING_STDDEV
        """Of the wheel's share in driving."""
        gains = {axle: sum(w.brake_gain for w in car.wheels if w.axle == axle) for axle in (FRONT, REAR)}
        other = 1.0 - gains[wheel.axle] / sum(gains.values())
        self.braking_stddev = other * 2.0**0.5 * relative_deviation(wheel, "brake_gain")
        """Of the wheel's share in braking, where the gains of the axles err independently."""

    @property
    def has_share(self) -> bool:
        """Whether the car has the wheels of which it is known who brakes and who drives."""
        return len(self._car.wheels) == 4 and any(wheel.driven for wheel in self._car.wheels)

    def share(self, speed: float, acceleration: float) -> float:
        """Return Fx of the wheel [N] at a speed [m/s] and an acceleration [m/s^2] of the car, forward positive."""
        found = wheel_forces(self._car, speed, acceleration)
        return float(found.fx_rear if self._axle == REAR else found.fx_front)
