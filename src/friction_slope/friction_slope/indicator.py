"""Indicator of the slope: H and the sign of the slip rate, measured (8.4) or replaced by that of eta (8.5).

eta = -omega_dot r / g takes the place of the slip rate in (8.5). By (8.6),

    slip_rate = (g / v) (eta - (1 - slip) b),    b = -v_dot / g

so the two signs differ exactly between 0 and (1 - slip) b, which is below 0 where engine or hill pull the car. The
braking b of the car is measured where it has an accelerometer. Without one all wheels are taken to be at the friction
of this one, b = mu = (J omega_dot + T_b) / (r Fz). So this interval can be left out as a dead zone. Above it, eta
stands for a slip rate of at least (g / v)(eta - b): the dead zone of the slip rate adds v / g times itself.

H is the small difference of two large terms, omega_ddot + T_b_dot / J. An error of brake gain or inertia by a share
adds that share of T_b_dot / J; a pressure that acts d later than the vehicle file says adds d T_b_ddot / J. While the
pressure rises, and where it turns, that is as much as the slope of the curve gives.
"""

from dataclasses import dataclass
from math import hypot

from vehicle_models.constants import GRAVITY
from vehicle_models.vehicle import Vehicle, absolute_deviation, relative_deviation


def slope_indicator(h: float, growing: int) -> float:
    """Indicator [rad/s^3], whose sign is that of the slope mu_1 of the friction curve.

        method slip:     sign(mu_1) = sign(H) sign(slip_rate)    (8.4)
        method no_slip:  sign(mu_1) = sign(H) sign(eta)          (8.5)

    Args:
        h: H of (8.3) [rad/s^3].
        growing: sign of the slip rate (`slip_rate_sign`) or of eta (`eta_sign`): +1, -1, or 0 in its dead zone.
    """
    return h * growing


def normalised_deceleration(wheel_acceleration: float, radius: float) -> float:
    """eta of (8.5), -omega_dot r / g [-], positive in braking; omega_dot [rad/s^2], r [m]."""
    return -wheel_acceleration * radius / GRAVITY


def slip_rate_sign(slip_rate: float, dead_zone: float) -> int:
    """Sign of the slip rate [1/s] for (8.4); 0 within the dead zone (>= 0) and for NaN."""
    if slip_rate > dead_zone:
        return 1
    return -1 if slip_rate < -dead_zone else 0


def eta_sign(eta: float, braking: float, margin: float, dead_zone: float, speed: float) -> int:
    """Sign of the slip rate as far as eta determines it by (8.6), for (8.5).

    Args:
        eta: normalised wheel deceleration [-].
        braking: deceleration of the car over g [-].
        margin: distance by which eta must lie outside the interval between 0 and braking [-], >= 0, for its noise.
        dead_zone: slip rates up to it [1/s], >= 0, do not count as growing.
        speed: vehicle speed, or an upper bound of it [m/s].

    Returns:
        +1 above the interval, -1 below it, 0 within.
    """
    if eta > max(braking, 0.0) + margin + dead_zone * speed / GRAVITY:
        return 1
    return -1 if eta < min(braking, 0.0) - margin else 0


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
