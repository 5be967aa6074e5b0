"""Supervisor of one wheel: from measurements to a command. Pure, no messages.

    measurements -> reference speed, plausibility, brake model -> curve -> slip monitor
                 -> law (state machine or slip control) -> intervention -> axle -> command

`observe` at every sample, then `decide`. Data flows one way, but for the command, which the brake model follows.
"""

from math import isfinite, nan
from typing import Final

from abs_supervisor.arbitration import EXPLAINED, Arbitration, Law
from abs_supervisor.axle import Axle
from abs_supervisor.brake_model import BrakeModel
from abs_supervisor.curve_selector import CurveSelector
from abs_supervisor.curve_speed import CurveSpeed
from abs_supervisor.intervention import Intervention, Release
from abs_supervisor.measurements import Measurements
from abs_supervisor.plausibility import Plausibility
from abs_supervisor.reference_speed import ReferenceSpeed
from abs_supervisor.slip_control import TAPER, SlipController
from abs_supervisor.slip_monitor import SlipMonitor
from abs_supervisor.speed_probe import SpeedProbe
from vehicle_models.brake_actuator import ActuatorParameters, Command
from vehicle_models.vehicle import Vehicle
from vehicle_models.wheel_forces import LEAST_SHARE, WheelLoad

BRAKED: Final = 20.0
"""[N m] below this, measured and demanded, a wheel rolls freely."""


