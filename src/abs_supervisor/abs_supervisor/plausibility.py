"""Plausibility of a wheel speed: one table of contradictions to mechanics, brake, other wheels and car.

A wheel that fell to zero through a deceleration that its brake can give is locked; one that jumped there is dead.
"""

from collections import deque
from math import inf, isfinite, nan
from typing import Final, NamedTuple

from abs_supervisor.measurements import GAP, Measurements
from abs_supervisor.reference_speed import WITNESSES
from friction_runtime.filters import SlidingMaximum
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.physical_bounds import HIGHEST_ROAD_FRICTION, LOWEST_APPARENT_FRICTION
from vehicle_models.vehicle import CornerParameters


class Check(NamedTuple):
    """One row of the table."""

    name: str
    condition: str
    lasts: float
    """[s] for which the condition must hold."""
    text: str


JUMP = Check(
    "jump",
    "the speed changes by more than brake, road, noise and stamps can cause; away for good where it reads 0",
    0.015,
    "jumps from {before:.1f} to {speed:.1f} rad/s{dead}",
)
FLICKER = Check(
    "flicker", "the same, twice within 0.1 s", 0.0, "jumps from {before:.1f} to {speed:.1f} rad/s and flickers"
)
STUCK = Check("stuck", "braked, it repeats the same value to the last bit", 0.05, "repeats {speed:.3f} rad/s: stuck")
OPEN = Check(
    "open",
    "it stands with less torque than any road overcomes, while the car moves",
    0.08,
    "stands, although its brake is released: dead",
)
FASTER = Check(
    "faster",
    "braked, it turns 8 % faster than the car, which two other wheels or a speed sensor support",
    0.06,
    "turns with {rim:.1f} m/s, braked, where the car has {car:.1f} m/s",
)
APART = Check(
    "apart",
    "1 s after the brake it differs from the car by 25 %, alone, and does not come nearer",
    0.5,
    "turns with {rim:.1f} m/s, rolling freely, where the car has {car:.1f} m/s",
)
CHECKS: Final = (JUMP, FLICKER, STUCK, OPEN, FASTER, APART)
"""In the order in which they are named."""

# What brake, road and sensor can do
BRAKED: Final = 50.0
"""[N m] of a wheel that is braked; less may be drag of engine and road."""
TORQUE_MARGIN: Final = 1.2
"""[-] by which the brake may be stronger than measured, beside that drag."""
LOAD_TRANSFER: Final = 2.0
"""[-] largest load of a wheel over that at rest."""
JITTER: Final = 2.0
"""[rad/s] noise and ripple."""
STAMP_ERROR: Final = 0.002
"""[s] by which two stamps may be further apart than stated."""
# The wheel and its car
STANDS, MOVES = 0.5, 3.0
"""[m/s] circumference of a wheel that stands; a car that moves."""
FASTER_BY, APART_BY = 0.08, 0.25
"""[-] of the speed of the car."""
FREE: Final = 1.0
"""[s] after the brake until a wheel rolls freely; without contradiction until the sensor is trusted again."""
GAIN: Final = 0.5
"""[m/s] that a wheel gains which comes back: on ice it takes seconds."""
MEMORY: Final = 0.1
"""[s] a torque counts, as the pressure may be late; two spikes within it are a flicker; a reading beyond a jump becomes
the one that others are compared with."""
TURNED: Final = 0.05
"""[s] for which a wheel must have turned before: a spike of a wheel that stands is no fall."""


