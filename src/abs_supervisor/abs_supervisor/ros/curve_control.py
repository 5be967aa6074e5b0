"""The law on the identified curve at one wheel: messages in, what it asks for and the fields of the state out."""

from math import isfinite, nan

from friction_msgs.msg import FrictionCurve, SupervisorDebug, SupervisorState

from abs_supervisor.curve_queue import CurveQueue
from abs_supervisor.guard import Seen
from abs_supervisor.law.choice import Change, Law
from abs_supervisor.law.curve_law import CurveLaw
from abs_supervisor.law.usable_curve import CurveReport
from abs_supervisor.ros.curve_report import curve_report
from abs_supervisor.tuning import Tuning
from vehicle_models.brake_actuator import ActuatorParameters, Command
from vehicle_models.vehicle import Vehicle
from vehicle_models.wheel_forces import LEAST_SHARE, WheelLoad

_OF_THE_CAR = "car"
"""The method whose friction is that of the tyre; in that of a single wheel the change of its load is contained."""


class CurveControl:
    """Stands between the processor and the law."""

    def __init__(self, wheel: str, vehicle: Vehicle, actuator: ActuatorParameters, tuning: Tuning) -> None:
        """Choose a wheel of the car and its hydraulics."""
        self.law = CurveLaw(vehicle.corner(wheel), actuator, tuning.torque_band)
        self._reports: CurveQueue[CurveReport] = CurveQueue()
        self._load = WheelLoad(vehicle, wheel)
        self._true_friction = False

    def reset(self) -> None:
        """Forget everything."""
        self.law.reset()
        self._reports = CurveQueue()

    def take(self, message: FrictionCurve) -> None:
        """Take a curve."""
        self._true_friction = message.method == _OF_THE_CAR
        report = curve_report(message)
        self._reports.put(report.stamp, report)

    def ask(self, stamp: int, seen: Seen, otherwise: Command, release: bool, deceleration: float) -> Command:
        """Return what is asked for at a stamp [ns], later than the last.

        Args:
            stamp: of the sample [ns].
            seen: what is known there; its wheel speed is finite.
            otherwise: what the machine asks for. NONE: the driver does not brake, or an input failed.
            release: whether the envelope would answer a release with less pressure than the driver's: it lets it pass,
                or holds a wheel that dives. Where it would not, a hold is asked for.
            deceleration: of the car over the last 0.2 s [m/s^2], NaN where unknown; that is as late as the pitch of
                its body, which the load of the wheels follows.
        """
        if self._true_friction and self._load.transfer != 0.0 and isfinite(deceleration):
            shifted = self._load.at_rest - self._load.transfer * deceleration
            self.law.carry(max(shifted, LEAST_SHARE * self._load.at_rest))
        for report in self._reports.until(stamp):
            self.law.learn(report)
        asked = self.law.ask(
            stamp,
            wheel_speed=seen.wheel_speed,
            speed=seen.car_speed,
            slip=seen.slip,
            torque=seen.torque,
            demand=seen.demand if isfinite(seen.demand) else seen.torque,
            braking=otherwise is not Command.NONE,
        )
        if asked is None:
            return otherwise
        return Command.HOLD if asked is Command.DECREASE and not release else asked

    def commanded(self, stamp: int, command: Command, demand: float) -> None:
        """Note the command that was given at a stamp [ns], with the driver's demand [N m], NaN where unknown."""
        self.law.commanded(stamp, command, demand if isfinite(demand) else 0.0)


def describe(state: SupervisorState, debug: SupervisorDebug, control: CurveControl | None) -> None:
    """Fill in the law's fields of the messages; None: the slope's sign is the only law."""
    state.law = int(Law.SLOPE_SIGN if control is None else control.law.choice.law)
    state.law_cause = int(Change.NONE if control is None else control.law.choice.cause)
    state.slip_set_point = nan if control is None else control.law.slip_set_point
    debug.torque_set_point = nan if control is None else control.law.torque_set_point
    debug.disturbance_torque = nan if control is None else control.law.disturbance
