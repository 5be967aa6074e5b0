"""Detection of rolling wheels during a slide."""

from math import nan, sin

import numpy as np
import pytest

from wheel_slip.carried_wheels import CarriedWheels
from wheel_slip.tuning import CarriedTuning

NOISE = 0.021**2
DT = 0.005


@pytest.fixture
def wheels() -> CarriedWheels:
    return CarriedWheels(CarriedTuning(), 2, NOISE)


def test_wheel_that_rolls_is_carried_and_one_that_swings_by_two_percent_is_not(wheels: CarriedWheels) -> None:
    rng = np.random.default_rng(2)
    counts = []
    for k in range(600):
        speed = 10.0 - 1.8 * k * DT
        noise = np.sqrt(NOISE) * rng.normal(size=2)
        swing = 0.02 * speed * (1.0 + sin(60.0 * k * DT))
        gaps = wheels.update(DT, [speed - 0.005 + noise[0], speed - swing + noise[1]], speed)
        counts.append(len(gaps))
        assert all(abs(gap) < 0.04 for gap in gaps)
    assert np.mean(counts[100:]) > 0.9
    assert max(counts) == 1


def test_mean_gap_is_as_noisy_as_stated(wheels: CarriedWheels) -> None:
    rng = np.random.default_rng(3)
    found = [wheels.update(DT, [20.0 + np.sqrt(NOISE) * rng.normal(), nan], 20.0) for _ in range(20_000)]
    gaps = np.array([gap for gaps in found[100:] for gap in gaps])
    # Samples count as quiet by their own scatter, which hardly favours small means.
    assert gaps.var() == pytest.approx(wheels.gap_variance(DT), rel=0.1)


def test_no_wheel_is_carried_when_a_slide_has_just_begun_or_its_speed_was_missing(wheels: CarriedWheels) -> None:
    assert not any(wheels.update(DT, [20.0, 20.0], 20.0) for _ in range(25))
    assert len([wheels.update(DT, [20.0, 20.0], 20.0) for _ in range(20)][-1]) == 2
    assert len(wheels.update(DT, [20.0, nan], 20.0)) == 1
    assert len(wheels.update(DT, [20.0, 20.0], 20.0)) == 1
    wheels.reset()
    assert not wheels.update(DT, [20.0, 20.0], 20.0)
