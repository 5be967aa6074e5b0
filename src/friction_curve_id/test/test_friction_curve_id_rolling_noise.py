"""Noise of a wheel speed that is larger than stated: seen while the wheel rolls, and no peak is made of it."""

import numpy as np
import pytest

from corner_sim.corner import SingleCorner
from corner_sim.sensors import CHAPTER_NOISE
from friction_curve_id.exact_vehicle.estimator import ExactVehicleEstimator
from friction_curve_id.exact_vehicle.rolling_noise import RollingNoise
from friction_curve_id.interface import CurveEstimate, Sample
from vehicle_models import burckhardt
from vehicle_models.reason import Reason
from vehicle_models.surfaces import surface
from vehicle_models.vehicle_file import load_vehicle

CORNER = load_vehicle("chapter_corner").corner("front_left")
DT = 0.005
STATED = 0.005


def rolling(variance: float, count: int, seed: int, acceleration: float = -3.0) -> RollingNoise:
    noise, random = RollingNoise(STATED), np.random.default_rng(seed)
    for k in range(count):
        time = k * DT
        noise.update(time, 100.0 + acceleration * time + float(random.normal(0.0, variance**0.5)))
    return noise


@pytest.mark.parametrize("ratio", [4.0, 9.0, 100.0])
def test_noise_above_what_is_stated_is_seen(ratio: float) -> None:
    assert rolling(ratio * STATED, 400, 3).variance == pytest.approx(ratio * STATED, rel=0.5)


@pytest.mark.parametrize("ratio", [0.0, 0.5, 1.0])
def test_noise_as_stated_or_less_is_taken_as_stated(ratio: float) -> None:
    assert [rolling(ratio * STATED, 400, seed).variance for seed in range(20)] == [STATED] * 20


def test_little_is_no_evidence_and_a_step_in_time_is_no_noise() -> None:
    assert rolling(9.0 * STATED, 60, 3).variance == STATED
    noise = RollingNoise(STATED)
    for k in range(400):
        time = k * DT + (0.1 * (k // 10))
        noise.update(time, 100.0 - 30.0 * time)
    assert noise.variance == STATED


@pytest.mark.parametrize("name", ["dry", "cobblestone"])
def test_three_times_the_noise_makes_no_peak_where_there_is_none(name: str) -> None:
    theta, claims = surface(name), 0
    lambda_max, mu_max = (float(value) for value in burckhardt.peak(theta))
    held = 0.9 * mu_max * CORNER.radius * CORNER.vertical_load
    for seed in range(12):
        corner, random, estimator = (
            SingleCorner(CORNER, [30.0]),
            np.random.default_rng(seed),
            ExactVehicleEstimator(CORNER),
        )
        for k in range(300):
            torque, following = (held * min(max((n - 200) / 20, 0.0), 1.0) for n in (k, k + 1))
            sample = Sample(
                k * DT,
                float(corner.wheel_speed[0]) + 3.0 * float(random.normal(0.0, STATED**0.5)),
                float(corner.speed[0]) + float(random.normal(0.0, CHAPTER_NOISE.speed_variance**0.5)),
                max(torque + float(random.normal(0.0, CHAPTER_NOISE.torque_variance**0.5)), 0.0),
            )
            answer = estimator.update(sample)
            if isinstance(answer, CurveEstimate) and answer.reason in (Reason.OK, Reason.UNCERTAIN):
                claims += answer.lambda_max + 3.0 * answer.lambda_max_stddev < 0.6 * lambda_max
            corner.step(torque, following, theta, DT)
    assert claims == 0
