"""Runs of one estimator through noisy manoeuvres, sample by sample, in processes of their own."""

import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from benchmarks.manoeuvres import Truth
from benchmarks.pool import in_processes
from benchmarks.protocol import CORNER
from benchmarks.stated import STATED, stated
from friction_curve_id.chapter.friction_samples import FrictionSource
from friction_curve_id.interface import CurveEstimator, Refusal, Sample
from friction_curve_id.methods import make_estimator
from vehicle_models.single_corner import CornerParameters

Array = NDArray[np.float64]

_CHUNK = 20
"""Runs in one task of a process."""
SERIES = (*STATED, "milliseconds")
"""Values kept of every answer; milliseconds are CPU time, not wall time."""


@dataclass(frozen=True)
class Traces:
    """Answers of an estimator after every sample of every run; NaN where it gave none."""

    values: Array
    """Shape (runs, samples, len(SERIES))."""
    exceptions: int

    def __getitem__(self, name: str) -> Array:
        """One of SERIES, shape (runs, samples)."""
        return np.asarray(self.values[:, :, SERIES.index(name)])


@dataclass(frozen=True)
class Batch:
    """Runs to make: an estimator by name, and the manoeuvres of `truth` with the seeds of its noise."""

    key: str
    """Names the batch among others."""
    method: str
    truth: Truth
    runs: Sequence[tuple[int, Sequence[int]]]
    """Number of the manoeuvre in `truth`, and the seed of its noise."""
    source: FrictionSource = FrictionSource.DEAD_RECKONED
    wheel: CornerParameters = CORNER
    """Wheel and load that the estimator is given."""
    speed_bias: float = 0.0
    """Added to the measured speed [m/s]."""
    torque_gain: float = 1.0
    """Factor on the measured torque."""
    outliers: tuple[int, int, str] | None = None
    """First sample, sign and signals (of w, v, T) of five samples off by ten times their noise."""


def make(batches: Iterable[Batch], title: str, processes: int = 2) -> dict[str, Traces]:
    """Make all runs, with a progress bar; the traces by the key of their batch."""
    jobs = list(batches)
    tasks = [(job, first) for job in jobs for first in range(0, len(job.runs), _CHUNK)]
    parts = iter(in_processes(_make_chunk, tasks, title, processes))
    return {job.key: _join(islice(parts, -(-len(job.runs) // _CHUNK))) for job in jobs}


def _join(parts: Iterable[Traces]) -> Traces:
    chunks = list(parts)
    return Traces(np.concatenate([chunk.values for chunk in chunks]), sum(chunk.exceptions for chunk in chunks))


def _make_chunk(task: tuple[Batch, int]) -> Traces:
    batch, first = task
    runs = batch.runs[first : first + _CHUNK]
    values = np.full((len(runs), len(batch.truth.time), len(SERIES)), np.nan)
    exceptions = 0
    for row, (number, seed) in zip(values, runs, strict=True):
        estimator = make_estimator(batch.method, batch.wheel, source=batch.source)
        try:
            follow(estimator, measured(batch, number, seed), row)
        except Exception:  # any kind counts as a divergence of the method under test
            exceptions += 1
    return Traces(values, exceptions)


def measured(batch: Batch, number: int, seed: Sequence[int]) -> Iterator[Sample]:
    """Noisy samples of one run, as the estimator gets them."""
    omega, speed, torque = batch.truth.noisy(number, np.random.default_rng(list(seed)))
    if batch.outliers is not None:
        first, sign, signals = batch.outliers
        for name, signal, stddev in (("w", omega, 0.005**0.5), ("v", speed, 0.5), ("T", torque, 10.0**0.5)):
            if name in signals:
                signal[first : first + 5] += sign * 10.0 * stddev
    speed = speed + batch.speed_bias
    torque = torque * batch.torque_gain
    for k, stamp in enumerate(batch.truth.time):
        yield Sample(float(stamp), float(omega[k]), float(speed[k]), float(torque[k]))


def follow(estimator: CurveEstimator, samples: Iterable[Sample], row: Array) -> None:
    """Feed an estimator; fill `row`, shape (samples, len(SERIES))."""
    for k, sample in enumerate(samples):
        begin = time.thread_time_ns()
        answer = estimator.update(sample)
        row[k, -1] = (time.thread_time_ns() - begin) * 1e-6
        if not isinstance(answer, Refusal):
            row[k, :-1] = stated(answer)
