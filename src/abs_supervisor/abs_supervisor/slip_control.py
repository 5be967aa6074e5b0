"""Slip control on the identified friction curve: the brake torque that brings the slip to its set-point and keeps it.

The torque follows the torque of the road at the set-point, the disturbance that the observer finds, and an approach
that ends as fast as the brake can.
"""

from math import inf, isfinite, nan, sqrt
from typing import Final

from abs_supervisor.brake_model import BAND, LONGEST_STEP, BrakeModel
from abs_supervisor.measurements import Measurements
from abs_supervisor.road_curve import RoadCurve
from abs_supervisor.wheel_observer import WheelObserver, WheelState
from vehicle_models.brake_actuator import ActuatorParameters, Command
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import CornerParameters

# Slip set-point, as a share of lambda_max
TO_PASS: Final = 1.10
"""[-] while the peak has not been seen: it is passed, and so seen."""
HELD: Final = 0.92
"""[-] afterwards: friction is flat there, and the wheel is stable."""
AT_REST, SLOW = 0.70, 8.0
"""[-] at standstill, and [m/s] from which on HELD: a wheel is quick at low speed, and slip is uncertain."""
# Torque
APPROACH: Final = 35.0
"""[1/s] with which a small error of the wheel speed vanishes."""
FAR: Final = 2.0
"""[-] of the set-point: slip that is far beyond."""
RETURN: Final = 0.2
"""[-] of the torque at the set-point by which the torque stays below that of the road, far beyond the peak."""
TAPER, TAPER_END, TAPER_SHARE = 5.0, 3.0, 0.96
"""[m/s] from where on the torque stays below a share of that at the peak, which falls to TAPER_SHARE at TAPER_END."""
# Disturbance torque
SLOW_TIME, FIRST_TIME = 0.3, 0.05
"""[s] of its slow part, and when it begins: the observer's own, in which its noise is averaged."""
NOISE: Final = 0.25
"""[-] of the torque at the set-point: a faster part up to this counts as noise."""
NEAR: Final = 0.5
"""[-] of the set-point: the slow part is learned while the slip is nearer to it."""


class SlipController:
    """Controls one wheel: `observe` at every sample, then `ask`."""

    def __init__(self, corner: CornerParameters, actuator: ActuatorParameters, brake: BrakeModel) -> None:
        """Choose a wheel, its hydraulics, and the model of its brake, which is updated before."""
        self._corner, self._actuator = corner, actuator
        self._observer = WheelObserver(corner, brake)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._observer.reset()
        self._stamp: int | None = None
        self._dt = 0.0
        self.slip_set_point = self.torque_set_point = nan
        """[-] and [N m]; NaN while the law is not in force."""
        self.forget_disturbance()

    def forget_disturbance(self) -> None:
        """Begin the disturbance anew: the curve is another one, or the braking is over."""
        self._observer.forget_disturbance()
        self._slow, self._learned = 0.0, FIRST_TIME

    def set_load(self, load: float) -> None:
        """Take the load of the wheel [N], > 0, for a curve whose friction does not carry its change."""
        rest = self._corner
        corner = CornerParameters(rest.radius, rest.inertia, load / rest.gravity, load)
        self._corner = self._observer.corner = corner

    @property
    def disturbance(self) -> float:
        """Torque that the curve does not explain [N m], positive in the direction of rolling."""
        return self._observer.disturbance

    def unexplained(self, curve: RoadCurve | None) -> float:
        """Size of that torque over the one that the road gives at its peak [-]; inf without a curve."""
        if curve is None:
            return inf
        return abs(self._observer.disturbance) / (self._corner.radius * self._corner.vertical_load * curve.mu_max)

    def observe(self, stamp: int, measured: Measurements, curve: RoadCurve | None) -> None:
        """Take a sample at a stamp [ns], later than the last, on the road as it is known."""
        self._dt = 0.0 if self._stamp is None else min((stamp - self._stamp) / NANOSECONDS, LONGEST_STEP)
        self._stamp = stamp
        self.slip_set_point = self.torque_set_point = nan
        if isfinite(measured.car_speed):
            self._observer.update(stamp, measured.wheel_speed, measured.car_speed, measured.torque, curve)

    def ask(self, slip: float, demand: float, curve: RoadCurve, seen: bool) -> Command:
        """Return what the law asks for, with the state of the last `observe`, at which the speed of the car is known.

        Args:
            slip: [-]; NaN where unknown, at the end of a stop, where the torque alone is enough.
            demand: of the driver [N m].
            curve: the road.
            seen: whether its peak has been passed.
        """
        ahead = self._observer.ahead(curve)
        if not isfinite(slip):
            aim = most_torque(self._corner, curve, ahead.speed, self._slow)
            self.torque_set_point = min(aim, demand)
            asked = nearest_command(aim, ahead.torque, demand)
            return Command.HOLD if asked is Command.DECREASE else asked
        wanted = slip_set_point(curve, seen, ahead.speed)
        disturbance = self._observer.disturbance
        if ahead.speed > TAPER and abs(slip - wanted) < NEAR * wanted:
            self._learned = min(self._learned + self._dt, SLOW_TIME)
            self._slow += (disturbance - self._slow) * min(self._dt / self._learned, 1.0)
        followed = followed_disturbance(disturbance, self._slow, steady_torque(self._corner, curve, wanted))
        aim = torque_set_point(self._corner, self._actuator, curve, ahead, wanted, followed, disturbance)
        self.slip_set_point, self.torque_set_point = wanted, min(aim, demand)
        return nearest_command(aim, ahead.torque, demand)


