"""Coasting segments: mean rim speeds of wheels that roll without force.

The accelerometer reads the force of all tyres over the mass of the car, whatever the slope of the road; its own offset
may be in it, or be learned and taken off, so the smaller of the two readings counts. Without an accelerometer a car
that keeps its speed is the only sign. Wheels that change their speed unlike the others are braked, spin or bounce.
"""

from collections.abc import Sequence
from math import isfinite
from statistics import median
from typing import Final, NamedTuple

from vehicle_models.nanoseconds import NANOSECONDS

_LENGTH: Final = 0.25
"""Length of a stretch [s]: at 200 Hz the mean of a rim speed then has a noise of 3 mm/s."""
_FORCELESS: Final = 0.6
"""Largest force of all tyres over the mass of the car [m/s^2]: drag, a gentle engine; half of what ice bears."""
_LARGEST_OFFSET: Final = 0.3
"""What is taken off of a learned offset [m/s^2]: more of it is a slope, down which brakes may hold the car."""
_STEEPEST: Final = 2.0
"""Largest change of the rim speeds [m/s^2]: a slope without force."""
_UNLIKE: Final = 1.0
"""Largest difference of a wheel's change from that of the others [m/s^2]."""
_LOWEST_SPEED: Final = 3.0
"""Lowest speed at the rim [m/s]: below it that noise is more than a thousandth, what relative_radii expects."""
_PLAUSIBLE: Final = 0.15
"""Share by which the radius of a wheel may be wrong: beyond, it slips, or its encoder is another one."""


class Stretch(NamedTuple):
    """Means over one stretch."""

    rim_speeds: list[float]
    """r omega of each wheel [m/s], positive."""
    force: float
    """Force of all tyres over the mass of the car [m/s^2], forward positive; the offset of its sensor is in it."""
    seconds: float
    """Length [s]."""


class FreeRolling:
    """Collects the stretches of one car."""

    def __init__(self) -> None:
        """Start without samples."""
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._begin: int | None = None
        self._last = 0
        self._first: list[float] = []
        self._sums: list[float] = []
        self._force = 0.0
        self._count = 0
        self._gauged = False

    def update(
        self, stamp: int, rim_speeds: Sequence[float], reading: float | None, offset: float, longest_step: float
    ) -> Stretch | None:
        """Take one sample.

        Args:
            stamp: stamp of the sample [ns], later than the last.
            rim_speeds: filtered r omega of each wheel [m/s], not finite where unknown.
            reading: of the accelerometer [m/s^2], forward positive; None if there is none.
            offset: what is known of its offset [m/s^2].
            longest_step: a longer time between two samples [s] ends a stretch without a result.

        Returns:
            The stretch that ends with this sample, None where none does.
        """
        gauged = reading is not None
        offset = max(-_LARGEST_OFFSET, min(offset, _LARGEST_OFFSET))
        small = reading is None or min(abs(reading), abs(reading - offset)) <= _FORCELESS
        if not small or not all([isfinite(speed) for speed in rim_speeds]):
            self._begin = None
            return None
        if self._begin is None or gauged != self._gauged or stamp - self._last > longest_step * NANOSECONDS:
            self._begin, self._last, self._gauged = stamp, stamp, gauged
            self._first, self._sums = list(rim_speeds), [0.0] * len(rim_speeds)
            self._force, self._count = 0.0, 0
            return None
        self._last = stamp
        for index, speed in enumerate(rim_speeds):
            self._sums[index] += speed
        self._force += reading or 0.0
        self._count += 1
        seconds = (stamp - self._begin) / NANOSECONDS
        if seconds < _LENGTH:
            return None
        self._begin = None
        means = [each / self._count for each in self._sums]
        rates = [(now - before) / seconds for now, before in zip(rim_speeds, self._first, strict=True)]
        middle, rate = median(means), median(rates)
        if (
            middle < _LOWEST_SPEED
            or abs(rate) > (_STEEPEST if gauged else _FORCELESS)
            or any([abs(each - rate) > _UNLIKE for each in rates])
            or any([abs(each - middle) > _PLAUSIBLE * middle for each in means])
        ):
            return None
        return Stretch(means, self._force / self._count if gauged else rate, seconds)
