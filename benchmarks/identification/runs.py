"""Runs of one estimator through noisy manoeuvres, sample by sample, and the statistics of their peaks."""

import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from benchmarks.engine import results_of
from benchmarks.protocol import CORNER, Truth
from benchmarks.runner import Row
from friction_curve_id.chapter.friction_samples import FrictionSource
from friction_curve_id.interface import CurveEstimate, CurveEstimator, Refusal, Sample
from friction_curve_id.methods import exact_wheel_estimator

Array = NDArray[np.float64]

STATED = (
    "lambda_max",
    "lambda_max_stddev",
    "mu_max",
    "mu_max_stddev",
    "probability_beyond_peak",
    "mu_max_valid",
    "valid",
    "restarted",
)
"""Values of an estimate; flags are 0 or 1."""
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


def make(batches: Iterable[Batch], title: str) -> dict[str, Traces]:
    """Make all runs, with a progress bar; the traces by the key of their batch."""
    jobs = list(batches)
    tasks = [(job, first) for job in jobs for first in range(0, len(job.runs), _CHUNK)]
    parts = iter(results_of(_make_chunk, tasks, title))
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
        estimator = exact_wheel_estimator(batch.method, CORNER, source=batch.source)
        try:
            follow(estimator, measured(batch, number, seed), row)
        except Exception:  # any kind counts as a divergence of the method under test
            exceptions += 1
    return Traces(values, exceptions)


def measured(batch: Batch, number: int, seed: Sequence[int]) -> Iterator[Sample]:
    """Noisy samples of one run, as the estimator gets them."""
    omega, speed, torque = batch.truth.noisy(number, np.random.default_rng(list(seed)))
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


FAILED_ERROR = 50.0
"""An error beyond this [%] is a failure."""
_LAST = 10
"""Updates before N whose time counts as that of an update at N."""


def peak_row(traces: Traces, lambda_max: Array, mu_max: Array, samples: int) -> Row:
    """Columns of one row of the table after `samples` samples; truths of shape (runs,).

    bias and rmse are over the runs that gave a lambda_max in (0, 1); in median and 95th percentile a failure counts as
    100 %.
    """
    estimate, stddev = traces["lambda_max"][:, samples - 1], traces["lambda_max_stddev"][:, samples - 1]
    mu, mu_stddev = traces["mu_max"][:, samples - 1], traces["mu_max_stddev"][:, samples - 1]
    given = (estimate > 0.0) & (estimate < 1.0)
    error = np.where(given, 100.0 * (estimate / lambda_max - 1.0), np.nan)
    failed = ~(np.abs(error) <= FAILED_ERROR)
    size = np.where(failed, 100.0, np.abs(error))
    mu_error = 100.0 * (mu / mu_max - 1.0)[given]
    times = traces["milliseconds"][:, max(samples - _LAST, 0) : samples]
    return {
        "samples": samples,
        "runs": len(error),
        "bias_pct": _mean(error[given]),
        "rmse_pct": _mean(error[given] ** 2) ** 0.5,
        "median_pct": float(np.median(size)),
        "p95_pct": float(np.percentile(size, 95)),
        "failures": int(failed.sum()),
        "coverage_95": coverage(estimate[given], stddev[given], lambda_max[given]),
        "update_ms_median": float(np.nanmedian(times)),
        "update_ms_p99": float(np.nanpercentile(times, 99)),
        "mu_max_bias_pct": _mean(mu_error),
        "mu_max_rmse_pct": _mean(mu_error**2) ** 0.5,
        "mu_max_coverage_95": coverage(mu[given], mu_stddev[given], mu_max[given]),
        "valid_pct": 100.0 * float(np.mean(traces["valid"][:, samples - 1] == 1.0)),
        "divergences": traces.exceptions,
    }


def coverage(estimate: Array, stddev: Array, truth: Array) -> float:
    """Percentage of runs whose 95 % interval holds the truth; NaN where there are none or the method states none."""
    if not np.isfinite(stddev).any():
        return float("nan")
    return 100.0 * float(np.mean(np.abs(estimate - truth) <= 1.96 * stddev))


def kept_from(traces: Traces, lambda_max: Array, limit: float) -> float:
    """Median over the runs of the sample from which on the error stays within `limit` [%]; inf where it never does."""
    error = 100.0 * np.abs(traces["lambda_max"] / lambda_max[:, np.newaxis] - 1.0)
    outside = ~(error <= limit)
    last_outside = np.where(outside.any(axis=1), error.shape[1] - np.argmax(outside[:, ::-1], axis=1), 0)
    first = np.where(last_outside >= error.shape[1], np.inf, last_outside + 1.0)
    return float(np.median(first))


def _mean(values: Array) -> float:
    return float(np.mean(values)) if len(values) else float("nan")


def stated(answer: CurveEstimate) -> list[float]:
    """Return the values STATED of an estimate."""
    return [float(getattr(answer, name)) for name in STATED]