def slip_set_point(curve: RoadCurve, seen: bool, speed: float) -> float:
    """Return the slip [-] to hold on a road at a speed of the car [m/s]; `seen`: its peak has been passed."""
    share = HELD if seen else TO_PASS
    if speed < SLOW:
        share = min(share, AT_REST + (HELD - AT_REST) * max(speed, 0.0) / SLOW)
    return share * curve.lambda_max


def steady_torque(corner: CornerParameters, curve: RoadCurve, slip: float) -> float:
    """Brake torque [N m] that holds a slip: r Fz mu + J (1 - slip) g mu / r, from (2.15) with omega_dot of that slip.

    An error of the brake's gain cancels, as the curve and this torque share it.
    """
    deceleration = corner.gravity * curve.friction(slip)
    held = corner.inertia * (1.0 - slip) * deceleration / corner.radius
    return corner.radius * corner.vertical_load * curve.friction(slip) + held


def followed_disturbance(disturbance: float, slow: float, steady: float) -> float:
    """Return the torque to follow [N m] of a disturbance and its slow part [N m]; `steady` is that at the set-point.

    Continuous: nothing of a fast part below a quarter of `steady`, all of it above a half.
    """
    fast = disturbance - slow
    size = abs(fast)
    share = min(max(2.0 * (size - NOISE * steady), 0.0), size)
    return slow + (share if fast > 0.0 else -share)


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
    if ahead.slip > FAR * slip:
        road = corner.radius * corner.vertical_load * curve.friction(ahead.slip)
        torque = min(torque, road + disturbance - RETURN * steady)
    if ahead.speed < TAPER:
        torque = min(torque, most_torque(corner, curve, ahead.speed, followed))
    return max(torque, 0.0)


def most_torque(corner: CornerParameters, curve: RoadCurve, speed: float, followed: float) -> float:
    """Return the most brake torque [N m] near the end of a stop, at a speed of the car [m/s] up to 5 m/s.

    A step at that speed would make a tyre with relaxation ring. `followed` [N m] as above.
    """
    peak = steady_torque(corner, curve, curve.lambda_max)
    share = max((speed - TAPER_END) / (TAPER - TAPER_END), 0.0)
    return (TAPER_SHARE + (1.0 - TAPER_SHARE) * share) * (peak + min(followed, 0.0))


def _approach(corner: CornerParameters, actuator: ActuatorParameters, error: float, speed: float) -> float:
    """Return how fast an error of the wheel speed [rad/s] is to vanish [rad/s^2], at a speed of the car [m/s].

    In proportion where it is small, and slower at low speed, where the tyre needs its relaxation length to answer;
    where it is large, as fast as the brake can end with its own rate: what moves the wheel by a takes J a / rate to
    go, and the wheel moves by J a^2 / (2 rate) meanwhile.
    """
    brake = actuator.apply_rate if error < 0.0 else actuator.release_rate
    fastest = sqrt(2.0 * brake * abs(error) / corner.inertia)
    small = APPROACH * min(speed / SLOW, 1.0) * error
    return min(max(small, -fastest), fastest)


def nearest_command(wanted: float, torque: float, demand: float) -> Command:
    """Return the command that brings a brake torque nearest to a wanted one.

    Args:
        wanted: torque to aim at [N m].
        torque: of the brake when the command acts [N m].
        demand: of the driver [N m], the ceiling: a torque that reaches it is his.
    """
    if wanted >= demand - BAND or torque > demand:
        return Command.INCREASE
    error = wanted - torque
    if error > BAND:
        return Command.INCREASE
    return Command.DECREASE if error < -BAND else Command.HOLD
