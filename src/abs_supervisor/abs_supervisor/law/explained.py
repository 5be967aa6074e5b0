"""Model mismatch: torque that the friction curve leaves unexplained at its wheel.

A method that fits one curve to all wheels has a wrong one for each of them where the sides of the road differ.
"""

from typing import Final

from friction_runtime.filters import Debounce
from vehicle_models.nanoseconds import NANOSECONDS

LITTLE: Final = 0.35
"""Of the torque that the road gives at its peak: a smaller disturbance is an error of the car, not another road."""
_MUCH: Final = 0.5
"""Of it: a larger one is not explained."""
_TIME: Final = round(0.6 * NANOSECONDS)
"""[ns] for which it has to be so. On another road the fit begins anew, and has a curve, in less."""


class Explained:
    """Follows the disturbance torque of one wheel."""

    def __init__(self) -> None:
        """Start with a curve that does."""
        self._contrary = Debounce(_TIME)
        self.reset()

    def reset(self) -> None:
        """Begin again, with a curve that explains its wheel."""
        self.holds = True
        """Whether it does; it changes when the contrary was so for 0.6 s."""
        self._contrary.reset()

    def update(self, stamp: int, share: float) -> None:
        """Take the size of the disturbance torque over that of the peak [-] at a stamp [ns], later than the last."""
        contrary = share > _MUCH if self.holds else share < LITTLE
        if self._contrary.update(stamp, contrary):
            self.holds = not self.holds
            self._contrary.reset()
