"""Prior divergence: fits far from the vehicle file, and the conditions for trusting them again.

What they fold then is wrong, and so is what they find next. Before any of it was valid, it is forgotten instead, and is
valid only after a wheel has left its car as a wheel beyond its peak does. What was valid before stays: an
accelerometer that fails in mid-stop must not take the curve from a law.
"""

from collections.abc import Sequence
from math import inf

from friction_curve_id.car.car_constants import CarConstants
from friction_curve_id.car.fit import CurveFit
from friction_curve_id.car.node_signals import Nodes, departs

_SURPRISE = 3.0
"""Most deviations by which the sum of the squared unknowns of every family may exceed what the prior lets expect."""
_CALM = 0.05
"""Time since the fits were last astray before what they find is valid again [s]: each has made a step since."""
_CAPACITY = 160
"""Most samples of the window while the fits have gone astray: the sooner they are rid of what led them there."""


class Astray:
    """What is known of it on one road."""

    def __init__(self) -> None:
        """Begin on a road of which nothing is known."""
        self._surprised = self._departed = False
        self._surprised_at = -inf
        self.was_valid = False
        """Whether what the fits find was valid."""
        self.forgot = False
        """Whether something was forgotten."""

    def stepped(self, time: float, fits: Sequence[CurveFit], car: CarConstants, nodes: Nodes) -> None:
        """Take the fits after a step of one of them at `time` [s]."""
        self._surprised = min(fit.surprise for fit in fits) > _SURPRISE
        if self._surprised:
            self._surprised_at = time
        if self.forgot and not self._departed:
            self._departed = departs(car, nodes)

    @property
    def forgets(self) -> bool:
        """Whether what leaves the window is to be forgotten."""
        return self._surprised and not self.was_valid

    @property
    def unexplained(self) -> bool:
        """Whether what the fits find is not that of the car."""
        return self._surprised or (self.forgot and not self._departed)

    def calm(self, time: float) -> bool:
        """Whether the fits have not been astray for long enough at `time` [s]."""
        return time - self._surprised_at >= _CALM

    def capacity(self, usual: int) -> int:
        """Return how many samples the window may hold instead of the `usual` ones."""
        return _CAPACITY if self.forgot and self._surprised else usual