class WheelSupervisor:
    """Follows one wheel."""

    def __init__(
        self,
        wheel: str,
        vehicle: Vehicle,
        actuator: ActuatorParameters,
        *,
        by_curve: bool,
        obeyed: bool,
        axle: Axle | None = None,
        probe: SpeedProbe | None = None,
    ) -> None:
        """Choose a wheel.

        Args:
            wheel: its name.
            vehicle: its car.
            actuator: the hydraulics.
            by_curve: whether the law is slip control on the curve, while curve and slip are there.
            obeyed: whether the brake obeys what `decide` returns; else the pressure cannot be judged.
            axle: with the other wheel of it.
            probe: chooses the wheel of the car that shows its speed.
        """
        corner = vehicle.corner(wheel)
        self._wheel, self._axle, self._probe, self._obeyed = wheel, axle, probe, obeyed
        self.by_curve = by_curve
        self.car = ReferenceSpeed(corner.radius)
        self.slip = SlipMonitor(corner.radius)
        self.plausibility = Plausibility(corner)
        self.brake = BrakeModel(actuator)
        self.curve = CurveSelector()
        self.curve_speed = CurveSpeed()
        self.controller = SlipController(corner, actuator, self.brake)
        self.arbitration = Arbitration()
        self.intervention = Intervention(corner, actuator)
        self._load = WheelLoad(vehicle, wheel)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        parts = (self.car, self.slip, self.plausibility, self.brake, self.curve)
        for each in (*parts, self.curve_speed, self.controller, self.arbitration, self.intervention):
            each.reset()
        if self._axle is not None:
            self._axle.forget(self._wheel)
        if self._probe is not None:
            self._probe.reset()
        self._stamp = 0
        self.measured = Measurements(nan, nan, nan)
        """At the last sample."""

    def restart(self) -> None:
        """Forget what lies before a jump back in time, and keep the counts."""
        counts = self.intervention.refused, self.intervention.limited
        self.reset()
        self.intervention.refused, self.intervention.limited = counts

    @property
    def law(self) -> Law:
        """Law in force."""
        return self.arbitration.law if self.by_curve else Law.SLOPE_SIGN

    @property
    def disturbance(self) -> float:
        """Torque that the curve does not explain [N m], positive in the direction of rolling; NaN without a curve."""
        return self.controller.disturbance if self.by_curve and self.curve.curve is not None else nan

    @property
    def degraded(self) -> bool:
        """Whether the speed of the car comes from its wheels alone: the rear axle is controlled select-low."""
        return isfinite(self.measured.wheel_speed) and not self.measured.inertial

    def observe(self, stamp: int, measured: Measurements) -> None:
        """Take what is known at a stamp [ns], later than the last; nothing is done where its wheel speed is NaN."""
        self._stamp, self.measured = stamp, measured
        if not isfinite(measured.wheel_speed):
            return
        torque, demand = measured.torque, measured.demand
        self.car.update(stamp, measured)
        self.brake.update(stamp, torque, self._obeyed and isfinite(demand))
        strongest = demand if isfinite(demand) and not demand <= torque else torque
        judged = self._obeyed and isfinite(torque + demand) and not self.brake.text
        self.plausibility.update(stamp, measured, torque if judged else strongest)
        if self.curve.advance(stamp, self.controller.unexplained(self.curve.curve) < EXPLAINED):
            self.controller.forget_disturbance()
        curve = self.curve
        braked = not strongest < BRAKED
        self.slip.update(stamp, measured, self.car, curve.lambda_max, curve.lambda_max_stddev, braked)

    def decide(self, law: Command) -> Command:
        """Return the command at the last sample, for what the state machine asks; NONE: the driver has the brake."""
        measured, stamp = self.measured, self._stamp
        if not isfinite(measured.wheel_speed):
            return Command.NONE
        if self.by_curve:
            law = self._by_curve(law)
        if self.plausibility.text:
            law = Command.NONE
        torque = measured.torque if isfinite(measured.torque) else 0.0
        demand = measured.demand if isfinite(measured.demand) else 0.0
        most = Command.INCREASE
        if self._axle is not None:
            most = self._axle.most(self._wheel, stamp, measured.torque, self.degraded)
        probes = law is not Command.NONE and most is not Command.DECREASE and self._probes(stamp)
        coming = self.brake.torque_at(torque, stamp - self.brake.late, stamp + self.brake.delay)
        trims = self.law is Law.CURVE
        command = self.intervention.judge(
            stamp, law, self.slip, self.car.speed, torque, coming, demand, trims=trims, probes=probes
        )
        if self._axle is not None and not probes:
            if command is Command.INCREASE or (command is Command.HOLD and most is Command.DECREASE):
                command = most
            released = self.intervention.release is Release.BY_SLIP
            self._axle.note(self._wheel, stamp, measured.torque, command, released)
        self.brake.order(stamp, command, demand)
        return command

    def _by_curve(self, otherwise: Command) -> Command:
        """Return what slip control asks for, and where it is not in force what the state machine does."""
        measured, stamp, braking = self.measured, self._stamp, otherwise is not Command.NONE
        if not braking:
            self.curve.forget()
            self.controller.forget_disturbance()
        self._shift_load()
        curve = self.curve.curve
        if curve is None:
            self.curve_speed.forget()
        elif self.curve.report is not None:
            self.curve_speed.take(self.curve.report)
        measured = self.curve_speed.by_curve(stamp, measured)
        self.controller.observe(stamp, measured, curve)
        known, speed = isfinite(measured.slip + measured.car_speed), measured.car_speed
        if known and braking and curve is not None and speed > TAPER:
            self.arbitration.compare(stamp, self.controller.unexplained(curve))
        slow = not known and speed < TAPER
        law = self.arbitration.update(stamp, braking, known or slow, curve is not None)
        if not braking or law is not Law.CURVE or curve is None or not (known or slow):
            return otherwise  # what is missing may not be a reason to change the law yet
        demand = measured.demand if isfinite(measured.demand) else measured.torque
        return self.controller.ask(measured.slip if known else nan, demand, curve, self.curve.seen)

    def _shift_load(self) -> None:
        """Let the controller know the load, where the curve is that of the tyre and not of this wheel with its load."""
        deceleration = self.car.deceleration
        if self.curve.of_tyre and self._load.transfer != 0.0 and isfinite(deceleration):
            shifted = self._load.at_rest - self._load.transfer * deceleration
            self.controller.set_load(max(shifted, LEAST_SHARE * self._load.at_rest))

    def _probes(self, stamp: int) -> bool:
        """Return whether this wheel is to roll for a moment, so that the speed of the car is seen."""
        if self._probe is None:
            return False
        measured = self.measured
        may = self.intervention.may_probe(self.slip, measured.torque, measured.demand)
        held = self.controller.slip_set_point if may and not (measured.car_speed_measured or self.degraded) else nan
        stddev = nan if measured.in_curve else measured.car_speed_stddev
        speed, deceleration = measured.car_speed, self.car.deceleration
        lowered = self.intervention.is_lowered(measured.torque)
        return self._probe.rolls(self._wheel, stamp, speed, stddev, deceleration, lowered, held)

    @property
    def unchecked(self) -> str:
        """What could not be compared with an independent measurement at the last sample."""
        measured, missing = self.measured, []
        if not isfinite(measured.slip):
            missing.append(f"release by deceleration alone ({measured.slip_text})")
        elif not isfinite(self.curve.lambda_max):
            missing.append("no friction curve")
        if not measured.others:
            missing.append("no other wheel")
        if self.car.may_be_locked:
            missing.append("whether a wheel that stands is locked")
        if not isfinite(self.car.deceleration):
            missing.append("deceleration of the car")
        if not self._obeyed:
            missing.append("pressure (the brake does not obey this node)")
        elif not isfinite(measured.torque + measured.demand):
            missing.append("pressure")
        return ", ".join(missing)
