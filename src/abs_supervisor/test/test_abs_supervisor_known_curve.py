"""Selection and lifetime of lambda_max from <wheel>/friction_curve."""

from itertools import permutations
from math import isnan

import pytest
from friction_msgs.msg import FrictionCurve, Validity
from std_msgs.msg import Header

from abs_supervisor.ros.known_curve import KnownCurve
from friction_runtime.messages import from_nanoseconds
from vehicle_models.reason import Reason

MS = 1_000_000
START = 10_000 * MS
AHEAD = Reason.PEAK_NOT_PASSED


def curve(at: int, lambda_max: float, stddev: float, reason: int = Reason.OK, samples: int = 40) -> FrictionCurve:
    header = Header(stamp=from_nanoseconds(START + at * MS))
    return FrictionCurve(
        header=header,
        lambda_max=lambda_max,
        lambda_max_stddev=stddev,
        validity=Validity(reason=reason),
        samples=samples,
    )


def run(*curves: FrictionCurve, until: int, speed: float = 30.0) -> tuple[float, float]:
    found = KnownCurve(foresees=False)
    for each in curves:
        found.take(each)
    for at in range(0, until, 5):
        found.at(START + at * MS, speed)
    return found.at(START + until * MS, speed)


def known(until: int, *curves: FrictionCurve, speed: float = 30.0) -> float:
    return run(*curves, until=until, speed=speed)[0]


def test_a_curve_counts_from_50_ms_after_its_stamp() -> None:
    assert [isnan(known(at, curve(0, 0.17, 0.01))) for at in (49, 50)] == [True, False]


@pytest.mark.parametrize("speed", [30.0, 6.0])
def test_a_curve_counts_for_15_m(speed: float) -> None:
    end = 50 + round(15.0 / speed * 1000)
    found = [known(at, curve(0, 0.17, 0.01), speed=speed) for at in (end - 5, end + 5)]
    assert [isnan(each) for each in found] == [False, True]


@pytest.mark.parametrize(("reason", "samples"), [(Reason.NO_PEAK, 40), (Reason.OK, 19)])
def test_what_tells_no_peak_changes_nothing(reason: int, samples: int) -> None:
    assert known(200, curve(0, 0.17, 0.01), curve(100, 0.4, 0.01, reason, samples)) == 0.17


def test_a_peak_that_is_seen_to_be_ahead_ends_an_uncertain_one_that_it_contradicts() -> None:
    early = [curve(at, 0.12, 0.01, Reason.UNCERTAIN) for at in range(0, 55, 5)]
    assert isnan(known(200, *early, curve(100, 0.41, 0.03, AHEAD)))
    assert known(200, *early, curve(100, 0.14, 0.03, AHEAD)) == 0.12
    assert known(140, *early, curve(100, 0.41, 0.03, AHEAD)) == 0.12
    assert known(300, *early, curve(100, 0.41, 0.03, AHEAD), curve(200, 0.3, 0.01)) == 0.3
    assert isnan(known(200, curve(100, 0.41, 0.03, AHEAD)))


@pytest.mark.parametrize("reason", [Reason.OK, Reason.UNKNOWN_CAR])
def test_a_peak_that_was_seen_counts_at_once_and_is_not_ended_by_a_guess(reason: int) -> None:
    assert known(60, curve(0, 0.12, 0.01, reason)) == 0.12
    assert known(200, curve(0, 0.12, 0.01, reason), curve(100, 0.41, 0.03, AHEAD)) == 0.12


@pytest.mark.parametrize(("stddev", "confirms"), [(0.01, True), (0.1, False)])
@pytest.mark.parametrize("reason", [AHEAD, Reason.UNCERTAIN])
def test_a_later_fit_that_is_sure_confirms_a_peak_and_a_guess_does_not(
    reason: int, stddev: float, confirms: bool
) -> None:
    later = [curve(at, 0.16, stddev, reason) for at in range(300, 400, 5)]
    assert (known(700, curve(0, 0.17, 0.005), *later) == 0.17) == confirms


