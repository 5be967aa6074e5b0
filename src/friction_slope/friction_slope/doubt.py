"""Uncertainty of H from errors of brake gain, inertia and pressure delay.

H is the small difference of two large terms, omega_ddot + T_b_dot / J. An error of brake gain or inertia by a share
adds that share of T_b_dot / J; a pressure that acts d later than the vehicle file says adds d T_b_ddot / J. While the
pressure rises, and where it turns, that is as much as the slope of the curve gives.
"""

from dataclasses import dataclass
from math import hypot

from vehicle_models.vehicle import Vehicle, absolute_deviation, relative_deviation


@dataclass(frozen=True)
class Doubt:
    """Standard deviations of what H takes for known."""

    share: float = 0.0
    """Of brake gain over inertia, relative, >= 0."""
    delay: float = 0.0
    """Of the delay of the pressure [s], >= 0."""

    def of_h(self, torque_rate: float, torque_jerk: float) -> float:
        """Standard deviation of H [rad/s^3] at T_b_dot / J [rad/s^3] and T_b_ddot / J [rad/s^4]."""
        return hypot(self.share * torque_rate, self.delay * torque_jerk)


def doubt_of(vehicle: Vehicle, wheel: str) -> Doubt:
    """Return the doubt of a wheel of a car, by the deviations of its vehicle file."""
    braked = vehicle.wheel(wheel)
    share = hypot(relative_deviation(braked, "brake_gain"), relative_deviation(braked, "inertia"))
    return Doubt(share, absolute_deviation(vehicle.deviations, "brake_pressure_delay"))
