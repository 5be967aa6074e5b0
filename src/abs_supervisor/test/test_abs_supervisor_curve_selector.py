"""Selection of the friction curve: valid and vague fits, another road, the order of arrival."""

from itertools import permutations
from math import isnan, nan

import pytest
from friction_msgs.msg import FrictionCurve, Validity

from abs_supervisor.curve_selector import CurveReport, CurveSelector, Estimate
from abs_supervisor.road_curve import RoadCurve, curve_through
from abs_supervisor.ros.wheel_inputs import curve_report
from friction_runtime.messages import from_nanoseconds
from vehicle_models import burckhardt
from vehicle_models.reason import Reason
from vehicle_models.surfaces import surface

STEP = 5_000_000
OLDER = 50_000_000
"""[ns] a curve counts for samples that are this much later."""


def road(name: str) -> RoadCurve:
    theta = surface(name)
    theta_1, theta_2, theta_3 = (float(value) for value in theta)
    return RoadCurve(theta_1, theta_2, theta_3, float(burckhardt.peak(theta)[0]))


DRY = road("dry")


def report(
    stamp: int,
    estimate: Estimate,
    curve: RoadCurve | None = DRY,
    stddev: float = 0.001,
    restarts: int = 0,
    samples: int = 50,
) -> CurveReport:
    return CurveReport(stamp + STEP, estimate, curve, stddev, 0.0, samples, restarts)


class Bench(CurveSelector):
    """A selector whose reports count at once."""

    changed = False

    def take(self, each: CurveReport, explained: bool = False) -> None:
        self.put(each)
        self.changed = self.advance(each.stamp + OLDER, explained)


def test_the_law_takes_a_curve_of_another_family_by_its_peak() -> None:
    """A fit by the magic formula has lambda_max and mu_max, and no theta."""
    message = FrictionCurve(validity=Validity(reason=Reason.OK), samples=100, theta_1=nan, theta_2=nan, theta_3=nan)
    message.header.stamp = from_nanoseconds(STEP)
    message.lambda_max, message.mu_max = 0.14, 0.9
    found = curve_report(message)
    assert found.estimate is Estimate.VALID
    assert found.curve is not None
    assert found.curve.lambda_max == pytest.approx(0.14)
    assert found.curve.mu_max == pytest.approx(0.9)
    # Before the peak it has no mu_max: its curve goes through the present friction.
    message.slip, message.mu, message.mu_max = 0.05, found.curve.friction(0.05), nan
    message.validity.reason = int(Reason.PEAK_NOT_PASSED)
    vague = curve_report(message)
    assert vague.estimate is Estimate.VAGUE
    assert vague.curve is not None
    assert vague.curve.mu_max == pytest.approx(0.9)
    message.slip = 0.0
    assert curve_report(message).estimate is Estimate.NONE


def test_a_curve_counts_from_50_ms_after_its_stamp_whichever_comes_first() -> None:
    reports = [report(k * STEP, Estimate.VALID, road(name)) for k, name in enumerate(("dry", "wet", "snow"))]
    for order in permutations(reports):
        known = CurveSelector()
        for each in order:
            known.put(each)
        found = []
        for k in range(15):
            known.advance(k * STEP, explained=False)
            found.append(known.lambda_max)
        assert all(isnan(each) for each in found[:11])
        assert found[11:] == [road(name).lambda_max for name in ("dry", "wet", "snow", "snow")]


def test_a_curve_that_is_older_than_one_that_counts_is_left_out() -> None:
    known = Bench()
    known.take(report(10 * STEP, Estimate.VALID))
    known.take(report(2 * STEP, Estimate.VALID, road("snow")))
    assert known.curve is DRY
    assert known.lambda_max_stddev == pytest.approx(0.001)


def test_when_a_braking_is_over_its_curve_is_forgotten() -> None:
    known = Bench()
    known.take(report(0, Estimate.VALID))
    known.forget()
    assert known.curve is None
    assert isnan(known.lambda_max)


def test_a_curve_counts_from_twenty_samples_and_its_peak_as_seen_once_it_is_valid_or_passed() -> None:
    known = Bench()
    known.take(report(STEP, Estimate.VALID, samples=19))
    assert known.curve is None
    known.take(report(2 * STEP, Estimate.VAGUE))
    assert known.curve is DRY
    assert not known.seen
    known.take(report(3 * STEP, Estimate.VALID))
    assert known.seen
    passed = Bench()
    passed.take(CurveReport(STEP, Estimate.VAGUE, DRY, 0.001, 0.6, 50, 0))
    assert passed.seen


