"""Contradictions between a wheel speed and mechanics, the other wheels, and the car.

A wheel that fell to zero through a deceleration that brake and road can give is locked; one that jumped there is dead.
"""

from collections.abc import Sequence
from math import inf, isfinite, nan
from typing import Final

from abs_supervisor.coming_back import ComingBack
from abs_supervisor.sudden_stop import SuddenStop
from friction_runtime.filters import Debounce, SlidingMaximum, SlidingWindow
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.physical_bounds import HIGHEST_ROAD_FRICTION, LOWEST_APPARENT_FRICTION
from vehicle_models.vehicle import CornerParameters

_LOAD_TRANSFER: Final = 2.0
"""Largest load of a wheel over that at rest."""
_JITTER: Final = 2.0
"""Error of a wheel speed that is not a jump [rad/s]: noise and ripple."""
_SPARE_TORQUE: Final = 50.0
"""[N m] engine drag and rolling resistance, and noise of the pressure."""
_TORQUE_MARGIN: Final = 1.2
"""The brake may be stronger than its gain says."""
_TORQUE_MEMORY: Final = 0.1
"""[s] for which a torque counts as possible: the pressure may be late."""
_EXCURSION: Final = 0.015
"""[s] a jump that lasts so long is one; a shorter one is a spike, which the law refuses itself."""
_EXCURSIONS: Final = 0.1
"""[s] two spikes within this time are a sensor that flickers."""
_ADOPTED: Final = 0.1
"""[s] after which readings beyond a jump become the ones that others are compared with."""
_STANDS: Final = 0.5
"""[m/s] slower circumferences count as standing."""
_MOVES: Final = 3.0
"""[m/s] from here the car moves."""
_REPEATS: Final = 0.05
"""[s] a braked wheel that turns and reads the same to the last bit for so long is stuck: encoders have noise."""
_FASTER, _FASTER_FOR = 0.08, 0.06
"""A braked wheel cannot be faster than the car by this share, [s] for so long."""
_APART, _APART_FOR = 0.25, 0.5
"""A wheel that rolls freely differs from the car by less than this share, [s] after at most so long."""
_FREE_FOR: Final = 1.0
"""[s] after the brake."""
_BRAKED: Final = 50.0
"""[N m]"""
_RELEASED_FOR: Final = 0.08
"""[s] beyond `_TORQUE_MEMORY`; a locked wheel has 1 m/s by then."""
_GAP: Final = 0.05
"""[s] after a longer gap between samples the checks start again: what happened in it is not known."""
_CLEAN: Final = 1.0
"""[s] without contradiction until the sensor is trusted again."""


class Surroundings:
    """What a wheel speed is compared with, at one stamp."""

    def __init__(
        self,
        torque: float = nan,
        others: Sequence[float] = (),
        car_speed: float = nan,
        car_is_measured: bool = False,
    ) -> None:
        """Hold what is known; NaN where something is not.

        Args:
            torque: brake torque [N m] that may act: as measured, where that is not known to be right the larger of
                measured and demanded.
            others: circumferential speeds of the other wheels, as far as they are known [m/s].
            car_speed: [m/s].
            car_is_measured: whether that speed comes from a speed sensor, not from wheels and accelerometer.
        """
        self.torque = torque
        self.others = others
        self.car_speed = car_speed
        self.car_is_measured = car_is_measured


