from math import isnan

import pytest
from friction_msgs.msg import FrictionCurve

from friction_curve_id.interface import CurveEstimate, RestartCause
from friction_curve_id.ros.curve_messages import CurveMessages
from vehicle_models.reason import Reason


def message(lambda_max: float, mu_max: float, reason: Reason = Reason.OK, text: str = "") -> FrictionCurve:
    answer = CurveEstimate(40, 0.1, lambda_max, mu_max, 0.01, 0.01, reason=reason, text=text)
    messages = CurveMessages("front_left", "front_left", "car", 0.15, 2.5)
    return messages.outputs(10**9, answer, 0.1, RestartCause.NONE)[0][1]


@pytest.mark.parametrize("lambda_max", [1.0, 1.004, 40.0, 0.0, -0.1])
def test_a_peak_outside_0_to_1_is_no_peak_whatever_the_method_says_of_it(lambda_max: float) -> None:
    found = message(lambda_max, 0.9)
    assert isnan(found.lambda_max)
    assert isnan(found.mu_max)
    assert (found.validity.valid, found.validity.reason) == (False, Reason.NO_PEAK)
    assert f"{lambda_max:.3g}" in found.validity.text
    guessed = message(lambda_max, 0.9, Reason.PEAK_NOT_PASSED, "not yet")
    assert isnan(guessed.lambda_max)
    assert (guessed.validity.reason, guessed.validity.text) == (Reason.PEAK_NOT_PASSED, "front_left: not yet")


def test_friction_that_no_tyre_has_is_not_valid_and_named() -> None:
    assert message(0.1, 2.4).validity.valid
    found = message(0.1, 3.94)
    assert (found.validity.valid, found.validity.reason) == (False, Reason.UNCERTAIN)
    assert "3.94" in found.validity.text


def test_mu_max_is_a_number_only_where_it_is_valid() -> None:
    assert isnan(message(0.1, 0.3, Reason.PEAK_NOT_PASSED).mu_max)
    assert isnan(message(0.1, 0.3, Reason.PEAK_NOT_PASSED).mu_max_stddev)
    assert message(0.1, 0.3).mu_max == 0.3
    alone = CurveEstimate(40, 0.1, 0.1, 0.9, 0.03, 0.02, reason=Reason.UNCERTAIN, mu_max_known=True)
    messages = CurveMessages("front_left", "front_left", "car", 0.15, 2.5)
    ((_, curve), _) = messages.outputs(10**9, alone, 0.1, RestartCause.NONE)
    assert (curve.validity.valid, curve.mu_max, curve.mu_max_stddev) == (False, 0.9, 0.02)


def test_the_largest_valid_friction_is_a_parameter() -> None:
    answer = CurveEstimate(40, 0.1, 0.1, 1.5, 0.01, 0.01, reason=Reason.OK)
    for highest, valid in ((1.4, False), (1.6, True)):
        messages = CurveMessages("front_left", "front_left", "car", 0.15, highest)
        ((_, curve), _) = messages.outputs(10**9, answer, 0.1, RestartCause.NONE)
        assert curve.validity.valid == valid
