"""A speed sensor that contradicts wheels and accelerometer is named and not used."""

from collections.abc import Callable

import numpy as np
import pytest

from vehicle_models.vehicle_file import load_vehicle
from wheel_slip.estimate import Mode, SpeedSource, WheelEstimate
from wheel_slip.estimator import SlipEstimator
from wheel_slip.speed_sample import SpeedSample

STEP = 5_000_000
CAR = load_vehicle("compact_car")
DURATION = 19.0
Wrong = Callable[[float, float], float]


def drive(read: Wrong, *, braking: float = 2.0) -> list[tuple[float, WheelEstimate, str]]:
    """Drive with a sensor at 20 Hz that reads `read(time, speed)`: true speed, answer, what is said of the sensor."""
    rng = np.random.default_rng(5)
    estimator = SlipEstimator(CAR)
    found = []
    for k in range(1, round(DURATION / 0.005)):
        t = 0.005 * k
        speed = 25.0 - braking * min(max(t - 10.0, 0.0), 8.0 / braking)
        a = -braking if 10.0 < t < 10.0 + 8.0 / braking else 0.0
        omega = speed * (1.0 + 0.008 * a) / 0.3 + 0.07 * rng.normal(size=4)
        measured = [SpeedSample(k * STEP, read(t, speed + 0.1 * rng.normal()), 0.01)] if k % 10 == 0 else []
        row = estimator.update(k * STEP, omega.tolist(), a + 0.1 * rng.normal(), measured)
        found.append((speed, row[0], estimator.vehicle.sensor_text))
    return found


def covered(found: list[tuple[float, WheelEstimate, str]]) -> float:
    """Share of the valid answers whose speed is within three of its deviations."""
    valid = [(speed, each) for speed, each, _ in found if each.reason == 0]
    assert valid
    inside = [abs(each.vehicle_speed - speed) < 3.0 * each.vehicle_speed_variance**0.5 for speed, each in valid]
    return float(np.mean(inside))


@pytest.mark.parametrize("braking", [1.0, 2.0, 6.0])
def test_a_healthy_sensor_is_never_suspected(braking: float) -> None:
    found = drive(lambda t, speed: speed, braking=braking)
    assert {text for _, _, text in found} == {""}
    assert found[-1][1].source is SpeedSource.SENSOR
    assert covered(found) > 0.99


@pytest.mark.parametrize(
    "read",
    [
        lambda t, speed: speed + (2.5 if t > 5.0 else 0.0),
        lambda t, speed: speed - (0.5 * (t - 5.0) if t > 5.0 else 0.0),
        lambda t, speed: speed * (1.1 if t > 5.0 else 1.0),
        lambda t, speed: 0.0 if t > 5.0 else speed,
    ],
    ids=["jump", "drift", "scale", "zero"],
)
def test_a_sensor_that_goes_wrong_on_the_way_is_named_and_not_used(read: Wrong) -> None:
    found = drive(read)
    late = [row for k, row in enumerate(found) if k * 0.005 > 11.0]
    assert all("left out" in text and "radii" not in text for _, _, text in late)
    assert {each.mode for _, each, _ in late} <= {Mode.ROLLING, Mode.SLIDING}
    assert max(abs(each.vehicle_speed - speed) for speed, each, _ in late) < 0.6
    assert covered(late) > 0.95


def test_a_sensor_that_is_right_again_is_used_again() -> None:
    found = drive(lambda t, speed: speed + (3.0 if 5.0 < t < 8.0 else 0.0))
    assert any(text for _, _, text in found)
    assert found[-1][2] == ""
    assert found[-1][1].mode is Mode.SENSOR_ROLLING


def test_where_it_never_agreed_with_the_wheels_the_deviation_holds_both() -> None:
    found = drive(lambda t, speed: 1.06 * speed)
    speed, last, text = found[-1]
    assert "or the radii are wrong" in text
    assert abs(last.vehicle_speed - 1.06 * speed) < 2.0 * last.vehicle_speed_variance**0.5
    assert last.slip_variance**0.5 > 0.05


def test_a_value_that_stands_while_the_car_brakes_hard_is_left_out_and_named() -> None:
    held: list[float] = []

    def frozen(t: float, speed: float) -> float:
        if t > 9.9:
            held.append(speed)
            return held[0]
        return speed

    found = drive(frozen, braking=7.0)
    after = [row for k, row in enumerate(found) if 10.7 < k * 0.005 < 11.5]
    assert all("repeats" in text for _, _, text in after)
    assert all(each.mode in (Mode.ROLLING, Mode.SLIDING) for _, each, _ in after)
    assert max(abs(each.vehicle_speed - speed) for speed, each, _ in after) < 0.7
    assert covered(found) > 0.95
