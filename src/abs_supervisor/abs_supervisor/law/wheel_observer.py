"""Wheel observer, and prediction to the time at which a command given now acts.

The brake torque follows the orders and is drawn to the measured pressure. The wheel follows the curve under it; what
it does otherwise is a disturbance torque: an error of the curve, of the load, of the brake's gain.
"""

from math import ceil, isfinite, nan

from abs_supervisor.law.brake_line import BrakeLine
from abs_supervisor.law.late_brake import LateBrake
from abs_supervisor.law.road_curve import RoadCurve
from abs_supervisor.law.wheel_step import slip_of, wheel_step
from vehicle_models.brake_actuator import ActuatorParameters, Command
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import CornerParameters

_TORQUE_GAIN, _SPEED_GAIN, _DISTURBANCE_GAIN = 0.25, 0.45, 0.10
"""Shares of what surprises in a sample, for the torque, the wheel speed and the disturbance torque."""
_LONGEST_STEP = round(0.02 * NANOSECONDS)
"""[ns] a longer gap begins anew."""
_STEP = round(0.005 * NANOSECONDS)
"""[ns] longest step of the prediction."""


class WheelState:
    """Of the wheel and its brake at a time."""

    __slots__ = ("slip", "speed", "torque", "wheel_speed")

    def __init__(self, wheel_speed: float, speed: float, torque: float, slip: float) -> None:
        """Hold wheel speed [rad/s], speed of the car [m/s], brake torque [N m] and slip [-]."""
        self.wheel_speed = wheel_speed
        self.speed = speed
        self.torque = torque
        self.slip = slip


class WheelObserver:
    """Follows one wheel from sample to sample."""

    def __init__(self, corner: CornerParameters, actuator: ActuatorParameters) -> None:
        """Choose the wheel and its hydraulics."""
        self.corner = corner
        """The wheel, with its present load."""
        self._delay = round(actuator.delay * NANOSECONDS)
        self._line = BrakeLine(actuator)
        self._late = LateBrake(self._line)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._line.reset()
        self._late.reset()
        self._stamp: int | None = None
        self._curve: RoadCurve | None = None
        self._torque = self._wheel_speed = self._speed = nan
        self.disturbance = 0.0
        """Torque that the curve does not explain [N m], positive in the direction of rolling."""

    def forget_disturbance(self) -> None:
        """Begin the disturbance anew: the curve is another one."""
        self.disturbance = 0.0

    def ordered(self, stamp: int, command: Command, demand: float) -> None:
        """Note the command that was given at a stamp [ns], with the driver's demand [N m]."""
        self._line.order(stamp, command, demand)

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
        self._late.update(stamp, torque)
        follows = before is not None and stamp - before <= _LONGEST_STEP
        if before is None or not follows or not isfinite(self._torque + self._wheel_speed + self._speed):
            self._torque, self._wheel_speed = torque, wheel_speed
        else:
            begin, late = self._torque, self._late.by
            end = self._line.torque_at(begin, before - late, stamp - late)
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
        late = self._late.by
        delay = self._delay + late
        steps = ceil(delay / _STEP)
        for index in range(steps):
            begin = stamp + delay * index // steps
            end = stamp + delay * (index + 1) // steps
            after = self._line.torque_at(torque, begin - late, end - late)
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
