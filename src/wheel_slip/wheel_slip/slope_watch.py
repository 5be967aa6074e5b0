"""Grade change detector: a lasting difference between equally turning wheels and the accelerometer.

The accelerometer does not see a slope of the road: reading = acceleration + g sin(slope). So a step of the slope makes
wheels that roll, or slip steadily, change their speed by up to 1.5 m/s^2 more or less than the corrected reading says.
A wheel that dives differs by much more, for a shorter time, and not alike with the others. Wheels that slip steadily
change their speed by their slip less than the car: r omega' = (1 - s) v'. That is no slope of the road, as large as
the slip is at present. A slope that makes them lose less than the car makes that slip smaller, not larger.
"""

from collections.abc import Sequence

from friction_runtime.filters import Debounce
from vehicle_models.nanoseconds import NANOSECONDS
from wheel_slip.tuning import SlopeTuning


class SlopeWatch:
    """Follows the wheels of one car."""

    def __init__(self, parameters: SlopeTuning) -> None:
        """Start without samples."""
        self._p = parameters
        self._lasting = Debounce(parameters.lasting * NANOSECONDS)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.mismatch = 0.0
        """Acceleration of the wheels minus that of the car [m/s^2] where a slope may be the reason, else 0."""
        self._unlike: int | None = None
        self._lasting.reset()

    def update(self, stamp: int, alike: bool, differences: Sequence[float], acceleration: float, slip: float) -> None:
        """Take one sample.

        Args:
            stamp: stamp of the sample [ns].
            alike: whether all wheels turn alike.
            differences: acceleration of each wheel minus that of the car [m/s^2], over a short window; finite.
            acceleration: of the car [m/s^2].
            slip: of the wheels against the speed that is integrated [-], braking positive; NaN where that is unknown.
        """
        self.mismatch = 0.0
        if not alike:
            self._unlike = stamp
        if not differences or (self._unlike is not None and stamp - self._unlike < self._p.alike * NANOSECONDS):
            self._lasting.reset()
            return
        difference = sorted(differences)[len(differences) // 2]
        may_stay, by_slip = self._p.steady_slip * abs(acceleration), slip * -acceleration
        if difference > 0.0 and by_slip > may_stay:
            may_stay = by_slip
        if not self._p.least + may_stay < abs(difference) < self._p.steepest:
            self._lasting.reset()
            return
        if self._lasting.update(stamp, True):
            self.mismatch = difference
