"""Intervention: when the brake of a wheel may be lowered, by how much, and for how long.

    STANDBY --slip that the wheel itself confirms--> ACTIVE --budget spent--> RETURN --refilled--> ACTIVE

and back to STANDBY when the torque of the road is forgotten, the driver brakes no more, or a fail-safe acts.

In STANDBY nothing is lowered. In ACTIVE the law may lower the brake to 0.9 of the torque that the road gave at the
last proof; deeper needs proof now. A release spends the budget, time refills it. No healthy brake is released, whatever
asks for it: a fault of the law, of its inputs, or of a message.
"""

from enum import IntEnum
from math import isfinite, nan
from typing import Final

from abs_supervisor.slip_monitor import SlipMonitor
from vehicle_models.brake_actuator import ActuatorParameters, Command
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import CornerParameters

# The torque that the road gives
FLOOR: Final = 0.9
"""[-] of it: a tyre that slides gives 0.7 to 0.9 of the torque at its peak."""
MEMORY, NEAR = 60.0, 15.0
"""[m] for which it counts, and what is left of them where the wheel falls again."""
SAME, OTHER = 1.25, 1.5
"""[-] of it: a brake that has so much is on the same road, on another."""
PROBE, PROBED = 0.3, 0.4
"""[-] of it, with which a wheel shows the speed of the car, and up to which it does."""
# Budget
FULL: Final = 1.0
"""[s] of release."""
REFILL: Final = 0.5
"""[s/s]"""
AGAIN: Final = 0.2
"""[s] with which a release may begin again."""
RETURN_RATE: Final = 2000.0
"""[N m/s] of the brake torque."""
PAUSE: Final = 0.1
"""[s] of a return at least."""
OPEN_FRICTION, SPINS_UP = 0.05, 0.1
"""[-] friction of ice, and [s] in which a wheel gains speed whose brake is opener than that."""
LOOK: Final = 0.1
"""[s] for which a brake is held to see what its wheel does, and for which it rises after that."""
# Driver
DRIVER_BELOW: Final = 1.5
"""[m/s] speed of the car below which nothing is lowered."""
REACHED: Final = 0.98
"""[-] of the demand: the driver has his pressure."""


class Phase(IntEnum):
    """Phase of the intervention; the values are those of friction_msgs/SupervisorState."""

    STANDBY = 0
    ACTIVE = 1
    RETURN = 2


class Release(IntEnum):
    """Verdict on a release; the values are those of friction_msgs/SupervisorState."""

    NOT_WANTED = 0
    BY_SLIP = 1
    BY_ROAD_TORQUE = 2
    REFUSED = 3
    SPEED_PROBE = 4


class Limit(IntEnum):
    """Limit in force; the values are those of friction_msgs/SupervisorState."""

    NONE = 0
    NO_SPIN_UP = 1
    BUDGET = 2
    RETURN = 3
    LOW_SPEED = 4


