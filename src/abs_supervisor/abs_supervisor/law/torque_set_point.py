"""The brake torque that brings the slip to its set-point, and keeps it there."""

from math import sqrt
from typing import Final

from abs_supervisor.law.road_curve import RoadCurve
from abs_supervisor.law.wheel_observer import WheelState
from vehicle_models.brake_actuator import ActuatorParameters
from vehicle_models.vehicle import CornerParameters

_RATE: Final = 35.0
"""[1/s] with which a small error of the wheel speed is to vanish."""
_SOFT: Final = 8.0
"""[m/s] Below this speed it vanishes more slowly: the tyre needs its relaxation length to answer, and slip is vague."""
_FAR, _FAR_MARGIN = 1.5, 0.05
"""A slip beyond 1.5 set-points and 0.05 is far beyond."""
_RETURN: Final = 0.2
"""Of the torque at the set-point: by so much the torque stays below what the road gives, far beyond the peak."""
_SLOW, _SLOWEST, _SLOW_SHARE = 5.0, 3.0, 0.96
"""From the first speed [m/s] on the torque stays below a share of that at the peak, which falls to this at the second:
a step would make a tyre with relaxation ring."""


def steady_torque(corner: CornerParameters, curve: RoadCurve, slip: float) -> float:
    """Brake torque [N m] that holds a slip: r Fz mu + J (1 - slip) g mu / r, from (2.15) with omega_dot of that slip.

    An error of the brake's gain cancels, as the curve and this torque share it.
    """
    deceleration = corner.gravity * curve.friction(slip)
    held = corner.inertia * (1.0 - slip) * deceleration / corner.radius
    return corner.radius * corner.vertical_load * curve.friction(slip) + held


def torque_set_point(
    corner: CornerParameters,
    actuator: ActuatorParameters,
    curve: RoadCurve,
    ahead: WheelState,
    slip: float,
    followed: float,
    disturbance: float,
) -> float:
    """Return the brake torque [N m] to aim at, >= 0.

    Args:
        corner: the wheel.
        actuator: its hydraulics.
        curve: the road.
        ahead: of wheel and brake when a command acts.
        slip: to hold [-].
        followed: part of the disturbance torque that is followed [N m].
        disturbance: all of it [N m].
    """
    steady = steady_torque(corner, curve, slip)
    wanted_speed = (1.0 - slip) * ahead.speed / corner.radius
    error = ahead.wheel_speed - wanted_speed
    torque = max(steady + followed, 0.0) + corner.inertia * _approach(corner, actuator, error, ahead.speed)
    if ahead.slip > _FAR * slip + _FAR_MARGIN:
        road = corner.radius * corner.vertical_load * curve.friction(ahead.slip)
        torque = min(torque, road + disturbance - _RETURN * steady)
    if ahead.speed < _SLOW:
        torque = min(torque, most_torque(corner, curve, ahead.speed, followed))
    return max(torque, 0.0)


def most_torque(corner: CornerParameters, curve: RoadCurve, speed: float, followed: float) -> float:
    """Return the most brake torque [N m] near the end of a stop, at a speed of the car [m/s] up to 5 m/s.

    `followed` [N m] as above.
    """
    peak = steady_torque(corner, curve, curve.lambda_max)
    share = max((speed - _SLOWEST) / (_SLOW - _SLOWEST), 0.0)
    return (_SLOW_SHARE + (1.0 - _SLOW_SHARE) * share) * (peak + min(followed, 0.0))


def _approach(corner: CornerParameters, actuator: ActuatorParameters, error: float, speed: float) -> float:
    """Return how fast an error of the wheel speed [rad/s] is to vanish [rad/s^2], at a speed of the car [m/s].

    In proportion where it is small; where it is large, as fast as the brake can end with its own rate: what moves the
    wheel by a takes J a / rate to go, and the wheel moves by J a^2 / (2 rate) meanwhile.
    """
    brake = actuator.apply_rate if error < 0.0 else actuator.release_rate
    fastest = sqrt(2.0 * brake * abs(error) / corner.inertia)
    small = _RATE * min(speed / _SOFT, 1.0) * error
    return min(max(small, -fastest), fastest)