class WheelCheck:
    """Follows one wheel. `update` returns why its reading must not be used, empty where it may."""

    def __init__(self, corner: CornerParameters) -> None:
        """Choose a wheel with the load that rests on it."""
        self._radius, self._inertia = corner.radius, corner.inertia
        self._grip = HIGHEST_ROAD_FRICTION * _LOAD_TRANSFER * corner.radius * corner.vertical_load
        self._open = LOWEST_APPARENT_FRICTION * corner.radius * corner.vertical_load
        self._sudden, self._back = SuddenStop(corner.radius, _JITTER), ComingBack()
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._good: tuple[int, float] | None = None
        self._away_since: int | None = None
        self._spikes: SlidingWindow[None] = SlidingWindow(_EXCURSIONS * NANOSECONDS)
        self._torques = SlidingMaximum(_TORQUE_MEMORY * NANOSECONDS)
        self._dead = False
        self._sudden.reset()
        self._back.reset()
        self._same: tuple[int, float] | None = None
        self._standing = Debounce(_RELEASED_FOR * NANOSECONDS)
        self._faster = Debounce(_FASTER_FOR * NANOSECONDS)
        self._apart = Debounce()
        self._braked: int | None = None
        self._contradicted: int | None = None
        self._last: int | None = None
        self.text = ""
        """The last contradiction in words, empty where there is none."""

    def update(self, stamp: int, wheel_speed: float, around: Surroundings) -> str:
        """Take the wheel speed [rad/s] at a stamp [ns]; return why it must not be used, or nothing."""
        if self._last is not None and stamp - self._last > _GAP * NANOSECONDS:
            self._same = self._good = self._away_since = None
            for each in (self._standing, self._faster, self._apart):
                each.reset()
            self._sudden.reset()
            self._back.reset()
        self._last = stamp
        torque = self._torque(stamp, around.torque)
        found = self._jump(stamp, wheel_speed, torque, around) or self._released(stamp, wheel_speed, torque, around)
        stuck = self._stuck(stamp, wheel_speed, around.torque)
        found = found or stuck or self._against_car(stamp, wheel_speed * self._radius, around)
        if found:
            self.text, self._contradicted = found, stamp
        elif self._contradicted is not None and stamp - self._contradicted > _CLEAN * NANOSECONDS:
            self.text, self._contradicted = "", None
        return self.text

    def _torque(self, stamp: int, torque: float) -> float:
        """Return the largest torque that may have acted of late [N m], inf where it is unknown."""
        return max(self._torques.update(stamp, torque if isfinite(torque) else inf), 0.0)

    def _jump(self, stamp: int, speed: float, torque: float, around: Surroundings) -> str:
        stands = abs(speed) * self._radius < _STANDS
        if self._dead and not stands:
            self._dead = False
        good = self._good
        if good is None:
            self._good = (stamp, speed)
            return ""
        dt = (stamp - good[0]) / NANOSECONDS
        hardest = (_TORQUE_MARGIN * torque + _SPARE_TORQUE) / self._inertia
        if good[1] * self._radius > around.car_speed:  # the road brakes a wheel that turns faster than its car
            hardest += self._grip / self._inertia
        lowest = min(good[1], 0.0) if torque == inf else good[1] - dt * hardest
        highest = good[1] + dt * self._grip / self._inertia
        possible = lowest - _JITTER <= speed <= highest + _JITTER
        self._sudden.update(stamp, speed, stands, possible, hardest)
        if possible and not self._dead and not self._sudden.suspected:
            self._good, self._away_since = (stamp, speed), None
            return ""
        if self._dead:
            return "reads 0 after a jump that no brake can cause: dead"
        if self._away_since is None:
            self._away_since = stamp
            self._spikes.append(stamp, None)
        self._spikes.drop_old(stamp)
        away = (stamp - self._away_since) / NANOSECONDS
        text = f"jumps from {good[1]:.1f} to {speed:.1f} rad/s"
        if stands and away >= _EXCURSION:
            self._dead, self._good, self._away_since = True, (stamp, speed), None
            return f"{text}: dead"
        if away >= _ADOPTED:
            self._good, self._away_since = (stamp, speed), None
        if len(self._spikes) > 1:
            return f"{text}, not for the first time: flickers"
        return f"{text}, which no brake or road can cause" if away >= _EXCURSION else ""

    def _released(self, stamp: int, speed: float, torque: float, around: Surroundings) -> str:
        # Another wheel that turns shows that the car moves: its own speed may come from this wheel.
        moves = around.car_is_measured or any(each > _MOVES for each in around.others)
        stands = abs(speed) * self._radius < _STANDS and torque < self._open and moves and around.car_speed > _MOVES
        return "stands, although its brake is released: dead" if self._standing.update(stamp, stands) else ""

    def _stuck(self, stamp: int, speed: float, torque: float) -> str:
        # Only a braked wheel must change: one that rolls freely over a simulated road without noise does not.
        turns = abs(speed) * self._radius >= _STANDS and torque >= _BRAKED
        if self._same is None or self._same[1] != speed or not turns:
            self._same = (stamp, speed)
            return ""
        for_time = (stamp - self._same[0]) / NANOSECONDS
        return f"repeats {speed:.3f} rad/s: stuck" if for_time >= _REPEATS else ""

    def _against_car(self, stamp: int, rim: float, around: Surroundings) -> str:
        others, car = around.others, around.car_speed
        supported = isfinite(car) and (
            around.car_is_measured or any(abs(each - car) < _FASTER * car for each in others)
        )
        if not around.torque < _BRAKED or self._braked is None:
            self._braked = stamp
        braked = around.torque >= _BRAKED
        free = stamp - self._braked > _FREE_FOR * NANOSECONDS
        # Wheels that agree with this one against the car speak for a wrong speed of the car.
        backed = any(each > (1.0 - _FASTER) * rim for each in others)
        faster = braked and supported and not backed and rim > (1.0 + _FASTER) * car + _STANDS
        if self._faster.update(stamp, faster):
            return f"turns with {rim:.1f} m/s, braked, where the car has {car:.1f} m/s"
        against = max(others) if others else car if around.car_is_measured else nan
        apart = free and against > _MOVES and abs(rim - against) > _APART * against
        apart = apart and not any(abs(rim - each) < _APART * rim for each in others)
        comes_back = self._back.update(apart, rim, against)
        apart = apart and not comes_back
        self._apart.duration = (_APART_FOR if abs(rim) > _STANDS else _FASTER_FOR) * NANOSECONDS
        if self._apart.update(stamp, apart):
            return f"turns with {rim:.1f} m/s, rolling freely, where the car has {against:.1f} m/s"
        return ""