class Intervention:
    """Judges what the law of one wheel asks for: `judge` at every sample."""

    def __init__(self, corner: CornerParameters, actuator: ActuatorParameters) -> None:
        """Choose a wheel and its hydraulics."""
        self._spin = corner.inertia / corner.radius
        self._open = OPEN_FRICTION * corner.radius * corner.vertical_load
        self._pulse = min(RETURN_RATE / actuator.apply_rate, 1.0)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.refused = self.limited = 0
        """Releases that the law began and that were refused at their first sample; that a limit has ended."""
        self.phase = Phase.STANDBY
        self.release = Release.NOT_WANTED
        """Verdict on the release that the law asked for."""
        self.limit = Limit.NONE
        self.budget = FULL
        """[s] of release that are left."""
        self._stamp = self._looked = self._look_began = 0
        self.road_torque = nan
        """[N m] brake torque that the road gave at the last proof; NaN where none is remembered."""
        self._way = 0.0
        self._opened = self._paused = self._allowed = 0.0
        self._wanted = self._proves = False

    def judge(
        self,
        stamp: int,
        law: Command,
        slip: SlipMonitor,
        car_speed: float,
        torque: float,
        coming: float,
        demand: float,
        trims: bool,
        probes: bool = False,
    ) -> Command:
        """Return the command that may be given.

        Args:
            stamp: [ns], later than the last.
            law: what the law asks for.
            slip: monitor at this stamp.
            car_speed: [m/s].
            torque: of the brake [N m].
            coming: the same when a command begins to act.
            demand: of the driver [N m].
            trims: whether the law in force holds a slip, and lowers the brake by little.
            probes: whether it is the turn of this wheel to roll as a reference of the speed.
        """
        dt = min((stamp - self._stamp) / NANOSECONDS, PAUSE)
        self._stamp = stamp
        self.budget = min(self.budget + REFILL * dt, FULL)
        begins = law is Command.DECREASE and not self._wanted
        self._wanted = law is Command.DECREASE
        slow = car_speed < DRIVER_BELOW
        self.limit = Limit.LOW_SPEED if slow else Limit.NONE
        self.release = Release.REFUSED if self._wanted else Release.NOT_WANTED
        if law is Command.NONE or slow:
            self.phase, self.road_torque, self._opened = Phase.STANDBY, nan, 0.0
            return Command.NONE
        self._remember(slip, car_speed * dt if car_speed > 0.0 else 0.0, torque)
        if self.phase is Phase.RETURN and not self._has_returned(dt, torque, demand):
            self.limit = Limit.RETURN
            return self._slowly()
        if probes and self.phase is Phase.ACTIVE and self.budget > dt:
            self.budget -= dt
            self.release = Release.SPEED_PROBE
            return Command.HOLD if coming <= PROBE * self.road_torque else Command.DECREASE
        if self._wanted:
            self.release = self._verdict(slip, coming, trims)
            if self.release is not Release.REFUSED:
                return self._lower(dt, slip, torque)
            self.refused += begins
        self._opened = 0.0
        return self._otherwise(stamp, law, slip, torque, coming, demand, trims)

    def may_probe(self, slip: SlipMonitor, torque: float, demand: float) -> bool:
        """Whether the wheel may roll as a reference: it slips by proof in this braking, below the driver's demand."""
        return self.phase is Phase.ACTIVE and isfinite(self.road_torque) and slip.slips and torque < FLOOR * demand

    def is_lowered(self, torque: float) -> bool:
        """Whether a torque [N m] is that of a probe."""
        return torque <= PROBED * self.road_torque

    def _is_near(self, torque: float) -> bool:
        return torque >= FLOOR * self.road_torque

    def _verdict(self, slip: SlipMonitor, coming: float, trims: bool) -> Release:
        if self.phase is Phase.STANDBY:
            return Release.REFUSED
        if slip.proven:
            return Release.BY_SLIP
        return Release.BY_ROAD_TORQUE if self._is_near(coming) and (trims or slip.falls) else Release.REFUSED

    def _remember(self, slip: SlipMonitor, way: float, torque: float) -> None:
        """Keep the torque that the road gave: r Fx = T - J a / r, with a the deceleration of the circumference."""
        same = torque <= SAME * self.road_torque
        if not (same and slip.slips):
            self._way += way
        if slip.proven:
            if self.phase is Phase.STANDBY:
                self.phase = Phase.ACTIVE
            road = torque - self._spin * slip.deceleration
            # A tyre that slides gives less than at its peak: within one proof the largest counts.
            self.road_torque, self._way = max(road, self.road_torque) if self._proves else road, 0.0
            self._proves = True
            return
        self._proves = False
        if slip.falls and same:
            self._way = min(self._way, NEAR)
        elif self._way > MEMORY or (torque > OTHER * self.road_torque and not slip.falls):
            self.road_torque = nan
            self.phase = Phase.STANDBY

    def _has_returned(self, dt: float, torque: float, demand: float) -> bool:
        self._paused += dt
        if not (torque >= REACHED * demand or (self._paused >= PAUSE and self.budget > AGAIN)):
            return False
        self.phase = Phase.ACTIVE
        return True

    def _lower(self, dt: float, slip: SlipMonitor, torque: float) -> Command:
        self._opened = self._opened + dt if torque < self._open else 0.0
        stands = self._opened > SPINS_UP and not slip.recovers
        if self.budget < dt or stands:
            self.limited += 1
            self.phase, self._paused, self._opened, self._allowed = Phase.RETURN, 0.0, 0.0, 0.0
            self.limit = Limit.NO_SPIN_UP if stands else Limit.BUDGET
            return self._slowly()
        self.budget -= dt
        return Command.DECREASE

    def _otherwise(
        self, stamp: int, law: Command, slip: SlipMonitor, torque: float, coming: float, demand: float, trims: bool
    ) -> Command:
        """Return the command where nothing is lowered."""
        if not torque < demand:
            return Command.INCREASE
        active = self.phase is Phase.ACTIVE
        near = active and self._is_near(coming)
        if law is not Command.INCREASE and (near or slip.dives or (slip.possible and self._looks(stamp))):
            return Command.HOLD
        if active and slip.deep and not trims:
            return Command.HOLD if slip.recovers else self._slowly()
        return Command.INCREASE

    def _looks(self, stamp: int) -> bool:
        """Whether a hold may go on: it is for a look at the wheel, and then the pressure rises as long."""
        if stamp - self._looked > LOOK * NANOSECONDS:
            self._look_began = stamp
        self._looked = stamp
        return (stamp - self._look_began) % (2 * LOOK * NANOSECONDS) < LOOK * NANOSECONDS

    def _slowly(self) -> Command:
        """INCREASE for a share of the samples and HOLD for the others, so that the mean rate is that of the return."""
        self._allowed += self._pulse
        if self._allowed >= 1.0:
            self._allowed -= 1.0
            return Command.INCREASE
        return Command.HOLD
