"""Stops summed up as rows."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from benchmarks.real_car.stops import JUDGED, TOO_SOON, StopResult
from benchmarks.rows import Row, at_least, at_most, not_judged

Array = NDArray[np.float64]
COVERAGE = 90.0
"""Least coverage of a 95 % interval [%]."""
VALID = 90.0
"""Least share of the stops that are valid JUDGED after the first passing [%]."""
EARLY = 1.0
"""Most early alarms [%]."""
MEDIAN = {"lambda_max": 4.0, "mu_max": 1.5}
RMSE = {"lambda_max": 12.0}
"""Largest errors over random cars [%]."""


def stop_rows(case: str, road: str, results: Sequence[StopResult], judge_errors: bool) -> list[Row]:
    """Rows of a case on a road; with `judge_errors` the errors themselves have limits too."""
    rows: list[Row] = []

    def add(quantity: str, judged: Row, **more: float) -> None:
        rows.append({"case": case, "road": road, "stops": len(results), "quantity": quantity} | judged | more)

    messages = sum(result.messages for result in results)
    for name, errors, inside, all_inside in (
        (
            "lambda_max",
            [result.lambda_error for result in results],
            [result.lambda_inside for result in results],
            sum(result.messages_lambda_inside for result in results),
        ),
        (
            "mu_max",
            [result.mu_error for result in results],
            [result.mu_inside for result in results],
            sum(result.messages_mu_inside for result in results),
        ),
    ):
        error = 100.0 * np.concatenate(errors)
        statistics = {
            "bias_pct": _mean(error),
            "rmse_pct": _mean(error**2) ** 0.5,
            "median_pct": float(np.median(np.abs(error))) if error.size else np.nan,
            "estimates": float(error.size),
        }
        add(f"coverage of {name} [%]", at_least(100.0 * _mean(np.concatenate(inside)), COVERAGE), **statistics)
        of_messages = 100.0 * all_inside / messages if messages else np.nan
        add(f"coverage of {name}, all valid messages [%]", at_least(of_messages, COVERAGE))
        if judge_errors:
            add(f"median |error| of {name} [%]", at_most(statistics["median_pct"], MEDIAN[name]))
            if name in RMSE:
                add(f"RMSE of {name} [%]", at_most(statistics["rmse_pct"], RMSE[name]))
    first = np.array([result.first_valid for result in results])
    times = {"median_ms": 1e3 * float(np.median(first)), "p90_ms": 1e3 * _quantile(first, 0.9)}
    add(f"valid within {JUDGED} s [%]", at_least(100.0 * _mean(first <= JUDGED), VALID), **times)
    add(f"valid before {TOO_SOON} s [%]", at_most(100.0 * _mean(first < TOO_SOON), 0.0))
    wheels = 4 * len(results)
    delay = np.concatenate([result.alarm_delay for result in results])
    delays = {"median_ms": 1e3 * float(np.median(delay)), "p90_ms": 1e3 * _quantile(delay, 0.9)} if delay.size else {}
    early = 100.0 * sum(result.early for result in results) / wheels
    add("early alarms [% of wheels]", at_most(early, EARLY), **delays)
    passed = sum(result.passed for result in results)
    missed = 100.0 * sum(result.missed for result in results) / max(passed, 1)
    add("missed alarms [% of passings]", not_judged(missed))
    add("P > 0.9 before the peak [% of samples]", not_judged(100.0 * _mean([r.false_beyond for r in results])))
    add("restarts of a wheel", not_judged(_mean([result.restarts / 4.0 for result in results])))
    return rows


def _mean(values: ArrayLike) -> float:
    array = np.asarray(values, dtype=np.float64)
    return float(np.mean(array)) if array.size else np.nan


def _quantile(values: Array, share: float) -> float:
    return float(np.quantile(values, share, method="higher"))
