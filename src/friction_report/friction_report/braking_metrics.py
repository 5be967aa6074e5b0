"""Quality of a braking: stopping distance, adhesion utilisation, slope crossings against the truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_bags.results.recorded_run import CrossingEvent
from vehicle_models.constants import GRAVITY

Array = NDArray[np.float64]

BUILD_UP = 0.4
"""Time [s] after brake onset in which the torque builds up; utilisation is also given without it."""

_CROSSING_REACH = 0.2
"""Time [s] between an estimated crossing and the true one it may belong to; ABS cycles last 0.1 to 0.3 s."""


@dataclass(frozen=True)
class Braking:
    """One braking from its onset to the end speed. SI units."""

    onset: float
    """Time of brake onset [s]."""
    initial_speed: float
    end_speed: float
    duration: float
    distance: float
    """Distance covered [m]."""
    ideal_distance: float
    """Distance with mu = mu_max all the way, on the same road [m]."""
    utilisation: float
    """Mean of mu / mu_max over time, from onset to the end speed."""
    utilisation_built_up: float
    """The same without the first 0.4 s; NaN where the braking is shorter."""


def measure_braking(
    time: Array, speed: Array, mu: Array, mu_max: Array, onset: float, end_speed: float = 5.0
) -> Braking:
    """Measure a braking against the ideal.

    The ideal car decelerates with g mu_max of the road under it: its speed squared falls by the integral of
    2 g mu_max over distance, from the same place and speed.

    Args:
        time: time of the samples [s], shape (n,), increasing.
        speed: vehicle speed [m/s], shape (n,).
        mu: friction coefficient used [-], shape (n,), mean over wheels.
        mu_max: friction coefficient at the peak of the road under the wheels [-], shape (n,).
        onset: time of brake onset [s].
        end_speed: speed at which the measurement ends [m/s].

    Raises:
        ValueError: the speed is never above end_speed after the onset, or fewer than two samples are.
    """
    chosen = (time >= onset) & np.logical_and.accumulate((speed > end_speed) | (time < onset))
    if np.count_nonzero(chosen) < 2:
        raise ValueError(f"no braking above {end_speed} m/s after t = {onset:.2f} s")
    t, v, ratio = time[chosen], speed[chosen], (mu / mu_max)[chosen]
    steps = np.diff(t)
    covered = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * steps)])
    available = mu_max[chosen]
    ideal_loss = np.concatenate([[0.0], np.cumsum(GRAVITY * (available[1:] + available[:-1]) * np.diff(covered))])
    built_up = t >= onset + BUILD_UP
    return Braking(
        onset=onset,
        initial_speed=float(v[0]),
        end_speed=float(v[-1]),
        duration=float(t[-1] - t[0]),
        distance=float(covered[-1]),
        ideal_distance=float(np.interp(v[0] ** 2 - v[-1] ** 2, ideal_loss, covered)),
        utilisation=float(np.mean(ratio)),
        utilisation_built_up=float(np.mean(ratio[built_up])) if np.any(built_up) else float("nan"),
    )


@dataclass(frozen=True)
class JudgedCrossing:
    """An estimated crossing with the true one that it belongs to."""

    estimate: CrossingEvent
    lambda_max: float
    """True slip at the peak of the road at that time [-]."""
    true_time: float
    """Time of the true crossing [s]; NaN where there is none near."""

    @property
    def delay(self) -> float:
        """Time from the true crossing until it was known [s], negative if predicted; NaN without a true one."""
        return self.estimate.time - self.true_time

    @property
    def relative_error(self) -> float:
        """Error of the slip at the crossing as an estimate of lambda_max [-]."""
        return self.estimate.slip / self.lambda_max - 1.0


def judge_crossings(
    estimates: Sequence[CrossingEvent], truth: Sequence[CrossingEvent], time: Array, lambda_max: Array
) -> list[JudgedCrossing]:
    """Pair estimated crossings with true ones of their sign within 0.2 s: the nearest pairs first, each once.

    Args:
        estimates: estimated crossings in the order of time.
        truth: true crossings in the order of time.
        time: time of the samples of lambda_max [s], shape (n,).
        lambda_max: true slip at the peak [-], shape (n,).
    """
    pairs = sorted(
        (abs(event.time - estimate.time), i, j)
        for i, estimate in enumerate(estimates)
        for j, event in enumerate(truth)
        if event.sign == estimate.sign and abs(event.time - estimate.time) <= _CROSSING_REACH
    )
    true_times: dict[int, float] = {}
    claimed: set[int] = set()
    for _, i, j in pairs:
        if i not in true_times and j not in claimed:
            true_times[i] = truth[j].time
            claimed.add(j)
    rows = np.clip(np.searchsorted(time, [estimate.time for estimate in estimates]), 0, time.size - 1)
    return [
        JudgedCrossing(estimate, float(lambda_max[row]), true_times.get(i, float("nan")))
        for i, (estimate, row) in enumerate(zip(estimates, rows, strict=True))
    ]


def right_signs(
    time: Array, sign: Array, valid: NDArray[np.bool_], delay: Array, truth_time: Array, truth: Array
) -> tuple[int, int]:
    """Count the valid slope signs, and those of them that are the true one `delay` before their stamp.

    Args:
        time: stamps of the estimates [s], shape (n,).
        sign: +1 or -1 where valid, shape (n,).
        valid: whether the sign may be used, shape (n,).
        delay: age of the sign at the stamp [s], shape (n,); finite where valid.
        truth_time: stamps of the true signs [s], shape (m,), increasing.
        truth: true signs, shape (m,); each holds until the next.

    Returns:
        Valid signs, and right ones among them.
    """
    at = np.searchsorted(truth_time, (time - delay)[valid], side="right") - 1
    return int(np.count_nonzero(valid)), int(np.count_nonzero(truth[np.maximum(at, 0)] == sign[valid]))


def release_times(time: Array, released: NDArray[np.bool_]) -> Array:
    """Return the duration [s] of each release, to the first sample after it.

    Args:
        time: time of the samples [s], shape (n,), increasing.
        released: whether the brake was released from a sample to the next, shape (n,).
    """
    edges = np.flatnonzero(np.diff(released.astype(np.int8), prepend=0, append=0))
    ends = np.minimum(edges[1::2], time.size - 1)
    return time[ends] - time[edges[::2]]
