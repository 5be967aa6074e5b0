"""Reference forces of one wheel from the motion of the car: static load and mass times acceleration.

In braking the wheels share by gain times pressure: pressures rise alike whatever the gains, and ABS changes each.
"""

from collections.abc import Mapping
from math import hypot, nan

from vehicle_models.constants import GRAVITY
from vehicle_models.vehicle import FRONT, REAR, Vehicle, Wheel, absolute_deviation, mass_deviation, relative_deviation
from vehicle_models.wheel_forces import WheelForces, drag, wheel_forces

_DRIVING_STDDEV = 0.02
"""Relative deviation of what the engine gives to one of the driven wheels."""


class Reference:
    """Reference of one wheel. Deviations are relative, and the same for all revolutions."""

    def __init__(self, car: Vehicle, wheel: Wheel) -> None:
        """Take the vehicle file's values and deviations, or the defaults for those that it does not state."""
        self._car, self._axle, self._wheel = car, wheel.axle, wheel.name
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

    def share(self, speed: float, acceleration: float, torques: Mapping[str, float]) -> float | None:
        """Return Fx of the wheel [N], forward positive; None in braking where a torque is not known.

        Args:
            speed: of the car [m/s].
            acceleration: of the car [m/s^2], forward positive.
            torques: of the brakes by the wheel [N m]; those that are not known are missing.
        """
        free = wheel_forces(self._car, speed, acceleration)
        rear = self._axle == REAR
        braking = self._car.mass * acceleration + float(drag(self._car, speed)) + 2.0 * self._rolling(free)
        if braking >= 0.0:
            return float(free.fx_rear if rear else free.fx_front)
        forces = {w.name: torques.get(w.name, nan) / w.radius for w in self._car.wheels}
        total = sum(forces.values())
        if not total > 0.0:
            return None
        return braking * forces[self._wheel] / total - self._car.rolling_resistance * float(
            free.fz_rear if rear else free.fz_front
        )

    def _rolling(self, forces: WheelForces) -> float:
        """Return the rolling resistance of one side [N]."""
        return self._car.rolling_resistance * float(forces.fz_front + forces.fz_rear)
