"""Frozen wheel speed check: a wheel that repeats one speed to the last bit while the others change theirs.

One that rolls steadily on a road without noise repeats its speed as well, and so does a coarse sensor; then the other
wheels keep theirs.
"""

from collections.abc import Sequence
from math import isfinite
from statistics import median
from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS

_REPEATS: Final = round(0.05 * NANOSECONDS)
"""Time for which a wheel repeats its speed at least [ns]."""
_CHANGED: Final = 0.5
"""Change of the others' speeds meanwhile [m/s]."""


class FrozenWheels:
    """Watches the wheels of a car."""

    def __init__(self) -> None:
        """Start without samples."""
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._same: dict[int, tuple[int, tuple[float, ...]]] = {}
        """By wheel: stamp since which it repeats its speed [ns], and the speeds of all wheels then."""

    def update(self, stamp: int, rim_speeds: Sequence[float]) -> list[bool]:
        """Take the rim speeds of all wheels at a stamp [ns], not finite where missing; return which are frozen."""
        now = tuple(rim_speeds)
        return [self._is_frozen(index, stamp, now) for index in range(len(now))]

    def _is_frozen(self, index: int, stamp: int, rim_speeds: tuple[float, ...]) -> bool:
        speed, same = rim_speeds[index], self._same.get(index)
        if same is None or same[1][index] != speed or speed == 0.0:
            self._same[index] = (stamp, rim_speeds)
            return False
        since, before = same
        if stamp - since < _REPEATS:
            return False
        changes = [
            abs(now - then)
            for place, (now, then) in enumerate(zip(rim_speeds, before, strict=True))
            if place != index and isfinite(now) and isfinite(then)
        ]
        return bool(changes) and median(changes) > _CHANGED
