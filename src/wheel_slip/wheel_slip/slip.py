"""Slip and its rate, with their first-order variances. Braking slip is positive.

slip = (v - omega r) / v,    slip_rate = (r / v) (omega v_dot / v - omega_dot)

The variances take speed, wheel speed and their rates as independent, which they are while the speed does not come from
the wheel itself, and which is on the safe side while it does.
"""


def slip(speed: float, wheel_speed: float, radius: float) -> float:
    """Slip [-] at vehicle speed [m/s] (not 0), wheel speed [rad/s] and radius [m]."""
    return (speed - wheel_speed * radius) / speed


def slip_variance(
    speed: float,
    speed_variance: float,
    wheel_speed: float,
    wheel_speed_variance: float,
    radius: float,
    radius_variance: float = 0.0,
    covariance: float = 0.0,
) -> float:
    """Variance [-] of slip from those of the speed [m^2/s^2], the wheel speed [rad^2/s^2] and the radius.

    The radius' is that of its error as a share [-], and `covariance` that of this and the speed [m/s]: what a speed has
    of a wheel's radius is not in the slip of this wheel.
    """
    by_speed = wheel_speed * radius / speed**2
    by_wheel = radius / speed
    of_both = by_speed**2 * speed_variance + (by_speed * speed) ** 2 * (radius_variance - 2.0 * covariance / speed)
    return max(of_both, 0.0) + by_wheel**2 * wheel_speed_variance


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
