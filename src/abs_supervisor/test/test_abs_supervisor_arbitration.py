"""Arbitration between the two laws: which is in force, and the cause of each change."""

import pytest

from abs_supervisor.arbitration import Arbitration, Change, Law

STEP = 5_000_000
GOOD = {"braking": True, "slip": True, "curve": True}


@pytest.mark.parametrize(
    ("lost", "after", "cause"),
    [
        ({"slip": False}, 0.02, Change.SLIP_LOST),
        ({"curve": False}, 0.15, Change.NO_CURVE),
    ],
)
def test_the_slope_takes_over_when_something_is_lost_and_gives_back(
    lost: dict[str, bool], after: float, cause: Change
) -> None:
    choice = Arbitration()
    choice.update(0, **{**GOOD, **lost, "slip": True})
    stamps = range(STEP, round(after * 1e9) + STEP, STEP) or [STEP]
    for stamp in stamps:
        assert choice.law is Law.CURVE
        choice.update(stamp, **{**GOOD, **lost})
    assert (choice.law, choice.cause) == (Law.SLOPE_SIGN, cause)
    choice.update(stamps[-1] + STEP, **GOOD)
    assert (choice.law, choice.cause) == (Law.CURVE, Change.RETURNED)


def test_a_curve_that_is_lost_within_a_braking_gives_way_at_once() -> None:
    """It was kept for 0.15 s already: the driver's pressure for as long again locks a wheel."""
    choice = Arbitration()
    assert choice.update(STEP, braking=True, slip=True, curve=True) is Law.CURVE
    assert choice.update(2 * STEP, braking=True, slip=True, curve=False) is Law.SLOPE_SIGN
    assert choice.cause is Change.NO_CURVE
    assert choice.update(3 * STEP, braking=True, slip=True, curve=True) is Law.CURVE
    choice.update(4 * STEP, braking=False, slip=True, curve=False)
    assert choice.update(5 * STEP, braking=True, slip=True, curve=False) is Law.CURVE


@pytest.mark.parametrize(("share", "samples", "holds"), [(0.6, 110, True), (0.6, 130, False), (0.4, 1000, True)])
def test_a_torque_that_the_curve_does_not_explain_must_be_large_and_last(
    share: float, samples: int, holds: bool
) -> None:
    choice = Arbitration()
    for k in range(1, samples):
        choice.compare(k * STEP, share)
        choice.update(k * STEP, **GOOD)
    assert choice.law is (Law.CURVE if holds else Law.SLOPE_SIGN)
    assert choice.cause is (Change.NONE if holds else Change.NO_CURVE)


def test_a_curve_explains_its_wheel_again_when_little_is_left_for_as_long() -> None:
    choice = Arbitration()
    shares = [0.6] * 200 + [0.4] * 200 + [0.3] * 110
    for k, share in enumerate(shares, 1):
        choice.compare(k * STEP, share)
        choice.update(k * STEP, **GOOD)
    assert choice.law is Law.SLOPE_SIGN
    for k in range(1, 20):
        choice.compare((len(shares) + k) * STEP, 0.3)
    assert choice.update((len(shares) + 20) * STEP, **GOOD) is Law.CURVE


def test_without_braking_no_curve_is_missed() -> None:
    choice = Arbitration()
    for sample in range(400):
        choice.update(sample * STEP, braking=False, slip=True, curve=False)
    assert choice.law is Law.CURVE
