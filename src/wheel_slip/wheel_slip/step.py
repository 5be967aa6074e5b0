"""One step of the filter of the car's motion: means of the samples, and the way that acceleration makes."""

from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vehicle_models.nanoseconds import NANOSECONDS

Array = NDArray[np.float64]


class Means(NamedTuple):
    """Of the samples of one step."""

    stamp: float
    """[ns]"""
    rim_speeds: Array
    """[m/s], shape (wheels,)."""
    way: float
    """Integral of the accelerometer's reading since the start [m/s]."""
    samples: int


class Step:
    """The step that is going on."""

    def __init__(self, count: int) -> None:
        """Start without samples of `count` wheels."""
        self._count = count
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._ways: deque[tuple[int, float]] = deque(maxlen=512)
        self._last: int | None = None
        self.reading: float | None = None
        """Of the accelerometer, forward positive [m/s^2]; None if there is none."""
        self.felt = 0.0
        """The same where there is one, and what stands in for it where there is none [m/s^2]."""
        self.way = 0.0
        """Integral of that since the start [m/s]."""
        self.begin(0)

    def begin(self, stamp: int) -> None:
        """Begin the next step at a stamp [ns]."""
        self.stamp = stamp
        """Beginning of the step [ns]."""
        self.samples, self.moved = 0, 0.0
        """Number of samples; change of the reading [m/s^2]."""
        self._sums, self._stamps, self._ways_sum = np.zeros(self._count), 0, 0.0
        self._torques: list[Sequence[float]] = []
        self._yaw_rates: list[float] = []
        self._way_before = self.way

    def pauses(self, stamp: int) -> bool:
        """Whether there was no sample for more than a second before a stamp [ns]."""
        return self._last is not None and stamp - self._last > NANOSECONDS

    def add(
        self,
        stamp: int,
        rim_speeds: Sequence[float],
        reading: float | None,
        torques: Sequence[float],
        yaw_rate: float | None,
    ) -> None:
        """Take one sample; arguments as those of CarMotion.update."""
        dt = 0.0 if self._last is None else (stamp - self._last) / NANOSECONDS
        self._last = stamp
        if reading is not None and self.reading is not None:
            self.moved += reading - self.reading
        self.reading = reading
        if reading is not None:
            self.felt = reading
        self.way += dt * self.felt
        self._ways.append((stamp, self.way))
        self._sums += rim_speeds
        self._torques.append(torques)
        self._stamps += stamp - self.stamp
        self._ways_sum += self.way
        self.samples += 1
        if yaw_rate is not None:
            self._yaw_rates.append(yaw_rate)

    @property
    def since(self) -> float:
        """Time from its beginning to the last sample [s]."""
        return 0.0 if self._last is None else (self._last - self.stamp) / NANOSECONDS

    @property
    def gone(self) -> float:
        """Way since its beginning [m/s]."""
        return self.way - self._way_before

    @property
    def means(self) -> Means:
        """Of its samples, of which there is at least one."""
        count = self.samples
        return Means(self.stamp + self._stamps / count, self._sums / count, self._ways_sum / count, count)

    @property
    def torques(self) -> list[float]:
        """Mean of the torques of all brakes [N m]; empty where one sample has none."""
        every = [each for each in self._torques if len(each) == self._count]
        return np.mean(every, axis=0).tolist() if len(every) == self.samples else []

    @property
    def yaw_rate(self) -> float | None:
        """Mean of the yaw rates [rad/s], None where there is none."""
        return sum(self._yaw_rates) / len(self._yaw_rates) if self._yaw_rates else None

    def gone_since(self, stamp: float) -> float | None:
        """Return the way from a stamp [ns] to the beginning of the step [m/s]; None where it is forgotten."""
        then = next((way for when, way in reversed(self._ways) if when <= stamp), None)
        return None if then is None else self._way_before - then
