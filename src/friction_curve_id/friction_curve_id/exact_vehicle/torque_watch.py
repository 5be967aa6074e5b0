"""Torque samples that leave the trend of those before them.

A wheel answers a torque through its inertia: for some samples a wrong torque looks like a different road. So a torque
that leaves the trend is suspect, and its wheel equations are set aside. Five in a row may be wrong; a sixth means that
the torque has changed its trend, and all six count.
"""

from collections import deque
from dataclasses import dataclass

import numpy as np

_TREND = 6
"""Samples in the trend."""
_LONGEST = 5
"""Most suspect samples in a row; more are the new trend."""


@dataclass(frozen=True)
class TorqueVerdict:
    """Judgement on a torque."""

    suspect: bool
    torque: float
    """Torque to use [N m]: the measured one, or that of the trend in place of a suspect one."""
    rehabilitated: list[float]
    """Torques before this one [N m] that were suspect and are the new trend."""


class TorqueWatch:
    """Compares each torque with the straight line through the latest trusted ones."""

    def __init__(self, noise: float, threshold: float = 6.5) -> None:
        """Set the noise of the torque [N m], and the distance from the trend that is suspect, in multiples of it."""
        self._limit = threshold * noise
        self._trusted: deque[tuple[float, float]] = deque(maxlen=_TREND)
        self._suspects: list[tuple[float, float]] = []

    def reset(self) -> None:
        """Forget the trend."""
        self._trusted.clear()
        self._suspects.clear()

    def judge(self, time: float, torque: float) -> TorqueVerdict:
        """Take the next sample [s], [N m]."""
        expected = self._expected(time) if len(self._trusted) == _TREND else torque
        suspect = abs(torque - expected) > self._limit
        rehabilitated: list[float] = []
        if suspect and len(self._suspects) < _LONGEST:
            self._suspects.append((time, torque))
            return TorqueVerdict(True, expected, rehabilitated)
        if suspect:
            rehabilitated = [value for _, value in self._suspects]
            self._trusted.clear()
            self._trusted.extend(self._suspects)
        self._trusted.append((time, torque))
        self._suspects.clear()
        return TorqueVerdict(False, torque, rehabilitated)

    def _expected(self, time: float) -> float:
        times, torques = np.array(self._trusted).T
        centred = times - times.mean()
        rate = (centred @ torques) / (centred @ centred)
        return float(torques.mean() + rate * (time - times.mean()))
