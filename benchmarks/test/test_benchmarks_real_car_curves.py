"""ABS stops in curves: what is counted as what."""

import numpy as np

from benchmarks.real_car.curves import CASES, CurveStop, curve_rows
from benchmarks.runner import Row

TIME = np.arange(0.0, 1.5, 0.005)


def stop(since: float, error: float = 0.0, deviation: float = 0.05) -> CurveStop:
    """Answers that are valid `since` the first passing [s], with a relative error of both and its stated deviation."""
    told = np.repeat((since <= TIME)[:, np.newaxis], 4, axis=1)
    errors, deviations = np.full(told.shape, error), np.full(told.shape, error / deviation)
    return CurveStop(TIME, told, told, errors, errors, deviations, deviations)


def judged(case: str, *stops: CurveStop) -> dict[str, Row]:
    return {row["quantity"]: row for row in curve_rows(CASES[case], stops)}


def test_numbers_that_are_right_in_time_pass() -> None:
    rows = judged("shallow, dry 0.6 g", stop(0.3, 0.02), stop(0.5, -0.02))
    assert all(row["passed"] for row in rows.values())
    assert rows["lambda_max valid within 0.6 s [%]"]["value"] == 100.0
    assert rows["median |error| of mu_max after 0.6 s [%]"]["value"] == 2.0


def test_numbers_that_are_late_miss_their_interval_or_are_far_off_fail() -> None:
    assert not judged("shallow, dry 0.6 g", stop(0.7))["mu_max valid within 0.6 s [%]"]["passed"]
    far = judged("shallow, dry 0.6 g", stop(0.3, 0.12, 0.1))
    assert not far["median |error| of lambda_max after 0.6 s [%]"]["passed"]
    assert far["coverage of lambda_max, all valid messages [%]"]["passed"]
    missed = judged("dry 0.8 g", stop(0.3, 0.12, 0.05))
    assert missed["coverage of mu_max, all valid messages [%]"]["value"] == 0.0
    assert missed["lambda_max valid within 0.6 s [%]"]["passed"] is None, "nothing is asked at the lateral limit"


def test_a_number_where_none_can_be_known_fails_and_silence_passes() -> None:
    assert judged("held 0.6 g", stop(9.0))["mu_max valid [% of stops]"]["passed"]
    assert not judged("held 0.6 g", stop(9.0), stop(1.2))["mu_max valid [% of stops]"]["passed"]
