"""Frozen wheel speed check: a wheel that repeats one speed while the others change theirs, or stops at once.

It repeats it to the last bit. One that rolls steadily on a road without noise does so as well, and so does a coarse
sensor; then the other wheels keep theirs. A lock takes time: no brake stops a fast wheel from one sample to the next.
"""

from collections.abc import Sequence
from math import isfinite, nan
from statistics import median
from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.physical_bounds import STANDING

_REPEATS: Final = round(0.05 * NANOSECONDS)
"""Time for which a wheel repeats its speed at least [ns]."""
_CHANGED: Final = 0.5
"""Change of the others' speeds meanwhile [m/s]."""
_HARDEST: Final = 2000.0
"""Deceleration of its circumference by the strongest brake of a car [m/s^2]: 5 kN m at 0.75 kg m^2 and 0.3 m."""
STUCK, DEAD = "stuck", "dead"


class FrozenWheels:
    """Watches the wheels of a car."""

    def __init__(self) -> None:
        """Start without samples."""
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._last: dict[int, tuple[int, float]] = {}
        """By wheel: stamp [ns] and speed [m/s] of its last sample."""
        self._dead: set[int] = set()
        """Wheels that stopped at once, and stand."""
        self._same: dict[int, tuple[int, tuple[float, ...], float]] = {}
        """By wheel: stamp since which it repeats its speed [ns], the speeds of all wheels then, and what was felt."""

    def update(self, stamp: int, rim_speeds: Sequence[float], felt: float = nan) -> list[str]:
        """Return what is wrong with each wheel: STUCK, DEAD, or empty where nothing is.

        Args:
            stamp: [ns]
            rim_speeds: of all wheels [m/s], not finite where missing.
            felt: integral of the car's acceleration [m/s], with which a wheel that is alone is compared.
        """
        now = tuple(rim_speeds)
        stuck = [self._is_frozen(index, stamp, now, felt) for index in range(len(now))]
        dead = [self._is_dead(index, stamp, speed) for index, speed in enumerate(now)]
        return [DEAD if stops else STUCK if keeps else "" for keeps, stops in zip(stuck, dead, strict=True)]

    def _is_dead(self, index: int, stamp: int, speed: float) -> bool:
        """Whether a wheel stands since it stopped at once."""
        if isfinite(speed):
            since, before = self._last.get(index, (stamp, speed))
            self._last[index] = (stamp, speed)
            if abs(speed) >= STANDING:
                self._dead.discard(index)
            elif before - speed > _HARDEST * (stamp - since) / NANOSECONDS + STANDING:
                self._dead.add(index)
        return index in self._dead

    def _is_frozen(self, index: int, stamp: int, rim_speeds: tuple[float, ...], felt: float) -> bool:
        speed, same = rim_speeds[index], self._same.get(index)
        if same is None or same[1][index] != speed or speed == 0.0:
            self._same[index] = (stamp, rim_speeds, felt)
            return False
        since, before, felt_before = same
        if stamp - since < _REPEATS:
            return False
        changes = [
            abs(now - then)
            for place, (now, then) in enumerate(zip(rim_speeds, before, strict=True))
            if place != index and isfinite(now) and isfinite(then)
        ]
        return (median(changes) if changes else abs(felt - felt_before)) > _CHANGED
