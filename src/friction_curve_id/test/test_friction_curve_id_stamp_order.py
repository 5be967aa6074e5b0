"""Order of the stamps of a fit: without a gap, and a single wrong one costs one sample."""

import pytest

from friction_curve_id.interface import Refusal
from friction_curve_id.stamp_order import Admission, StampOrder
from vehicle_models.reason import Reason

_MAX_GAP = 0.025


def answers(*times: float) -> list[Admission | Reason]:
    order = StampOrder(_MAX_GAP)
    found = (order.admit(time) for time in times)
    return [answer.reason if isinstance(answer, Refusal) else answer for answer in found]


def test_samples_in_order_follow_each_other() -> None:
    assert answers(1.0, 1.005, 1.029) == [Admission.FIRST, Admission.NEXT, Admission.NEXT]


@pytest.mark.parametrize("begins", [1.1, 0.5])
def test_after_a_gap_or_a_jump_back_the_second_sample_is_admitted(begins: float) -> None:
    found = answers(1.0, begins, begins + 0.005, begins + 0.010)
    assert found == [Admission.FIRST, Reason.GAP, Admission.AFTER_GAP, Admission.NEXT]


@pytest.mark.parametrize("wrong", [7.0, 0.5, 0.995])
def test_a_single_wrong_stamp_costs_one_sample(wrong: float) -> None:
    assert answers(1.0, wrong, 1.005) == [Admission.FIRST, Reason.GAP, Admission.NEXT]


def test_a_repeated_stamp_is_refused() -> None:
    assert answers(1.0, 1.00005, 1.005) == [Admission.FIRST, Reason.BAD_INPUT, Admission.NEXT]


def test_a_message_that_comes_again_after_a_late_one_does_not_begin_a_new_fit() -> None:
    assert answers(1.0, 0.995, 1.0, 1.005) == [Admission.FIRST, Reason.GAP, Reason.BAD_INPUT, Admission.NEXT]