def test_an_uncertain_curve_counts_once_fits_have_told_a_peak_for_50_ms() -> None:
    uncertain = [curve(at, 0.04 + 1e-5 * at, 0.012, Reason.UNCERTAIN) for at in range(0, 100, 5)]
    assert isnan(known(97, *uncertain))
    assert known(100, *uncertain) == pytest.approx(0.0405)
    interrupted = [*uncertain[:8], curve(40, 0.4, 0.1, AHEAD), *uncertain[9:16]]
    assert isnan(known(200, *interrupted)), "the fit began anew"


def test_a_curve_that_is_only_less_certain_does_not_replace_one() -> None:
    sure = [curve(at, 0.172, 0.002) for at in range(0, 60, 5)]
    for later, expected in (
        (curve(100, 0.169, 0.125, Reason.UNCERTAIN), (0.172, 0.002)),
        (curve(100, 0.18, 0.02), (0.172, 0.002)),
        (curve(100, 0.4, 0.03), (0.4, 0.03)),
        (curve(100, 0.05, 0.001), (0.05, 0.001)),
    ):
        assert run(*sure, later, until=200) == expected


def test_a_vague_guess_replaces_a_peak_that_was_seen_no_sooner_than_it_contradicts_it() -> None:
    vague = curve(100, 0.326, 0.128, Reason.UNCERTAIN)
    beyond = curve(100, 0.326, 0.04, Reason.UNCERTAIN)
    seen = [curve(at, 0.187, 0.002, Reason.UNKNOWN_CAR) for at in range(0, 105, 5)]
    guessed = [curve(at, 0.187, 0.002, Reason.UNCERTAIN) for at in range(0, 105, 5)]
    assert run(*seen, vague, until=200) == (0.187, 0.002)
    assert run(*seen, beyond, until=200) == (0.326, 0.04)
    assert run(*guessed, vague, until=200) == (0.326, 0.128)


def test_the_order_of_arrival_does_not_matter() -> None:
    curves = [curve(0, 0.12, 0.01), curve(20, 0.35, 0.02), curve(40, 0.2, 0.01)]
    for order in permutations(curves):
        assert [known(at, *order) for at in (65, 85, 90)] == [0.12, 0.35, 0.2]


def test_a_curve_that_comes_after_a_newer_one_counts_is_left_out() -> None:
    found = KnownCurve(foresees=False)
    found.take(curve(40, 0.2, 0.01))
    assert found.at(START + 95 * MS, 30.0)[0] == 0.2
    found.take(curve(20, 0.35, 0.01))
    assert found.at(START + 100 * MS, 30.0)[0] == 0.2
    found.take(curve(60, 0.3, 0.01))
    assert found.at(START + 110 * MS, 30.0)[0] == 0.3


def test_a_peak_that_the_fit_foresees_counts_with_three_times_its_deviation_until_one_is_seen() -> None:
    found = KnownCurve(foresees=True)
    found.take(curve(0, 0.17, 0.02, AHEAD))
    assert found.at(START + 60 * MS, 30.0) == pytest.approx((0.17, 0.06))
    found.take(curve(20, 0.16, 0.01, AHEAD))
    assert found.at(START + 80 * MS, 30.0) == pytest.approx((0.16, 0.03))
    found.take(curve(40, 0.20, 0.05, AHEAD))
    assert isnan(found.at(START + 100 * MS, 30.0)[0]), "a guess of the prior ends it"
    found.take(curve(60, 0.16, 0.01, AHEAD))
    found.take(curve(80, 0.15, 0.1))
    assert found.at(START + 140 * MS, 30.0) == (0.15, 0.1), "what is seen replaces it"
    found.take(curve(100, 0.2, 0.01, AHEAD))
    assert found.at(START + 160 * MS, 30.0) == (0.15, 0.1), "and is not ended by a guess"
