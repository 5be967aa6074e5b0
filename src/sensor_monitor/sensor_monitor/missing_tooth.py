"""Missing-tooth filter: speed errors at the gap of a toothed ring such as 60-2.

Over the gap fewer edges pass than pitches, so once in every revolution a speed is too low, by m pitches over the time
between its edges. Such samples are discarded. A wheel that dives is low as well, but not at one angle, and for longer:
once two gaps were a revolution apart, only what is too low at that angle is taken for the gap.
"""

from math import pi
from typing import Final

_TURN: Final = 2.0 * pi
_NEAR: Final = 0.1
"""Share of a revolution by which the angle may have drifted since the last gap."""
_LOST: Final = 3.0
"""Revolutions without a gap after which its angle is no longer known: the wheel was locked, or lifted."""
_CONFIRMED: Final = 2
"""Gaps a revolution apart from which on the angle is known."""
_UNLIKELY: Final = 3.0
"""Standard deviations below the expected speed from which on a speed at that angle is of the gap."""


class MissingTooth:
    """The gap of one ring."""

    def __init__(self, missing: int, pitch: float) -> None:
        """Know nothing; `missing` teeth in a row of a ring with a pitch [rad] that counts them."""
        self._missing = missing
        self._pitch = pitch
        self.reset()

    def reset(self) -> None:
        """Forget where it is."""
        self._since = 0.0
        self._count = 0

    def holds(self, dt: float, expected: float, measured: float, deviation: float) -> bool:
        """Take a sample; return whether its speed is that of the gap.

        Args:
            dt: time since the last sample [s].
            expected: speed of the wheel [rad/s] by what it did before.
            measured: speed that was measured [rad/s].
            deviation: of their difference, without a gap [rad/s].
        """
        turned = abs(expected) * dt
        self._since += turned
        if self._since > _LOST * _TURN:
            self._count, self._since = 0, 0.0
        # Speeds are over the time since the last edge, and over the gap at least.
        gap = self._missing * self._pitch
        falls = gap / (turned + gap + self._pitch) * abs(expected)
        lower = abs(expected) - abs(measured)
        off = abs((self._since + 0.5 * _TURN) % _TURN - 0.5 * _TURN)
        there = off < _NEAR * _TURN + turned + gap
        known = self._count >= _CONFIRMED
        if lower < (min(_UNLIKELY * deviation, 0.5 * falls) if known and there else 0.5 * falls):
            return False
        if self._since < 0.5 * _TURN and self._count:
            return self._since < gap + 2.0 * self._pitch
        if known and not there:
            return False
        self._count = self._count + 1 if there else 1
        self._since = 0.0
        return True
