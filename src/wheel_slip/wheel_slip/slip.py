"""Slip and its rate, with their first-order variances. Braking slip is positive.

slip = (v - omega r) / v,    slip_rate = (r / v) (omega v_dot / v - omega_dot)

The variances take speed, wheel speed and their rates as independent, which they are while the speed does not come from
the wheel itself, and which is on the safe side while it does. Only the error of its radius is known to be in both.
"""


def slip(speed: float, wheel_speed: float, radius: float) -> float:
    """Slip [-] at vehicle speed [m/s] (not 0), wheel speed [rad/s] and radius [m]."""
    return (speed - wheel_speed * radius) / speed


def slip_variance(
    speed: tuple[float, float], wheel_speed: tuple[float, float], radius: tuple[float, float], covariance: float
) -> float:
    """Variance [-] of slip.

    Args:
        speed: of the ground at the wheel [m/s], and its variance [m^2/s^2].
        wheel_speed: [rad/s], and its variance [rad^2/s^2].
        radius: [m], and the variance of its error as a share.
        covariance: of speed and radius error [m/s]: that of a speed which wheels gave is in the slip of none of them.
    """
    turned = wheel_speed[0] * radius[0] / speed[0]
    of_share = speed[1] / speed[0] ** 2 + radius[1] - 2.0 * covariance / speed[0]
    return turned**2 * max(of_share, 0.0) + (radius[0] / speed[0]) ** 2 * wheel_speed[1]


def slip_rate(speed: float, acceleration: float, wheel_speed: float, wheel_acceleration: float, radius: float) -> float:
    """Slip rate [1/s] from speeds and their rates [m/s, m/s^2, rad/s, rad/s^2]."""
    return radius / speed * (wheel_speed * acceleration / speed - wheel_acceleration)


def slip_rate_variance(
    speed: tuple[float, float],
    acceleration: tuple[float, float],
    wheel_speed: tuple[float, float],
    wheel_acceleration: tuple[float, float],
    radius: float,
) -> float:
    """Variance [1/s^2] of slip_rate; each argument is (value, variance), in the units of slip_rate."""
    v, a, omega = speed[0], acceleration[0], wheel_speed[0]
    by_speed = radius / v**2 * (wheel_acceleration[0] - 2.0 * omega * a / v)
    by_acceleration = radius * omega / v**2
    by_wheel = radius * a / v**2
    by_wheel_acceleration = radius / v
    return (
        by_speed**2 * speed[1]
        + by_acceleration**2 * acceleration[1]
        + by_wheel**2 * wheel_speed[1]
        + by_wheel_acceleration**2 * wheel_acceleration[1]
    )
