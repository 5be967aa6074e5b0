"""One step of a braked wheel on a known curve: equations (2.15) and (2.18), and a disturbance torque.

The wheel's pole grows as 1/v. The step is exact for the slope of friction at its beginning and for a car that slows
down steadily (exponential Euler), so it stays stable down to walking speed.
"""

from math import exp
from typing import Final

from abs_supervisor.law.road_curve import RoadCurve
from vehicle_models.vehicle import CornerParameters

_STIFFEST, _STEEPEST_FALL = 20.0, -1.0
"""Range of the exponent: beyond the peak the wheel's motion grows, but not without limit within a step."""
LEAST_SPEED: Final = 0.3
"""[m/s] slip is taken relative to a speed no lower."""


def slip_of(speed: float, rim_speed: float) -> float:
    """Slip [-] of a wheel at a speed of the car [m/s] and of its circumference [m/s]."""
    reference = max(speed, LEAST_SPEED)
    return (reference - rim_speed) / reference


def wheel_step(
    corner: CornerParameters,
    curve: RoadCurve,
    wheel_speed: float,
    speed: float,
    torque: float,
    disturbance: float,
    dt: float,
) -> tuple[float, float]:
    """Return wheel speed [rad/s] and speed of the car [m/s] after a step.

    Args:
        corner: the wheel.
        curve: the road.
        wheel_speed: at the beginning [rad/s].
        speed: of the car at the beginning [m/s].
        torque: of the brake over the step [N m], >= 0.
        disturbance: torque that the model leaves out [N m], positive in the direction of rolling.
        dt: step [s].
    """
    radius, load, inertia = corner.radius, corner.vertical_load, corner.inertia
    slip = slip_of(speed, radius * wheel_speed)
    force = load * curve.friction(slip)
    rate = (radius * force + disturbance - torque) / inertia
    pole = dt * load * curve.slope(slip) * radius**2 / (inertia * max(speed, LEAST_SPEED))
    x = min(max(pole, _STEEPEST_FALL), _STIFFEST)
    first = (1.0 - exp(-x)) / x if abs(x) > 1e-3 else 1.0 - 0.5 * x
    second = (1.0 - first) / x if abs(x) > 1e-3 else 0.5
    # The car slows down as well: with the wheel's own share (1 - slip) of that the slip stays.
    slowing = force / corner.mass
    change = rate * first - (1.0 - slip) * slowing / radius * x * second
    return max(wheel_speed + dt * change, 0.0), max(speed - dt * slowing, 0.0)
