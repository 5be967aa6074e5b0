"""Noise of a wheel speed that is larger than stated makes no peak."""

import numpy as np
import pytest

from corner_sim.corner import SingleCorner
from corner_sim.sensors import CHAPTER_NOISE
from friction_curve_id.exact_vehicle.estimator import ExactVehicleEstimator
from friction_curve_id.interface import CurveEstimate, Sample
from vehicle_models import burckhardt
from vehicle_models.reason import Reason
from vehicle_models.surfaces import surface
from vehicle_models.vehicle_file import load_vehicle

CORNER = load_vehicle("chapter_corner").corner("front_left")
DT = 0.005
STATED = 0.005


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
