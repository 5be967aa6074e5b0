"""Limits of validity: every reason by itself, and their order."""

from math import nan

import pytest

from friction_curve_id.curve.validity import ValidityLimits
from friction_curve_id.interface import CurveEstimate, RestartCause
from vehicle_models.reason import Reason


@pytest.mark.parametrize(
    ("slips", "lambda_max", "stddev", "reason"),
    [
        ((0.0, 0.2), 0.1, 0.01, Reason.OK),
        ((0.0, 0.2), nan, nan, Reason.NO_PEAK),
        ((0.0, 0.09), 0.1, nan, Reason.PEAK_NOT_PASSED),
        ((0.11, 0.2), 0.1, 0.0, Reason.UNCERTAIN),
        ((0.0, 0.2), 0.1, 0.011, Reason.UNCERTAIN),
        ((0.0, 0.2), 0.1, nan, Reason.UNCERTAIN),
    ],
)
def test_a_peak_is_valid_where_samples_passed_it_and_it_is_known_well(
    slips: tuple[float, float], lambda_max: float, stddev: float, reason: Reason
) -> None:
    found, text = ValidityLimits().judge(slips, lambda_max, stddev)
    assert found is reason and (text == "") == (reason is Reason.OK)


def test_an_estimate_is_valid_where_no_reason_speaks_against_it_and_restarted_where_it_has_a_cause() -> None:
    nothing = CurveEstimate(samples=0, slip=nan)
    assert not nothing.valid and not nothing.restarted
    good = nothing._replace(reason=Reason.OK, restart_cause=RestartCause.GAP)
    assert good.valid and good.restarted
