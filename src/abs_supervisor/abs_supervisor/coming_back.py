"""Wheel recovery: a wheel slower than its car that gains speed; on ice it takes seconds.

A sensor that reads a share of the speed gains while the car gains more, and comes nearer only while it falls itself.
"""

from typing import Final

_GAIN: Final = 0.5
"""[m/s] far more than the noise of a wheel; ice gives that within 0.05 s."""


class ComingBack:
    """Follows one wheel while it is apart from its car."""

    def __init__(self) -> None:
        """Start with nothing seen."""
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._from: tuple[float, float] | None = None

    def update(self, apart: bool, rim: float, against: float) -> bool:
        """Return whether the wheel has gained speed, and on its car, since that was last so.

        Args:
            apart: whether it is apart at all.
            rim: its circumferential speed [m/s].
            against: that of wheels that roll with the car [m/s].
        """
        if not apart:
            self._from = None
            return False
        behind = abs(against - rim)
        gained = self._from is not None and rim > self._from[0] + _GAIN and behind < self._from[1] - _GAIN
        if gained or self._from is None:
            self._from = (rim, behind)
        return gained
