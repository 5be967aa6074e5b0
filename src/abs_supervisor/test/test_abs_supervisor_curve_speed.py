"""Slips of the law by the speed that the curve is of: as far as slip is uncertain and the curve's is not."""

from math import nan

import pytest

from abs_supervisor.curve_selector import CurveReport, Estimate
from abs_supervisor.curve_speed import CurveSpeed
from abs_supervisor.measurements import Measurements

STEP, BEGIN = 5_000_000, 10_000_000_000


def measured(slip: float, stddev: float) -> Measurements:
    return Measurements(60.0, 100.0, 200.0, slip=slip, slip_stddev=stddev, car_speed=20.0)


def report(stamp: int, slip: float, stddev: float = 0.005) -> CurveReport:
    return CurveReport(stamp, Estimate.VALID, None, 0.01, 0.3, 100, 0, True, slip, stddev)


def joined(slip: float, stddev: float, of_curve: float, curve_stddev: float = 0.005, count: int = 100) -> Measurements:
    """Return the measurements after `count` samples, whose curves come 50 ms late."""
    speed, found = CurveSpeed(), measured(slip, stddev)
    for k in range(1, count):
        found = speed.by_curve(k * STEP, measured(slip, stddev))
        if k > 10:
            speed.take(report((k - 10) * STEP, of_curve, curve_stddev))
    return found


def test_an_uncertain_slip_becomes_that_of_the_curve() -> None:
    found = joined(0.085, 0.08, 0.02)
    assert found.slip == pytest.approx(0.02, abs=0.004)
    assert found.car_speed * (1.0 - found.slip) == pytest.approx(20.0 * (1.0 - 0.085))


def test_a_slip_that_is_known_stays() -> None:
    assert joined(0.085, 0.001, 0.02).slip == pytest.approx(0.085, abs=0.001)


def test_both_count_by_their_variances() -> None:
    assert joined(0.1, 0.03, 0.07, 0.03 * (1.0 - (1.0 / 3.0) ** 2) ** 0.5).slip == pytest.approx(0.085, abs=0.002)


@pytest.mark.parametrize(("slip", "of_curve", "stddev"), [(0.085, 0.02, nan), (0.085, nan, 0.005), (0.9, 0.3, 0.005)])
def test_a_curve_without_a_slip_or_a_wheel_that_dives_changes_nothing(
    slip: float, of_curve: float, stddev: float
) -> None:
    assert joined(slip, 0.08, of_curve, stddev).slip == pytest.approx(slip)


def test_what_is_forgotten_changes_nothing_and_an_unknown_slip_stays_unknown() -> None:
    speed = CurveSpeed()
    speed.by_curve(BEGIN, measured(0.085, 0.08))
    speed.take(report(BEGIN, 0.02))
    assert speed.by_curve(BEGIN + STEP, measured(0.085, 0.08)).slip < 0.03
    speed.forget()
    assert speed.by_curve(BEGIN + 2 * STEP, measured(0.085, 0.08)).slip == pytest.approx(0.085)
    unknown = speed.by_curve(BEGIN + 3 * STEP, measured(nan, nan))
    assert unknown.slip != unknown.slip
