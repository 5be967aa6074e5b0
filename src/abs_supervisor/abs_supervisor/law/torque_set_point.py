"""The brake torque that brings the slip to its set-point, and keeps it there."""

from typing import Final

from abs_supervisor.law.road_curve import RoadCurve
from abs_supervisor.law.wheel_observer import WheelState
from vehicle_models.single_corner import CornerParameters

_RATE: Final = 35.0
"""[1/s] with which an error of the wheel speed is to vanish."""
_FAR, _FAR_MARGIN = 1.5, 0.05
"""A slip beyond 1.5 set-points and 0.05 is far beyond."""
_RETURN: Final = 0.2
"""Of the torque at the set-point: by so much the torque stays below what the road gives, far beyond the peak."""
_SLOW, _SLOW_SHARE = 5.0, 0.96
"""Below this speed [m/s] the torque stays below this share of that at the peak."""


def steady_torque(corner: CornerParameters, curve: RoadCurve, slip: float) -> float:
    """Brake torque [N m] that holds a slip: r Fz mu + J (1 - slip) g mu / r, from (2.15) with omega_dot of that slip.

    An error of the brake's gain cancels, as the curve and this torque share it.
    """
    deceleration = corner.gravity * curve.friction(slip)
    held = corner.inertia * (1.0 - slip) * deceleration / corner.radius
    return corner.radius * corner.vertical_load * curve.friction(slip) + held


def torque_set_point(
    corner: CornerParameters, curve: RoadCurve, ahead: WheelState, slip: float, followed: float, disturbance: float
) -> float:
    """Return the brake torque [N m] to aim at, >= 0.

    Args:
        corner: the wheel.
        curve: the road.
        ahead: of wheel and brake when a command acts.
        slip: to hold [-].
        followed: part of the disturbance torque that is followed [N m].
        disturbance: all of it [N m].
    """
    steady = steady_torque(corner, curve, slip)
    wanted_speed = (1.0 - slip) * ahead.speed / corner.radius
    torque = max(steady + followed, 0.0) + corner.inertia * _RATE * (ahead.wheel_speed - wanted_speed)
    if ahead.slip > _FAR * slip + _FAR_MARGIN:
        road = corner.radius * corner.vertical_load * curve.friction(ahead.slip)
        torque = min(torque, road + disturbance - _RETURN * steady)
    if ahead.speed < _SLOW:
        peak = steady_torque(corner, curve, curve.lambda_max)
        torque = min(torque, _SLOW_SHARE * (peak + min(followed, 0.0)))
    return max(torque, 0.0)
