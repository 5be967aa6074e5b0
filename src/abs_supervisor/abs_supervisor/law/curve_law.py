"""The law of one wheel: from what is known at a sample to what it asks for."""

from math import inf, isfinite, nan

from abs_supervisor.law.choice import Law, LawChoice
from abs_supervisor.law.disturbance import DisturbanceFilter
from abs_supervisor.law.explained import LITTLE, Explained
from abs_supervisor.law.released_wheel import ReleasedWheel
from abs_supervisor.law.road_curve import RoadCurve
from abs_supervisor.law.set_point import slip_set_point
from abs_supervisor.law.three_commands import command_towards
from abs_supervisor.law.torque_set_point import most_torque, steady_torque, torque_set_point
from abs_supervisor.law.usable_curve import CurveReport, UsableCurve
from abs_supervisor.law.wheel_observer import WheelObserver
from abs_supervisor.tuning import Tuning
from vehicle_models.brake_actuator import ActuatorParameters, Command
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import CornerParameters

_LEARNS_ABOVE = 5.0
"""[m/s] below this speed of the car the slow part of the disturbance is kept, and whether the curve explains the wheel:
an error of the slip looks like a torque there. Nor is slip needed to keep the torque that the road takes."""
_NEAR = 0.5
"""Of the set-point: the slow part is learned while the slip is nearer to it."""
_LONGEST_STEP = 0.02
"""[s]"""


class CurveLaw:
    """Slip control on the identified curve. `ask` at every sample, then `commanded`."""

    def __init__(
        self, corner: CornerParameters, actuator: ActuatorParameters, band: float = Tuning.torque_band
    ) -> None:
        """Choose a wheel and its hydraulics."""
        self._corner, self._actuator, self._band = corner, actuator, band
        self._observer = WheelObserver(corner, actuator)
        self._filter = DisturbanceFilter()
        self._released = ReleasedWheel()
        self._explained = Explained()
        self.known = UsableCurve()
        self.choice = LawChoice()
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._observer.reset()
        self._filter.reset()
        self._released.reset()
        self._explained.reset()
        self.known.reset()
        self.choice.reset()
        self._stamp: int | None = None
        self.slip_set_point = nan
        """[-]; NaN while it is not in force."""
        self.torque_set_point = nan
        """[N m]; NaN while it is not in force."""

    @property
    def disturbance(self) -> float:
        """Torque that the curve does not explain [N m]; NaN without a curve."""
        return self._observer.disturbance if self.known.curve is not None else nan

    @property
    def _unexplained(self) -> float:
        """Size of that torque over the one that the road gives at its peak [-]; inf without a curve."""
        curve, corner = self.known.curve, self._corner
        if curve is None:
            return inf
        return abs(self._observer.disturbance) / (corner.radius * corner.vertical_load * curve.mu_max)

    def carry(self, load: float) -> None:
        """Take the load of the wheel [N], > 0, for a curve whose friction does not carry its change."""
        rest = self._corner
        corner = CornerParameters(rest.radius, rest.inertia, load / rest.gravity, load)
        self._corner = self._observer.corner = corner

    def learn(self, report: CurveReport) -> None:
        """Take what the estimator said; their stamps do not go back."""
        self.known.take(report, self._unexplained < LITTLE)
        if self.known.changed:
            self._observer.forget_disturbance()
            self._filter.reset()

    def ask(
        self,
        stamp: int,
        wheel_speed: float,
        speed: float,
        slip: float,
        torque: float,
        demand: float,
        braking: bool,
    ) -> Command | None:
        """Return what the law asks for; None where it is not in force.

        Args:
            stamp: [ns], later than the last.
            wheel_speed: [rad/s].
            speed: of the car [m/s]; NaN where unknown.
            slip: [-]; NaN where unknown.
            torque: of the brake, measured [N m].
            demand: of the driver [N m].
            braking: whether he brakes.
        """
        dt = 0.0 if self._stamp is None else min((stamp - self._stamp) / NANOSECONDS, _LONGEST_STEP)
        self._stamp = stamp
        if not braking:
            self.known.reset()
            self._filter.reset()
            self._observer.forget_disturbance()
            self._released.reset()
            self._explained.reset()
        curve = self.known.curve
        known = isfinite(slip) and isfinite(speed)
        self.slip_set_point = self.torque_set_point = nan
        if isfinite(speed):
            self._observer.update(stamp, wheel_speed, speed, torque, curve)
        if known and braking and curve is not None and speed > _LEARNS_ABOVE:
            self._explained.update(stamp, self._unexplained)
        blind = not known and isfinite(speed) and speed < _LEARNS_ABOVE
        law = self.choice.update(stamp, braking, known or blind, curve is not None, self._explained.holds)
        if not braking:
            return Command.NONE
        if law is not Law.CURVE:
            return None
        if blind and curve is not None:
            return self._without_slip(curve, demand)
        if not known or curve is None:
            # Not yet a reason for the other law: the driver's demand passes.
            return Command.INCREASE
        self._released.update(stamp, self._corner, wheel_speed, torque, slip, curve.lambda_max)
        if self._released.rolls:
            return Command.INCREASE
        ahead = self._observer.ahead(curve)
        wanted = slip_set_point(curve, self.known.seen, ahead.speed)
        disturbance = self._observer.disturbance
        if speed > _LEARNS_ABOVE and abs(slip - wanted) < _NEAR * wanted:
            self._filter.learn(disturbance, dt)
        followed = self._filter.followed(disturbance, steady_torque(self._corner, curve, wanted))
        aim = torque_set_point(self._corner, self._actuator, curve, ahead, wanted, followed, disturbance)
        self.slip_set_point, self.torque_set_point = wanted, min(aim, demand)
        return command_towards(aim, ahead.torque, demand, self._band)

    def _without_slip(self, curve: RoadCurve, demand: float) -> Command:
        """Return what is asked for at the end of a stop while slip is unknown: the torque alone is enough there."""
        ahead = self._observer.ahead(curve)
        aim = most_torque(self._corner, curve, ahead.speed, self._filter.slow)
        self.torque_set_point = min(aim, demand)
        asked = command_towards(aim, ahead.torque, demand, self._band)
        return Command.HOLD if asked is Command.DECREASE else asked

    def commanded(self, stamp: int, command: Command, demand: float) -> None:
        """Note the command that was given at a stamp [ns], with the driver's demand [N m]."""
        self._observer.ordered(stamp, command, demand)
