"""Kalman filter of a wheel speed: closed forms, statistics, irregular times."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from corner_sim.car.car_parameters import CarParameters, SensorParameters
from corner_sim.car.driving import Cycling, SlipCycle
from corner_sim.car.recording import record
from wheel_slip.wheel_speed_filter import WheelFilterParameters, WheelSpeedFilter

MS = 1_000_000


def wheel_filter() -> WheelSpeedFilter:
    return WheelSpeedFilter(WheelFilterParameters(speed_stddev=0.005**0.5, jerk_density=3e3), max_gap=0.1, teeth=48)


@given(st.lists(st.floats(0.001, 0.08), min_size=60, max_size=60), st.floats(-100.0, 100.0))
def test_constant_acceleration_is_followed_exactly_at_irregular_times(gaps: list[float], rate: float) -> None:
    wheel = wheel_filter()
    stamp = MS
    for gap in gaps:
        stamp += round(gap * 1e9)
        wheel.update(stamp, 80.0 + rate * stamp * 1e-9)
    # What is left of the unknown start has decayed to the share of its prior.
    assert wheel.speed == pytest.approx(80.0 + rate * stamp * 1e-9, abs=0.02)
    assert wheel.acceleration == pytest.approx(rate, abs=0.5)


@pytest.mark.parametrize("rate", [25, 100, 200, 1000])
def test_wheel_filter_is_as_uncertain_as_it_says(rate: int) -> None:
    rng = np.random.default_rng(3)
    dt = 1.0 / rate
    errors = []
    for _ in range(60):
        wheel, omega, alpha, stamp = wheel_filter(), 80.0, 0.0, MS
        for _ in range(60):
            wheel.update(stamp, omega + np.sqrt(0.005) * rng.normal())
            error = (wheel.speed - omega, wheel.acceleration - alpha)
            jerk = rng.multivariate_normal(
                [0, 0], 3e3 * np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]]), method="cholesky"
            )
            omega, alpha = omega + alpha * dt + jerk[0], alpha + jerk[1]
            stamp += round(dt * 1e9)
        errors.append((error[0] ** 2 / wheel.speed_variance, error[1] ** 2 / wheel.acceleration_variance))
    mean = np.mean(errors, axis=0)
    # Mean of 60 squared unit normals: five standard deviations.
    assert np.all(np.abs(mean - 1.0) < 5.0 * np.sqrt(2.0 / 60.0))


@pytest.mark.parametrize("rate", [250, 500, 1000])
def test_wheels_that_are_cycled_through_the_peak_are_within_their_intervals_at_high_rates(rate: int) -> None:
    """One innovation in 1 to 4 ms shows no lag: intervals of 95 % covered 50 to 64 % from 500 Hz on."""
    sensors = SensorParameters(sample_rate=rate, wheel_speed_variance=0.005)
    car = CarParameters(relaxation_length=(0.3,) * 4, sensors=sensors)
    run = record(car, SlipCycle(car, Cycling()), 5, duration=2.0)
    truth = (1.0 - run.slip) * run.speed[:, np.newaxis] / np.array(car.radius)
    inside = []
    for number in range(4):
        wheel = wheel_filter()
        for time, measured, omega in zip(run.time, run.wheel_speed[:, number], truth[:, number], strict=True):
            wheel.update(MS + round(time * 1e9), float(measured))
            if time > 0.7:
                inside.append(abs(wheel.speed - omega) < 1.96 * np.sqrt(wheel.speed_variance + wheel.lag_variance))
    assert np.mean(inside) > 0.88


def test_what_a_fast_sample_showed_of_a_lag_ends_with_the_next_slow_one() -> None:
    wheel = wheel_filter()
    for k in range(40):
        wheel.update(MS + k * MS, 80.0 - 1.0 * max(k - 36, 0))
    assert wheel.lag_variance > 0.0
    wheel.update(MS + 45 * MS, 70.0)
    assert wheel.lag_variance == 0.0


def test_a_burst_of_samples_after_a_surprise_does_not_unsettle_the_filter() -> None:
    wheels = [wheel_filter(), wheel_filter()]
    for number, wheel in enumerate(wheels):
        for k in range(40):
            wheel.update(MS + 5 * k * MS, 80.0)
        wheel.update(MS + 200 * MS, 80.6)
        for k in range(200 * number):
            wheel.update(MS + 200 * MS + 1 + k, 80.6)
        for k in range(1, 8):
            wheel.update(MS + (200 + 5 * k) * MS, 80.0)
    assert wheels[1].speed_variance < 1.5 * wheels[0].speed_variance


@pytest.mark.parametrize("rate", [50, 100, 200, 500, 1000])
def test_wheel_filter_is_settled_after_the_same_time_and_knows_the_acceleration_then(rate: int) -> None:
    rng = np.random.default_rng(6)
    wheel, found = wheel_filter(), []
    for _ in range(40):
        wheel.reset()
        stamp = MS
        while not wheel.settled:
            stamp += round(1e9 / rate)
            wheel.update(stamp, 80.0 - 30.0 * stamp * 1e-9 + 0.07 * rng.normal())
        assert 18 * MS <= stamp - MS - round(1e9 / rate) <= 20 * MS
        found.append(wheel.acceleration + 30.0)
    assert np.std(found) < 6.0


def test_burst_of_near_equal_stamps_averages_and_a_gap_starts_again() -> None:
    wheel = wheel_filter()
    for k in range(5):
        wheel.update(MS + k, 50.0 + (-1.0) ** k * 0.07)
    assert wheel.speed == pytest.approx(50.0, abs=0.03)
    assert not wheel.settled
    wheel.update(MS + 20 * MS, 50.0)
    assert wheel.settled
    wheel.update(MS + 220 * MS, 40.0)
    assert not wheel.settled
    assert wheel.restarted_by_gap
    assert wheel.speed == 40.0


def edge_speeds(teeth: int, rate: int, missing: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """A wheel that swings by 25 rad/s about 60 rad/s at 3 Hz: what it does, and the mean speeds between its edges.

    The last `missing` teeth of its ring are not there, and nobody makes up for them.
    """
    fine = np.arange(0.0, 4.0, 1e-5)
    omega = 60.0 + 25.0 * np.sin(2.0 * np.pi * 3.0 * fine)
    angle = np.cumsum(omega) * 1e-5
    pitch = 2.0 * np.pi / teeth
    stamps = np.arange(1, 4 * rate) / rate
    counts = np.floor(np.interp(stamps, fine, angle) / pitch)
    counts -= np.maximum(counts % teeth - (teeth - missing - 1), 0.0)
    edges = np.interp(counts * pitch, angle, fine)
    seen = counts - missing * (counts // teeth)
    return np.interp(stamps, fine, omega)[1:], np.diff(seen) * pitch / np.diff(edges)


@pytest.mark.parametrize(
    ("teeth", "rate", "missing"), [(48, 200, 0), (48, 100, 0), (24, 100, 0), (60, 100, 2), (60, 50, 2)]
)
def test_speeds_between_edges_are_brought_to_their_stamp_and_cover_what_is_left(
    teeth: int, rate: int, missing: int
) -> None:
    true, read = edge_speeds(teeth, rate, missing)
    told, plain = (
        WheelSpeedFilter(WheelFilterParameters(edges=edges, missing_teeth=edges * missing), max_gap=0.1, teeth=teeth)
        for edges in (True, False)
    )
    errors, late, deviations = [], [], []
    for k, (speed, measured) in enumerate(zip(true, read, strict=True)):
        for wheel in (told, plain):
            wheel.update(round(k * 1e9 / rate), measured)
        errors.append(told.speed + told.age * told.acceleration - speed)
        late.append(plain.speed - speed)
        deviations.append((told.speed_variance + told.age_variance) ** 0.5)
    z = np.array(errors[rate:]) / np.array(deviations[rate:])
    assert np.mean(np.abs(z) < 1.96) > 0.9
    assert np.std(errors[rate:]) < 0.6 * np.std(late[rate:])
    assert plain.age == plain.age_variance == 0.0