class Plausibility:
    """Follows one wheel: `update` returns why its speed must not be used, empty where it may."""

    def __init__(self, corner: CornerParameters) -> None:
        """Choose a wheel with the load that rests on it."""
        self._radius, self._inertia = corner.radius, corner.inertia
        road = corner.radius * corner.vertical_load
        self._grip, self._open = HIGHEST_ROAD_FRICTION * LOAD_TRANSFER * road, LOWEST_APPARENT_FRICTION * road
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._torques, self._spikes = SlidingMaximum(MEMORY * NANOSECONDS), deque[int]()
        self._braked: int | None = None
        self._contradicted: int | None = None
        self._last = 0
        self._dead = False
        self.text = ""
        """The last contradiction in words, empty where there is none."""
        self._begin()

    def _begin(self) -> None:
        self._good: tuple[int, float] | None = None
        self._away: int | None = None
        self._turned: tuple[int, int, float] | None = None
        self._same = nan
        self._gained: tuple[float, float] | None = None
        self._fell = False
        self._since: dict[str, int] = {}

    def update(self, stamp: int, measured: Measurements, torque: float) -> str:
        """Take a sample.

        Args:
            stamp: [ns], later than the last.
            measured: its wheel speed is finite.
            torque: of the brake that may act [N m]; where the pressure is not known to be right the larger of measured
                and demanded; NaN where unknown.
        """
        if stamp - self._last > GAP * NANOSECONDS:
            self._begin()
        self._last = stamp
        speed = measured.wheel_speed
        rim = speed * self._radius
        before = self._good[1] if self._good else speed
        most = max(self._torques.update(stamp, torque if isfinite(torque) else inf), 0.0)
        jumps = self._jumps(stamp, speed, rim, most, measured.car_speed)
        faster, apart, car = self._against_car(stamp, rim, torque, measured)
        stands = abs(rim) < STANDS
        moves = (measured.car_speed_measured and measured.car_speed > MOVES) or any(v > MOVES for v in measured.others)
        repeats = self._same == speed and not stands and torque >= BRAKED
        self._same = speed
        found = {
            JUMP: jumps,
            FLICKER: jumps and len(self._spikes) > 1,
            STUCK: repeats,
            OPEN: stands and most < self._open and moves,
            FASTER: faster,
            APART: apart,
        }
        for check in CHECKS:
            if not found[check]:
                self._since.pop(check.name, None)
            elif stamp - self._since.setdefault(check.name, stamp) >= check.lasts * NANOSECONDS:
                self._dead = self._dead or (check is JUMP and stands)
                dead = ": dead" if self._dead else ", which no brake or road can cause"
                self.text = check.text.format(before=before, speed=speed, rim=rim, car=car, dead=dead)
                self._contradicted = stamp
                return self.text
        if self._contradicted is not None and stamp - self._contradicted > FREE * NANOSECONDS:
            self.text, self._contradicted = "", None
        return self.text

    def _jumps(self, stamp: int, speed: float, rim: float, torque: float, car_speed: float) -> bool:
        """Whether the speed is away from what brake and road can make of the last good one."""
        while self._spikes and self._spikes[0] < stamp - MEMORY * NANOSECONDS:
            self._spikes.popleft()
        stands = abs(rim) < STANDS
        if not stands:
            self._dead = self._fell = False
        if self._dead:
            return True
        if self._good is None:
            self._good = (stamp, speed)
            return False
        at, good = self._good
        dt = (stamp - at) / NANOSECONDS
        hardest = (TORQUE_MARGIN * torque + BRAKED) / self._inertia
        if good * self._radius > car_speed:  # the road brakes a wheel that turns faster than its car
            hardest += self._grip / self._inertia
        lowest = min(good, 0.0) if torque == inf else good - dt * hardest
        possible = lowest - JITTER <= speed <= good + dt * self._grip / self._inertia + JITTER
        if stands and self._turned is not None and not self._fell:
            self._fell = self._falls_suddenly(stamp, speed, hardest)
            self._turned = self._turned if self._fell else None
        if possible and not self._fell:
            self._good, self._away = (stamp, speed), None
            if not stands:
                self._turned = (self._turned[0] if self._turned else stamp, stamp, speed)
            return False
        if self._away is None:
            self._away = stamp
            self._spikes.append(stamp)
        if stamp - self._away >= MEMORY * NANOSECONDS and not stands:
            self._good, self._away = (stamp, speed), None
        return True

    def _falls_suddenly(self, stamp: int, speed: float, hardest: float) -> bool:
        """Whether the first sample at which the wheel stands is one at which it cannot: later its brake could do it."""
        assert self._turned is not None
        since, last, turned = self._turned
        fall = hardest * ((stamp - last) / NANOSECONDS + STAMP_ERROR) + JITTER
        long = last - since >= TURNED * NANOSECONDS and turned * self._radius > MOVES
        return long and turned - fall > speed

    def _against_car(self, stamp: int, rim: float, torque: float, measured: Measurements) -> tuple[bool, bool, float]:
        """Return whether a braked wheel is too fast, a free one apart, and the speed [m/s] that it is compared with."""
        others, car, is_measured = measured.others, measured.car_speed, measured.car_speed_measured
        braked = not torque < BRAKED
        if braked or self._braked is None:
            self._braked = stamp
        near = sum(abs(each - car) < FASTER_BY * car for each in others)  # one may be on its way to a lock
        supported = isfinite(car) and (is_measured or near >= WITNESSES)
        backed = any(each > (1.0 - FASTER_BY) * rim for each in others)
        faster = torque >= BRAKED and supported and not backed and rim > (1.0 + FASTER_BY) * car + STANDS
        against = max(others) if others else car if is_measured else nan
        apart = stamp - self._braked > FREE * NANOSECONDS and against > MOVES
        apart = apart and abs(rim - against) > APART_BY * against
        apart = apart and not any(abs(rim - each) < APART_BY * rim for each in others)
        behind = abs(against - rim)
        if not apart:
            self._gained = None
        elif self._gained is None or (rim > self._gained[0] + GAIN and behind < self._gained[1] - GAIN):
            # It gains on its car: it comes back.
            apart, self._gained = self._gained is None, (rim, behind)
        return faster, apart, car if faster else against
