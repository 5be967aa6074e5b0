"""Statistics of lambda_max over runs: errors in percent of the truth, failures counted and never dropped silently."""

import numpy as np
from numpy.typing import NDArray

from benchmarks.identification.runs import Traces
from benchmarks.rows import Row

Array = NDArray[np.float64]

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


def alarm_row(traces: Traces, slip: Array, lambda_max: Array, interval: float) -> Row:
    """Delay of P(beyond the peak) > 0.9 behind the true crossing, at the resolution of the samples.

    Args:
        traces: of the runs.
        slip: true, shape (runs, samples).
        lambda_max: true, shape (runs,).
        interval: sample time [s].
    """
    crossing = np.argmax(slip > lambda_max[:, np.newaxis], axis=1)
    alarmed = traces["probability_beyond_peak"] > 0.9
    missed = ~alarmed.any(axis=1)
    delay = np.where(missed, np.inf, 1e3 * interval * (np.argmax(alarmed, axis=1) - crossing))
    early = delay < -25.0
    return {
        "runs": len(delay),
        "delay_ms_median": float(np.median(delay)),
        "delay_ms_p95": float(np.quantile(delay, 0.95, method="higher")),
        "delay_ms_first": float(delay.min()),
        "misses": int(missed.sum()),
        "early_alarms": int(early.sum()),
        "early_per_1000": 1e3 * float(early.mean()),
    }


def _mean(values: Array) -> float:
    return float(np.mean(values)) if len(values) else float("nan")
