"""Speed probe: one rear wheel is braked less for a moment, so that a long slide keeps a speed reference.

Where the speed of the car is integrated, a slip that is held at its peak shows nothing of that speed, and its standard
deviation grows. A wheel with little brake torque shows the speed as soon as its tyre has sprung back.
"""

from collections.abc import Sequence
from math import isfinite
from typing import Final

from abs_supervisor.measurements import GAP
from vehicle_models.nanoseconds import NANOSECONDS

WORTH: Final = 12.0
"""[-] time that is left of the braking over that of a probe, weighed by the variance of the slip over the square of the
slip that is held: from here on the error costs more than a probe."""
PAUSE: Final = 1.0
"""[s] from one probe to the next at least."""
LOWERS: Final = 0.05
"""[s] that the brake takes to be as low as that."""
WAY: Final = 1.6
"""[m] within which a tyre springs back: several of its relaxation lengths."""
SHOWS: Final = 0.045
"""[s] for which the wheel is then seen to turn with the car."""
LONGEST: Final = 0.35
"""[s] from the first command on, whatever is measured."""
ABOVE: Final = 6.0
"""[m/s] below, the wheel would roll for too long."""
CURVE_YAW_RATE, CURVE_LATERAL = 0.06, 1.0
"""[rad/s] and [m/s^2] from which on the car is in a curve, and keeps its rear wheels."""


class SpeedProbe:
    """The wheels of one car: chooses the one that rolls. Each asks at each of its samples."""

    def __init__(self, wheels: Sequence[str]) -> None:
        """Choose the wheels that take turns."""
        self._wheels = wheels
        self._newest = 0
        self.reset()

    def reset(self) -> None:
        """Begin another braking."""
        self._turns = list(self._wheels)
        self._ended: int | None = None
        self._rolling = ""
        self._began = 0
        self._lowered: int | None = None

    def rolls(
        self, wheel: str, stamp: int, speed: float, stddev: float, deceleration: float, lowered: bool, held: float
    ) -> bool:
        """Return whether a wheel is to roll.

        Args:
            wheel: its name.
            stamp: of the sample [ns].
            speed: of the car [m/s].
            stddev: of the speed [m/s], NaN where no probe may begin.
            deceleration: of the car [m/s^2], NaN where unknown.
            lowered: whether its brake is as low as a probe needs.
            held: slip that its law holds below the demand [-]; NaN where it does not, or may not roll.
        """
        if not -GAP * NANOSECONDS < stamp - self._newest < GAP * NANOSECONDS:
            self.reset()
        self._newest = stamp
        if self._rolling and stamp - self._began > LONGEST * NANOSECONDS:
            self._end(stamp)
        if self._rolling:
            return self._rolling == wheel and self._goes_on(stamp, speed, lowered)
        if self._turns[0] != wheel or not isfinite(held) or not speed > ABOVE:
            return False
        waits = self._ended is not None and stamp - self._ended < PAUSE * NANOSECONDS
        left = speed / max(deceleration, 0.1)
        if waits or not (stddev / (held * speed)) ** 2 * left > WORTH * (LOWERS + WAY / speed + SHOWS):
            return False
        self._turns = [*self._turns[1:], wheel]
        self._rolling, self._began, self._lowered = wheel, stamp, None
        return True

    def _goes_on(self, stamp: int, speed: float, lowered: bool) -> bool:
        if self._lowered is None and lowered:
            self._lowered = stamp
        rolled = 0.0 if self._lowered is None else (stamp - self._lowered) / NANOSECONDS
        if not speed > 0.0 or rolled > WAY / speed + SHOWS:
            self._end(stamp)
        return bool(self._rolling)

    def _end(self, stamp: int) -> None:
        self._rolling, self._ended = "", stamp
