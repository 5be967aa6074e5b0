"""The bound of the protocol, its derivatives against finite differences, and the manoeuvres it is made for."""

from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose

from benchmarks import protocol as manoeuvres
from benchmarks.identification import cramer_rao
from benchmarks.protocol import CORNER, DT, SPEED
from corner_sim.corner import SingleCorner
from vehicle_models import burckhardt
from vehicle_models.surfaces import SURFACES, TABLE_8_1

ROADS = np.array([SURFACES[name] for name in TABLE_8_1])


@pytest.fixture(scope="module")
def braking_b() -> manoeuvres.Truth:
    return manoeuvres.braking("B", ROADS)


@pytest.fixture(scope="module")
def found(braking_b: manoeuvres.Truth) -> cramer_rao.Sensitivities:
    return cramer_rao.sensitivities(ROADS, braking_b.torque, DT, SPEED)


def test_manoeuvre_b_holds_the_torques_of_the_protocol(braking_b: manoeuvres.Truth) -> None:
    assert_allclose(braking_b.torque[:, -1], [857.0, 598.0, 805.0, 153.0], atol=0.6)
    passed = (braking_b.slip < burckhardt.peak(ROADS)[0][:, np.newaxis]).sum(axis=1)
    assert set(passed) <= {74, 75}


@pytest.mark.parametrize("manoeuvre", ["A", "B", "C"])
def test_every_manoeuvre_ends_at_one_and_a_half_times_the_peak(manoeuvre: str) -> None:
    truth = manoeuvres.braking(manoeuvre, ROADS[:1])
    assert_allclose(truth.slip[:, -1], 1.5 * burckhardt.peak(ROADS[:1])[0], rtol=1e-5)
    assert truth.slip[0, 0] == 0.0


def test_bound_is_that_of_the_protocol(found: cramer_rao.Sensitivities) -> None:
    bound = cramer_rao.relative_bound(ROADS, cramer_rao.information(found, 100))
    assert_allclose(100.0 * bound, [0.889, 1.56, 0.428, 14.4], rtol=5e-3)
    early = cramer_rao.relative_bound(ROADS[:1], cramer_rao.information(found, 40)[:1])
    assert_allclose(100.0 * early, 434.0, rtol=5e-3)


def test_more_samples_lower_the_bound(found: cramer_rao.Sensitivities) -> None:
    bounds = [cramer_rao.relative_bound(ROADS, cramer_rao.information(found, n)) for n in (40, 55, 70, 85, 100)]
    assert all(np.all(later < earlier) for earlier, later in pairwise(bounds))


def test_sensitivities_are_the_finite_differences_of_the_motion(found: cramer_rao.Sensitivities) -> None:
    torque = manoeuvres.braking("B", ROADS[:1]).torque

    def motion(theta: np.ndarray, brake: np.ndarray) -> np.ndarray:
        plant = SingleCorner(CORNER, [30.0], max_step=2e-4)
        states = []
        for k in range(manoeuvres.SAMPLES):
            states.append((plant.wheel_speed[0], plant.speed[0]))
            if k < manoeuvres.SAMPLES - 1:
                plant.step(brake[k : k + 1], brake[k + 1 : k + 2], theta, DT)
        return np.array(states)

    for index in range(3):
        step = np.zeros(3)
        step[index] = 1e-4 * ROADS[0, index]
        difference = (motion(ROADS[0] + step, torque[0]) - motion(ROADS[0] - step, torque[0])) / (2.0 * step[index])
        for column, ours in enumerate((found.wheel_speed, found.speed)):
            assert_allclose(ours[0, :, index], difference[:, column], atol=2e-3 * np.abs(difference[:, column]).max())
    step = np.zeros(manoeuvres.SAMPLES)
    step[30] = 1.0
    difference = (motion(ROADS[0], torque[0] + step) - motion(ROADS[0], torque[0] - step)) / 2.0
    assert_allclose(found.wheel_speed[0, :, 5 + 30], difference[:, 0], atol=2e-3 * np.abs(difference[:, 0]).max())
