"""Wheel speed as a control unit gets it from a toothed ring, and an ideal one."""

from collections.abc import Sequence
from math import floor, pi, sqrt

import numpy as np


class Encoder:
    """Counts edges over a sample interval and the time between the last edges before its ends.

    A published speed is n 2 pi / teeth / (t_last - t_last_before): the mean speed over the time between two edges,
    which ends up to a tooth before the stamp. Times are of a timer of 1 microsecond. Without a new edge the speed is at
    most a tooth over the time since the last edge, and the last one otherwise. Where the ring lacks teeth no edges
    come, and the unit does not know it.
    """

    TIMER = 1e-6
    """Resolution of the edge times [s]."""

    def __init__(self, teeth: int, speed: float, angle: float, missing: int = 0) -> None:
        """Begin at `speed` [rad/s] and `angle` [rad] of the wheel after its last edge, in [0, 2 pi / teeth).

        The last `missing` of the `teeth` in a revolution are not there.
        """
        self._teeth, self._missing = teeth, missing
        self._seen = 0
        self._pitch = 2.0 * pi / teeth
        self._angle = angle
        self._edge_count = 0
        self._edge_time = -angle / speed
        self._published = (0, self._edge_time, speed)

    def turn(self, time: float, dt: float, begin: float, end: float) -> None:
        """Take the motion from `time` [s] over dt [s], its speed [rad/s] changing linearly."""
        before = self._angle
        self._angle += 0.5 * dt * (begin + end)
        count = floor(self._angle / self._pitch)
        while count > self._edge_count and count % self._teeth >= self._teeth - self._missing:
            count -= 1
        if count > self._edge_count:
            gone = count // self._teeth - self._edge_count // self._teeth
            self._seen += count - self._edge_count - gone * self._missing
            self._edge_count = count
            # angle of the last edge: (begin + growth t / 2) t = rest
            rest, growth = count * self._pitch - before, (end - begin) / dt
            passed = 2.0 * rest / (begin + sqrt(max(begin * begin + 2.0 * growth * rest, 0.0)))
            self._edge_time = round((time + min(passed, dt)) / self.TIMER) * self.TIMER

    def publish(self, time: float) -> float:
        """Wheel speed [rad/s] of the interval that ends at `time` [s]."""
        count, edge_time, speed = self._published
        if self._seen > count:
            speed = (self._seen - count) * self._pitch / (self._edge_time - edge_time)
        elif time > edge_time:
            speed = min(speed, self._pitch / (time - edge_time))
        self._published = (self._seen, self._edge_time, speed)
        return speed


def ideal(speeds: Sequence[float], variance: float, rng: np.random.Generator) -> list[float]:
    """Wheel speeds at their stamp with white noise of `variance` [rad^2/s^2], as in section 8.3.2."""
    noise = rng.normal(0.0, sqrt(variance), len(speeds)).tolist()
    return [speed + error for speed, error in zip(speeds, noise, strict=True)]
