"""A short cut of `smart_tyre --gains`: one tyre in a minute that brakes once, on a plant of its own."""

import numpy as np
import pytest

from benchmarks.smart_tyre.gains import LIMITS, MINUTE, drive, judge
from benchmarks.smart_tyre.runs import RING
from corner_sim.car.recording import Recording
from friction_bringup.graph import plant_calibration
from smart_tyre_forces.calibration import Calibration


@pytest.fixture(scope="module")
def known() -> Calibration:
    """The shipped file: what the evaluation calibrates itself, without the time it takes."""
    return Calibration.load(plant_calibration())


@pytest.fixture(scope="module")
def recording() -> Recording:
    return drive(0.03, 5, MINUTE)


@pytest.mark.parametrize("stiffness", [0.8, 1.2])
def test_a_tyre_that_is_off_is_covered_from_the_first_force_on_and_learned_within_a_minute(
    known: Calibration, recording: Recording, stiffness: float
) -> None:
    judged = judge(recording, "rear_left", stiffness, known, 1)
    assert judged.time[0] < 7.0
    for name, limit in LIMITS.items():
        error, stddev = judged.error[name], judged.stddev[name]
        assert np.mean(np.abs(error) < 1.96 * stddev) > 0.9
        late = judged.time > 47.0
        assert 100.0 * np.sqrt(np.mean(error[late] ** 2)) / RING.static_load < limit
    # A deviation that covers everything would pass the first; what was learned must make it small.
    assert judged.stddev["Fz"][-1] < 0.5 * judged.stddev["Fz"][0]


@pytest.mark.parametrize("delay", [0, 2])
def test_a_changed_delay_is_reported_with_its_size_and_covered_and_none_where_it_has_not_changed(
    known: Calibration, recording: Recording, delay: int
) -> None:
    judged = judge(recording, "rear_left", 1.0, known, 1, delay)
    assert judged.delay == pytest.approx(1e-4 * delay, rel=0.25)
    assert np.mean(np.abs(judged.error["Fx"]) < 1.96 * judged.stddev["Fx"]) > 0.9
