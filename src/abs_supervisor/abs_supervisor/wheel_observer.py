"""Wheel observer, and prediction to the time at which a command given now acts.

The brake torque follows the orders and is drawn to the measured pressure. The wheel follows the curve under it; what
it does otherwise is a disturbance torque: an error of the curve, of the load, of the brake's gain.
"""

from math import ceil, exp, isfinite, nan
from typing import Final, NamedTuple

from abs_supervisor.brake_model import LONGEST_STEP, BrakeModel
from abs_supervisor.road_curve import RoadCurve
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import CornerParameters

_TORQUE_GAIN, _SPEED_GAIN, _DISTURBANCE_GAIN = 0.25, 0.45, 0.10
"""Shares of what surprises in a sample, for the torque, the wheel speed and the disturbance torque."""
_STEP = round(0.005 * NANOSECONDS)
"""[ns] longest step of the prediction."""
_STIFFEST, _STEEPEST_FALL = 20.0, -1.0
"""Range of the exponent: beyond the peak the wheel's motion grows, but not without limit within a step."""
LEAST_SPEED: Final = 0.3
"""[m/s] slip is taken relative to a speed no lower."""


class WheelState(NamedTuple):
    """Of the wheel and its brake at a time."""

    wheel_speed: float
    """[rad/s]"""
    speed: float
    """Of the car [m/s]."""
    torque: float
    """Of the brake [N m]."""
    slip: float


class WheelObserver:
    """Follows one wheel from sample to sample."""

    def __init__(self, corner: CornerParameters, brake: BrakeModel) -> None:
        """Choose the wheel and its brake, which is updated before."""
        self.corner = corner
        """The wheel, with its present load."""
        self._brake = brake
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._stamp: int | None = None
        self._curve: RoadCurve | None = None
        self._torque = self._wheel_speed = self._speed = nan
        self.disturbance = 0.0
        """Torque that the curve does not explain [N m], positive in the direction of rolling."""

    def forget_disturbance(self) -> None:
        """Begin the disturbance anew: the curve is another one."""
        self.disturbance = 0.0

    def update(self, stamp: int, wheel_speed: float, speed: float, torque: float, curve: RoadCurve | None) -> None:
        """Take a sample.

        Args:
            stamp: [ns], later than the last.
            wheel_speed: measured [rad/s].
            speed: of the car [m/s].
            torque: of the brake, measured [N m]; not finite where it is not known.
            curve: the road as known now; None where it is not.
        """
        before = self._stamp
        follows = before is not None and stamp - before <= LONGEST_STEP * NANOSECONDS
        if before is None or not follows or not isfinite(self._torque + self._wheel_speed + self._speed):
            self._torque, self._wheel_speed = torque, wheel_speed
        else:
            begin, late = self._torque, self._brake.late
            end = self._brake.torque_at(begin, before - late, stamp - late)
            self._torque = end + _TORQUE_GAIN * (torque - end) if isfinite(torque) else end
            known = self._curve
            if known is None or curve is None:
                self._wheel_speed = wheel_speed
            else:
                dt = (stamp - before) / NANOSECONDS
                acting = 0.5 * (begin + end)
                expected, _ = wheel_step(
                    self.corner, known, self._wheel_speed, self._speed, acting, self.disturbance, dt
                )
                surprise = wheel_speed - expected
                self._wheel_speed = max(expected + _SPEED_GAIN * surprise, 0.0)
                # A wheel that stands is held by its brake: what is left of the torque is no disturbance.
                if wheel_speed > 0.0:
                    self.disturbance += _DISTURBANCE_GAIN * surprise * self.corner.inertia / dt
        self._stamp, self._speed, self._curve = stamp, speed, curve

    def ahead(self, curve: RoadCurve) -> WheelState:
        """Return the state when a command that is given now begins to act. Comes after `update`."""
        stamp = self._stamp
        assert stamp is not None
        torque, wheel_speed, speed = self._torque, self._wheel_speed, self._speed
        late = self._brake.late
        delay = self._brake.delay + late
        steps = ceil(delay / _STEP)
        for index in range(steps):
            begin = stamp + delay * index // steps
            end = stamp + delay * (index + 1) // steps
            after = self._brake.torque_at(torque, begin - late, end - late)
            wheel_speed, speed = wheel_step(
                self.corner,
                curve,
                wheel_speed,
                speed,
                0.5 * (torque + after),
                self.disturbance,
                (end - begin) / NANOSECONDS,
            )
            torque = after
        return WheelState(wheel_speed, speed, torque, slip_of(speed, self.corner.radius * wheel_speed))


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