def test_a_fit_that_began_anew_displaces_a_curve_that_explains_the_wheel_only_when_it_is_sure() -> None:
    other = road("snow")
    for explained in (True, False):
        known = Bench()
        for sample in range(1, 4):
            known.take(report(sample * STEP, Estimate.VALID))
        known.take(report(4 * STEP, Estimate.VAGUE, other, stddev=0.05, restarts=1), explained)
        assert known.curve is (DRY if explained else other)
        assert known.changed is not explained
    known.take(report(5 * STEP, Estimate.VAGUE, other, restarts=2), explained=True)
    assert known.curve is other


def test_a_curve_that_was_vague_itself_is_not_kept_by_fits_that_began_anew() -> None:
    """From dry to snow a fit went astray to a peak of 0.78 and ended; the law then held a slip of 0.46 to the end."""
    astray, other = road("cobblestone"), road("snow")
    known = Bench()
    known.take(report(STEP, Estimate.VAGUE, astray, stddev=0.3 * astray.lambda_max))
    for sample in range(2, 40):
        vague = report(sample * STEP, Estimate.VAGUE, other, stddev=2.0 * other.lambda_max, restarts=1)
        known.take(vague, explained=True)
        assert known.curve is other


@pytest.mark.parametrize(
    ("peak", "level", "stddev", "displaces"),
    [
        (0.4, 1.0, 0.006, False),  # a fit that is less sure than the one before
        (0.4, 1.0, 0.0001, True),  # surer
        (2.0, 1.0, 0.03, False),
        (0.4, 0.6, 0.006, True),  # the road gives less
    ],
)
def test_on_one_road_a_fit_that_began_anew_displaces_the_curve_only_by_a_surer_peak_or_another_friction(
    peak: float, level: float, stddev: float, displaces: bool
) -> None:
    known = Bench()
    for sample in range(3):
        known.take(report(sample * STEP, Estimate.VALID))
    shape = curve_through(peak * DRY.lambda_max, DRY.mu_max)
    scale = level * DRY.mu_max / shape.friction(DRY.lambda_max)
    other = RoadCurve(scale * shape.theta_1, shape.theta_2, scale * shape.theta_3, shape.lambda_max)
    for sample in range(3, 10):
        known.take(report(sample * STEP, Estimate.VALID, other, stddev, restarts=1), explained=True)
        assert known.changed == (displaces and sample == 3)
    assert known.curve is (other if displaces else DRY)


def test_a_curve_stays_while_newer_fits_are_not_sure() -> None:
    known = Bench()
    known.take(report(STEP, Estimate.VALID))
    for sample in range(2, 100):
        known.take(report(sample * STEP, Estimate.VAGUE, road("snow"), stddev=0.05, restarts=1), explained=True)
    assert known.curve is DRY


def test_a_vague_estimate_does_not_displace_a_peak_that_was_seen() -> None:
    known, vague = Bench(), road("snow")
    for sample in range(3):
        known.take(report(sample * STEP, Estimate.VALID))
    known.take(report(4 * STEP, Estimate.VAGUE, vague, stddev=0.3 * vague.lambda_max))
    assert known.curve is DRY
    known.take(report(5 * STEP, Estimate.VAGUE, vague, stddev=0.2 * vague.lambda_max))
    assert known.curve is vague


@pytest.mark.parametrize("valid", [False, True])
def test_a_fit_on_its_way_that_was_sure_for_a_moment_gives_way_to_what_it_says_later(valid: bool) -> None:
    """From dry to snow three estimates were sure of three times the peak; the law held it until the wheel locked."""
    known, snow, astray = Bench(), road("snow"), road("dry")
    sure = Estimate.VALID if valid else Estimate.VAGUE
    for sample in range(3):
        known.take(CurveReport((sample + 1) * STEP, sure, astray, 0.18 * astray.lambda_max, 0.9, 50, 0))
    for sample in range(3, 60):
        known.take(CurveReport((sample + 1) * STEP, Estimate.VAGUE, snow, 0.35 * snow.lambda_max, 0.9, 50, 0))
        assert known.curve is (astray if valid else snow)


def test_the_old_road_serves_until_the_new_one_has_twenty_samples() -> None:
    known, snow = Bench(), road("snow")
    for sample in range(3):
        known.take(report(sample * STEP, Estimate.VALID))
    known.take(report(3 * STEP, Estimate.VAGUE, snow, restarts=1, samples=8))
    assert (known.curve, known.changed, known.seen) == (DRY, False, True)
    known.take(report(4 * STEP, Estimate.VAGUE, snow, restarts=1, samples=20))
    assert (known.curve, known.changed, known.seen) == (snow, True, False)


def test_a_curve_outlives_quiet_but_not_an_estimator_that_has_none() -> None:
    known = Bench()
    known.take(report(0, Estimate.VALID))
    known.take(report(400 * STEP, Estimate.QUIET, None))
    assert known.curve is DRY
    known.take(report(430 * STEP, Estimate.NONE, None))
    assert known.curve is DRY
    known.take(report(431 * STEP, Estimate.NONE, None))
    assert known.curve is None
