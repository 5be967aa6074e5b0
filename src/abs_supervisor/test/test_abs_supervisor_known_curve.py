"""Which lambda_max of <wheel>/friction_curve counts for a sample, and for how long."""

from itertools import permutations
from math import isnan

import pytest
from friction_msgs.msg import FrictionCurve
from std_msgs.msg import Header

from abs_supervisor.known_curve import KnownCurve
from friction_runtime.stamps import from_nanoseconds

MS = 1_000_000
START = 10_000 * MS


def curve(
    at: int, lambda_max: float, stddev: float, reason: int = FrictionCurve.OK, samples: int = 40
) -> FrictionCurve:
    header = Header(stamp=from_nanoseconds(START + at * MS))
    return FrictionCurve(header=header, lambda_max=lambda_max, lambda_max_stddev=stddev, reason=reason, samples=samples)


def known(at: int, *curves: FrictionCurve) -> float:
    found = KnownCurve(foresees=False)
    for each in curves:
        found.take(each)
    return found.at(START + at * MS)[0]


def test_a_curve_counts_from_50_ms_to_half_a_second_after_its_stamp() -> None:
    found = [known(at, curve(0, 0.17, 0.01)) for at in (49, 50, 500, 501)]
    assert [isnan(each) for each in found] == [True, False, False, True]


@pytest.mark.parametrize(("reason", "samples"), [(FrictionCurve.NO_PEAK, 40), (FrictionCurve.OK, 19)])
def test_what_tells_no_peak_changes_nothing(reason: int, samples: int) -> None:
    assert known(200, curve(0, 0.17, 0.01), curve(100, 0.4, 0.01, reason, samples)) == 0.17


def test_a_peak_that_is_seen_to_be_ahead_ends_what_was_taken_for_one() -> None:
    ahead = FrictionCurve.PEAK_NOT_PASSED
    early = curve(0, 0.12, 0.01)
    assert isnan(known(200, early, curve(100, 0.41, 0.03, ahead)))
    assert known(200, early, curve(100, 0.14, 0.03, ahead)) == 0.12
    assert known(140, early, curve(100, 0.41, 0.03, ahead)) == 0.12
    assert known(300, early, curve(100, 0.41, 0.03, ahead), curve(200, 0.3, 0.01)) == 0.3
    assert isnan(known(200, curve(100, 0.41, 0.03, ahead)))


def test_the_order_of_arrival_does_not_matter() -> None:
    ahead = FrictionCurve.PEAK_NOT_PASSED
    curves = [curve(0, 0.12, 0.01), curve(20, 0.41, 0.03, ahead), curve(40, 0.35, 0.02, FrictionCurve.UNCERTAIN)]
    for order in permutations(curves):
        assert known(90, *order) == 0.35
        assert isnan(known(80, *order))


def test_a_peak_that_the_fit_foresees_counts_with_three_times_its_deviation() -> None:
    ahead, found = FrictionCurve.PEAK_NOT_PASSED, KnownCurve(foresees=True)
    found.take(curve(0, 0.17, 0.02, ahead))
    assert found.at(START + 60 * MS) == pytest.approx((0.17, 0.06))
    found.take(curve(20, 0.16, 0.01, ahead))
    assert found.at(START + 80 * MS) == pytest.approx((0.16, 0.03))
    found.take(curve(40, 0.20, 0.05, ahead))
    assert isnan(found.at(START + 100 * MS)[0]), "a guess of the prior ends it"
