"""Rolling radii under load: sign and size of what braking and a curve do to each wheel."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from vehicle_models.constants import GRAVITY
from vehicle_models.rolling_radius import RollingRadius
from vehicle_models.vehicle import Deviation, SharedBy, Vehicle
from vehicle_models.vehicle_file import load_vehicle


def car(loss: float = 0.02, stddev: float = 0.005) -> Vehicle:
    nominal = load_vehicle("compact_car")
    of_tyre = {"radius_loss": Deviation(stddev, SharedBy.ALL)}
    return replace(
        nominal, wheels=tuple(replace(each, radius_loss=loss, deviations=of_tyre) for each in nominal.wheels)
    )


def test_a_wheel_that_carries_more_rolls_on_less() -> None:
    vehicle, rolling = car(), RollingRadius(car())
    moved = 2.0 * vehicle.height_ratio  # of the load of an axle, which carries half of the weight
    factors, stddevs = rolling.update(0.0, -GRAVITY, 0.0)
    assert_allclose(factors, 1.0 - 0.02 * moved * np.array([1.0, 1.0, -1.0, -1.0]))
    assert_allclose(stddevs, 0.005 * moved)
    left_turn, _ = RollingRadius(vehicle).update(0.0, 0.0, 0.5 * GRAVITY)
    assert all(left_turn[[0, 2]] > 1.0) and all(left_turn[[1, 3]] < 1.0)
    assert_allclose(left_turn.sum(), 4.0)
    assert left_turn[0] - 1.0 == pytest.approx((left_turn[2] - 1.0) * 0.55 / 0.45)


def test_without_a_force_or_a_loss_the_radius_is_that_at_rest() -> None:
    for vehicle, force in ((car(), 0.0), (car(0.0, 0.0), -8.0), (load_vehicle("chapter_corner"), -8.0)):
        factors, stddevs = RollingRadius(vehicle).update(0.0, force, 0.0)
        assert_allclose(factors, 1.0)
        assert_allclose(stddevs, 0.0)


def test_a_wheel_that_lifts_loses_no_more_than_its_load() -> None:
    factors, _ = RollingRadius(car()).update(0.0, -1e6, 0.0)
    assert 0.98 <= factors.min() < factors.max() <= 1.02
