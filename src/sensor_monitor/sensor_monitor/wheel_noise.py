"""Wheel-speed noise, estimated where it exceeds the specified one (coarse counters, loose sensors, bent encoder rings).

What wheels that turn alike differ by from their mean, x, changes slowly: by curves and slips. What is left of it beside
a parabola over a window of time is noise, of a variance R in each of n wheels, and second differences of neighbouring
samples have the part of it that is white, R_w:

    mean of (x - parabola)^2 = R (1 - 1/n),    mean of (x_k - 2 x_(k-1) + x_(k-2))^2 = 6 R_w (1 - 1/n)

A wheel that is alone is compared with what the car feels, without the 1/n. What is not white lasts from sample to
sample, as that of a ring which is not round, and no filter averages it out.
"""

from collections.abc import Sequence
from math import isfinite, nan
from typing import Final

import numpy as np

from sensor_monitor.signal_noise import MORE
from vehicle_models.nanoseconds import NANOSECONDS

_WINDOW: Final = NANOSECONDS // 4
"""[ns]: a turn of a wheel at 8 m/s."""
_GAP: Final = 3 * NANOSECONDS // 20
"""Longest time between two samples of a window [ns]."""
_LEAST: Final = 6
"""Samples of one."""
_PARABOLA: Final = 3
_MEMORY: Final = 8
"""Windows of the mean: 2 s."""
_FIRST: Final = 2
"""Windows from which on there is one."""


class WheelNoise:
    """Of the wheels of one car. `variance` is the one that counts [rad^2/s^2]."""

    def __init__(self, stated: float) -> None:
        """Start with what is stated: a variance [rad^2/s^2]."""
        self._stated = stated
        self.reset()

    def reset(self) -> None:
        """Know what is stated."""
        self.variance = self._stated
        self.lasting = 0.0
        """Part of it that lasts from sample to sample [rad^2/s^2]."""
        self._seen, self._white = self._stated, self._stated
        self._count = 0
        self._stamps: list[int] = []
        self._apart: list[list[float]] = []

    def update(self, stamp: int, wheel_speeds: Sequence[float], alike: bool, felt: float = nan) -> None:
        """Take one sample.

        Args:
            stamp: [ns], later than the last.
            wheel_speeds: as measured [rad/s].
            alike: whether the wheels turn alike, and as the car moves.
            felt: change of the car's speed over the radius [rad/s], with which a wheel that is alone is compared.
        """
        count = len(wheel_speeds)
        mean, free = (sum(wheel_speeds) / count, count - 1) if count > 1 else (felt, 1)
        if not alike or not isfinite(mean):
            return
        if self._stamps and stamp - self._stamps[-1] > _GAP:
            self._clear()
        self._stamps.append(stamp)
        self._apart.append([each - mean for each in wheel_speeds])
        if stamp - self._stamps[0] >= _WINDOW and len(self._stamps) >= _LEAST:
            self._look(free)
            self._clear()

    def _clear(self) -> None:
        self._stamps.clear()
        self._apart.clear()

    def _look(self, free: int) -> None:
        """Take the window, of whose differences `free` at each sample are independent."""
        x, time = np.array(self._apart), np.array(self._stamps, dtype=np.float64) - self._stamps[0]
        basis, _ = np.linalg.qr((time[:, np.newaxis] / time[-1]) ** np.arange(_PARABOLA))
        rest, second = x - basis @ (basis.T @ x), np.diff(x, 2, axis=0)
        self._count += 1
        newest = 1.0 / min(self._count + 1, _MEMORY)
        self._seen += newest * (float(np.square(rest).sum()) / ((time.size - _PARABOLA) * free) - self._seen)
        self._white += newest * (float(np.square(second).sum()) / (6.0 * (time.size - 2) * free) - self._white)
        if self._count >= _FIRST:
            # Not below: a wheel filter of too much noise lags.
            self.variance = self._seen if self._seen > MORE * self._stated else self._stated
            self.lasting = max(self.variance - max(self._white, self._stated), 0.0)
