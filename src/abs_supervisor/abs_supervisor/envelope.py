"""Safety envelope: pressure release requires independent evidence and is limited in duration.

No healthy brake is released, whatever asks for it: a fault of the law, of its inputs, or of a message.
"""

from typing import Final

from abs_supervisor.fast_dive import FastDive
from abs_supervisor.law.brake_line import BrakeLine
from abs_supervisor.release_caps import Cap, ReleaseCaps
from abs_supervisor.release_evidence import Release, ReleaseEvidence, Wheel
from abs_supervisor.road_torque import RoadTorque
from abs_supervisor.tuning import EnvelopeTuning
from abs_supervisor.witness import Witness
from vehicle_models.brake_actuator import ActuatorParameters, Command
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import CornerParameters

_STANDS: Final = 0.75
"""[m/s] Speed of the car down to which a pressure that is near what the road gave is kept from the driver's."""
_LATE: Final = 0.03
"""[s] by which a brake may be later than stated."""
_LIMITED: Final = 0.9
"""Of the demand: with less the road, not the driver, limits the pressure."""
_TELLS_ABOVE: Final = 2.0
"""[m/s] A wheel that is kept from every dive below no longer tells the speed of its car, and then stood."""


class Envelope:
    """Judges the law of one wheel."""

    def __init__(self, corner: CornerParameters, actuator: ActuatorParameters, parameters: EnvelopeTuning) -> None:
        """Choose a wheel, its hydraulics, and the parameters of the evidence and the caps."""
        self.evidence = ReleaseEvidence(corner.radius, parameters.evidence)
        self.caps = ReleaseCaps(parameters.caps, actuator)
        self._road = RoadTorque(corner.radius, corner.inertia)
        self._dive = FastDive(corner, actuator)
        self._witness = Witness(parameters.evidence.evidence_time)
        self._line = BrakeLine(actuator)
        self._delay, self._apply_rate = round(actuator.delay * NANOSECONDS), actuator.apply_rate
        self._driver_below = parameters.caps.driver_below
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.evidence.reset()
        self.caps.reset()
        self._road.reset()
        self._line.reset()
        self._witness.reset()
        self._wanted = False
        self.release = Release.NOT_WANTED
        """Verdict on the release that the law asked for."""
        self.refused = 0
        """Releases that the law began and that were refused at their first sample."""

    def restart(self) -> None:
        """Forget what lies before a jump back in time, and keep the counts."""
        refused, capped = self.refused, self.caps.count
        self.reset()
        self.refused, self.caps.count = refused, capped

    def look(self, stamp: int, wheel: Wheel) -> None:
        """Take what is known of the wheel at a stamp [ns], later than the last. Comes before `judge`."""
        self.evidence.update(stamp, wheel)

    def may_trim(self, car_speed: float, torque: float) -> bool:
        """Whether a brake torque may be lowered to a little below what the road gave when the wheel slipped.

        Where a dive outruns the brake the slip counts as it is stated, for the torque is a second witness that shares
        no error with it. Above 8 m/s a wheel that falls behind its own speed is enough, whatever its slip.

        Args:
            car_speed: [m/s], NaN where unknown.
            torque: of the brake [N m], NaN where unknown.
        """
        falls = self.evidence.falls and car_speed > _TELLS_ABOVE
        return (falls or self._is_critical(car_speed, torque)) and self._road.may_fall(torque)

    def may_roll(self, torque: float, demand: float) -> bool:
        """Whether the wheel may show the speed of the car.

        It has slipped in this braking by evidence, its slip as it is stated is that of a release now, and the driver
        asks for more than the road takes.

        Args:
            torque: of the brake [N m], NaN where unknown.
            demand: of the driver [N m].
        """
        return self._road.is_known and self.evidence.grips and torque < _LIMITED * demand

    def _is_critical(self, car_speed: float, torque: float) -> bool:
        return self.evidence.grips and self._dive.outruns_brake(car_speed, torque)

    def judge(
        self, stamp: int, law: Command, car_speed: float, torque: float, demand: float, rolls: bool = False
    ) -> Command:
        """Return the command that may be given.

        Args:
            stamp: [ns], later than the last.
            law: what the law asks for.
            car_speed: [m/s], NaN where unknown.
            torque: of the brake [N m].
            demand: of the driver [N m].
            rolls: whether it is the turn of this wheel to show the speed of the car.
        """
        self._witness.update(stamp, torque, self.evidence.diverges, self.evidence.fell)
        coming = self._line.torque_at(torque, stamp, stamp + self._delay)
        slow = car_speed < self._driver_below
        wanted = law is Command.DECREASE
        begins, self._wanted = wanted and not self._wanted, wanted
        if law is Command.NONE or slow:
            self.release = Release.REFUSED if wanted else Release.NOT_WANTED
            self.caps.driver(stamp, slow)
            enough = torque < demand and self._road.is_near(coming) and car_speed > _STANDS
            if law in (Command.HOLD, Command.DECREASE) and enough:
                return Command.HOLD
            if law is Command.NONE:
                self._road.reset()
            return Command.NONE
        self.release = self.evidence.verdict if wanted else Release.NOT_WANTED
        shown = self._road.is_known or self._witness.confirms or not self.evidence.knows_slip
        looks = self._witness.looks(stamp, self.release not in (Release.NOT_WANTED, Release.REFUSED) and not shown)
        if not shown and wanted:
            self.release = Release.REFUSED
        trim = self.release is Release.REFUSED and self.may_trim(car_speed, torque)
        if trim:
            self.release = Release.BY_SLIP
        self.refused += begins and self.release is Release.REFUSED
        release = wanted and self.release is not Release.REFUSED
        # The pressure takes its time: a wheel that is back before it needs it on its way.
        late = _LATE + self._delay / NANOSECONDS + self._road.lacks(coming) / self._apply_rate
        deep = shown and self.evidence.deep and self.evidence.back_in(car_speed) > late
        command = self.caps.command(
            stamp, release, self.evidence.recovering, deep, self.evidence.stands, torque, demand
        )
        # A trim alone tells nothing of the road: else each would allow the next.
        lowers = command is Command.DECREASE
        self._road.update(stamp, lowers and not trim, lowers and trim, torque, self.evidence.deceleration, car_speed)
        if rolls:
            self.release = Release.REFERENCE
            return Command.DECREASE
        waits = wanted and not release and (self.evidence.dives or looks)
        near = self.evidence.allows_hold or (self.evidence.may_slip and self._road.is_near(coming))
        held = law is Command.HOLD and near
        full = law is Command.INCREASE and self.caps.cap is Cap.NONE and self._road.is_reached(torque)
        if full and self._is_critical(car_speed, torque):
            # With more than the road gave a wheel is locked before a release acts.
            held = True
        if (waits or held) and command is Command.INCREASE and torque < demand:
            # Not yet a lock, perhaps the brake's own rise: that is stopped, which a slow brake needs in time.
            return Command.HOLD
        return command

    def commanded(self, stamp: int, command: Command, demand: float) -> None:
        """Note the command that was given at the stamp [ns] of the last `judge`, with the driver's demand [N m]."""
        self._line.order(stamp, command, demand)
