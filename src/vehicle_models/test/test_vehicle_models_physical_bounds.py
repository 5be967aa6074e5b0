"""The least speed of a car from its wheels."""

import pytest

from vehicle_models.physical_bounds import SlowestCar

STEP = 5_000_000


def test_it_follows_the_wheel_up_and_falls_no_faster_than_a_car_can_brake() -> None:
    car = SlowestCar(12.0)
    assert car.update(STEP, 30.0) == 30.0
    for k in range(2, 202):
        car.update(k * STEP, 0.0)
    assert car.speed == pytest.approx(30.0 - 12.0 * 1.0)
    assert car.update(202 * STEP, 27.0) == 27.0


@pytest.mark.parametrize("seconds", [0, 10])
def test_a_wheel_that_rolls_backwards_is_a_car_at_rest(seconds: int) -> None:
    car = SlowestCar()
    car.update(STEP, 1.0 if seconds else -1.0)
    assert car.update(2 * STEP + seconds * 10**9, -1.0) == 0.0


def test_after_a_reset_only_the_next_sample_counts() -> None:
    car = SlowestCar()
    car.update(STEP, 30.0)
    car.reset()
    assert car.update(2 * STEP, 2.0) == 2.0
