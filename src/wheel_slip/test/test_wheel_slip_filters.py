"""The Kalman filters of wheel speed and vehicle speed: closed forms, statistics, irregular and late samples."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from corner_sim.car.car_parameters import CarParameters, SensorParameters
from corner_sim.car.driving import Cycling, SlipCycle
from corner_sim.car.recording import record
from wheel_slip.speed_filter import AccelerometerParameters, SpeedFilter
from wheel_slip.speed_queue import SpeedQueue
from wheel_slip.tuning import SpeedFilterTuning
from wheel_slip.wheel_speed_filter import WheelFilterParameters, WheelSpeedFilter

MS = 1_000_000
QUIET = AccelerometerParameters(stddev=1e-3, bias_stddev=0.4), SpeedFilterTuning(offset_walk=1e-4, gain_stddev=0.0)


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


def run_speed_filter(late: int, offset: float) -> SpeedFilter:
    """Brake from 30 m/s, accelerometer off by `offset`, the speed sensor's samples `late` samples old."""
    f = SpeedFilter(*QUIET)
    times = np.arange(1, 401) * 0.005
    speeds = 30.0 - 8.0 * times + 0.5 * np.sin(3.0 * times)
    accelerations = -8.0 + 1.5 * np.cos(3.0 * times) + offset
    stamps = [round(t * 1e9) for t in times]
    for k in range(400):
        f.predict(stamps[k], float(accelerations[k]))
        if k >= late:
            assert f.correct(float(speeds[k - late]), 0.01, stamps[k - late])
    assert f.speed == pytest.approx(speeds[-1], abs=0.01)
    return f


@pytest.mark.parametrize("late", [0, 1, 40])
def test_offset_is_learned_and_latency_leaves_no_bias(late: int) -> None:
    f = run_speed_filter(late, 0.35)
    assert f.offset == pytest.approx(0.35, abs=0.01)


def test_scale_of_the_accelerometer_is_learned_in_braking_with_its_deviation() -> None:
    f = SpeedFilter(AccelerometerParameters(stddev=1e-3, bias_stddev=0.01), SpeedFilterTuning(gain_stddev=0.02))
    rng = np.random.default_rng(1)
    for k in range(1, 601):
        t = k * 0.005
        f.predict(k * 5 * MS, -7.0 * 1.03 if t > 0.5 else 0.0)
        f.correct(30.0 - 7.0 * max(t - 0.5, 0.0) + 0.02 * rng.normal(), 0.02**2)
    assert f.gain == pytest.approx(0.03 / 1.03, abs=0.003)


def test_noise_of_an_accelerometer_says_nothing_of_its_scale() -> None:
    f = SpeedFilter()
    rng = np.random.default_rng(2)
    for k in range(1, 6001):
        f.predict(k * 5 * MS, 0.3 + 0.1 * rng.normal())
        f.correct(20.0 + 0.02 * rng.normal(), 0.02**2)
    assert f.gain == 0.0
    assert f.offset == pytest.approx(0.3, abs=0.02)


@pytest.mark.parametrize("compliance", [0.003, 0.04])
def test_slip_of_rolling_wheels_is_told_from_the_speed_at_the_onset_of_braking(compliance: float) -> None:
    f = SpeedFilter()
    rng = np.random.default_rng(3)
    speed = 20.0
    for k in range(1, 801):
        deceleration = 2.0 * min(max(k * 0.005 - 2.0, 0.0) / 0.2, 1.0)
        speed -= 0.005 * deceleration
        f.predict(k * 5 * MS, -deceleration + 0.1 * rng.normal())
        rim_speed = speed * (1.0 - compliance * deceleration) + 0.02 * rng.normal()
        f.correct(rim_speed, 0.02**2, k * 5 * MS, deceleration)
    assert abs(f.speed - speed) < 2.5 * f.speed_variance**0.5
    assert f.speed == pytest.approx(speed, abs=0.15)


def test_a_hill_on_which_a_car_coasts_is_an_offset_and_no_slip_of_its_wheels() -> None:
    f, rng, speed = SpeedFilter(), np.random.default_rng(5), 23.0
    f.predict(5 * MS, -0.4)
    f.start(speed, 1e-4)
    for k in range(2, 1200):
        hill = 0.6 * min(max(k * 0.005 - 2.0, 0.0), 1.0)
        speed -= 0.005 * (0.4 + hill)
        f.predict(k * 5 * MS, -0.4 + 0.1 * rng.normal())
        f.correct(speed + 0.01 * rng.normal(), 0.01**2, k * 5 * MS, 0.1)
        if hill:
            f.doubt_offset(0.05**2)
    assert f.compliance == pytest.approx(SpeedFilterTuning().compliance, abs=1e-6)
    assert f.offset == pytest.approx(0.6, abs=0.1)
    assert abs(f.speed - speed) < 2.0 * f.speed_variance**0.5


def test_a_gain_that_is_not_known_makes_the_speed_as_uncertain_as_what_was_integrated_and_no_steady_road() -> None:
    f = SpeedFilter(
        AccelerometerParameters(bias_stddev=1e-3),
        SpeedFilterTuning(blind_offset_walk=1e-4, gain_stddev=0.02),
        None,
        0.0,
        0.0,
    )
    f.predict(5 * MS, 0.0)
    f.start(30.0, 1e-6)
    for k in range(2, 402):
        f.predict(k * 5 * MS, -8.0, observed=False)
    assert f.speed_variance**0.5 == pytest.approx(0.02 * 16.0, rel=0.05)
    assert f.steady_road_variance**0.5 < 0.03


def test_sample_from_before_the_history_is_refused_and_changes_nothing() -> None:
    f = SpeedFilter(*QUIET)
    f.predict(5 * MS, 0.0)
    f.correct(10.0, 0.01)
    before = (f.speed, f.offset, f.speed_variance)
    assert not f.correct(20.0, 0.01, 4 * MS)
    assert not f.correct(20.0, 0.01, 6 * MS)
    assert (f.speed, f.offset, f.speed_variance) == before


def test_without_measurements_the_uncertainty_grows_faster_than_time() -> None:
    f = SpeedFilter()
    f.predict(5 * MS, 0.0)
    f.correct(30.0, 0.01)
    deviations = []
    for k in range(2, 401):
        f.predict(k * 5 * MS, 0.0)
        deviations.append(np.sqrt(f.speed_variance - 0.01))
    assert np.all(np.diff(deviations) > 0.0)
    assert deviations[-1] > 1.9 * deviations[len(deviations) // 2 - 1]


def blind_filter(seconds: float) -> SpeedFilter:
    """Well known at 10 m/s, then blind for that long."""
    f = SpeedFilter()
    for k in range(1, 2001):
        f.predict(k * 5 * MS, 0.0)
        f.correct(10.0, 1e-3)
    for k in range(2001, 2001 + round(seconds / 0.005)):
        f.predict(k * 5 * MS, 0.0, observed=False)
    return f


def test_blind_filter_keeps_apart_what_the_road_may_have_done() -> None:
    f = blind_filter(4.0)
    unseen = 0.06**2 * 4.0**3 / 3.0
    assert f.speed_variance - f.steady_road_variance == pytest.approx(unseen, rel=0.01)
    f.believe(10.1, 1e-3)
    assert f.speed_variance - f.steady_road_variance == pytest.approx(unseen, rel=0.01)
    gain = (f.speed - 10.0) / 0.1
    assert 0.0 < gain < 0.8
    assert f.steady_road_variance == pytest.approx(gain * 1e-3)


def onset(time: float) -> float:
    """Acceleration of a car whose brakes come within 0.2 s [m/s^2]."""
    return -8.0 * min(max((time - 0.5) / 0.2, 0.0), 1.0)


def late_filter(late: float, delay: float, stddev: float, *, seen: bool) -> tuple[SpeedFilter, float]:
    """Brake with readings that are `late` [s]; return the filter, which sees the speed until then or always, and it."""
    f = SpeedFilter(
        AccelerometerParameters(stddev=1e-3, bias_stddev=1e-3), SpeedFilterTuning(gain_stddev=0.0), 0.0, delay, stddev
    )
    speed = 30.0
    f.predict(MS, onset(-late))
    f.start(speed, 1e-6)
    for k in range(1, 201):
        time = 0.005 * k
        speed += 0.0025 * (onset(time - 0.005) + onset(time))
        f.predict(MS + 5 * MS * k, onset(time - late))
        if seen or time < 0.5:
            f.correct(speed, 1e-4, by_wheels=0.0)
    return f, speed


@pytest.mark.parametrize("late", [0.0, 0.02, 0.08])
def test_an_accelerometer_that_is_late_as_stated_gives_the_speed_of_now(late: float) -> None:
    f, speed = late_filter(late, late, 0.0, seen=False)
    assert f.speed == pytest.approx(speed, abs=0.025)  # 8 m/s^2 over half a sample


def test_a_lateness_that_is_not_known_is_in_the_variance_as_far_as_the_acceleration_has_changed() -> None:
    (sure, _), (unsure, speed) = (late_filter(0.05, 0.0, stddev, seen=False) for stddev in (0.0, 0.05))
    assert unsure.speed_variance - sure.speed_variance == pytest.approx((8.0 * 0.05) ** 2, rel=0.02)
    assert abs(unsure.speed - speed) < 1.96 * unsure.speed_variance**0.5
    assert abs(sure.speed - speed) > 1.96 * sure.speed_variance**0.5


def test_how_late_an_accelerometer_may_be_moves_nothing_and_counts_as_far_as_corrections_leave_it() -> None:
    (sure, _), (unsure, _) = (late_filter(0.05, 0.0, stddev, seen=True) for stddev in (0.0, 0.05))
    error = unsure.speed - late_filter(0.0, 0.0, 0.0, seen=True)[0].speed
    assert (unsure.speed, unsure.offset) == (sure.speed, sure.offset)
    assert 0.05 < error < 8.0 * 0.05
    assert error < (unsure.speed_variance - sure.speed_variance) ** 0.5 < 1.15 * error


@pytest.mark.parametrize("late", [0.1, 0.2])
def test_brakes_that_are_cycled_do_not_hide_what_an_age_has_done(late: float) -> None:
    """The readings return to little for a moment, and the integral of those that are yet to come does not."""

    def braking(time: float) -> float:
        return -8.0 * (1.0 + np.sin(2.0 * np.pi * time / 0.15)) if time > 0.0 else 0.0

    f = SpeedFilter(
        AccelerometerParameters(stddev=1e-3, bias_stddev=1e-3), SpeedFilterTuning(gain_stddev=0.0), 0.0, 0.0, late
    )
    speed, z = 30.0, []
    f.predict(MS, 0.0)
    f.start(speed, 1e-6)
    for k in range(1, 401):
        speed += 0.005 * braking(0.005 * k)
        f.predict(MS + 5 * MS * k, braking(0.005 * k - late))
        if k > 100:
            z.append((f.speed - speed) / f.speed_variance**0.5)
    assert np.mean(np.array(z) < 1.96) > 0.9


def test_limit_lowers_the_uncertainty_to_its_value_and_moves_nothing() -> None:
    f = blind_filter(4.0)
    speed, offset, steady, offset_variance = f.speed, f.offset, f.steady_road_variance, f.offset_variance
    total = f.speed_variance
    f.limit(0.5 * total)
    assert f.speed_variance == pytest.approx(0.5 * total)
    assert f.offset_variance < offset_variance
    f.limit(0.5 * steady)
    assert f.speed_variance == pytest.approx(0.5 * steady)
    assert (f.speed, f.offset) == (speed, offset)


def test_limit_that_is_repeated_makes_no_offset_certain() -> None:
    f = blind_filter(0.1)
    f.doubt_offset(1.0)
    for k in range(2100, 3000):
        f.predict(k * 5 * MS, 0.0)
        f.limit(1e-3)
    assert f.offset_variance >= 1.0


def test_measurement_after_a_blind_time_counts_against_all_that_may_have_happened() -> None:
    f = blind_filter(4.0)
    total = f.speed_variance
    f.correct(10.1, 0.01)
    assert f.speed - 10.0 == pytest.approx(0.1 * total / (total + 0.01), abs=0.005)
    assert f.offset < -0.01


def test_acceleration_is_continuous_when_the_accelerometer_goes_and_offset_is_kept_until_it_returns() -> None:
    f = run_speed_filter(0, 0.35)
    offset, acceleration, speed = f.offset, f.acceleration, f.speed
    f.predict(401 * 5 * MS, None)
    assert f.acceleration == pytest.approx(acceleration)
    assert f.speed == pytest.approx(speed + 0.005 * acceleration, abs=0.01)
    f.predict(402 * 5 * MS, acceleration + 0.35)
    assert f.offset == pytest.approx(offset)


@given(st.lists(st.tuples(st.booleans(), st.integers(0, 3)), min_size=1, max_size=80))
def test_queue_gives_the_same_samples_to_the_same_outputs_however_the_streams_interleave(
    steps: list[tuple[bool, int]],
) -> None:
    """Two streams at 5 ms, either ahead of the other by at most 3 samples, with a hold of 20 ms."""

    def run(lead: list[int]) -> dict[int, list[int]]:
        queue: SpeedQueue[int] = SpeedQueue(0.02)
        offered, given_to = 0, {}
        for k, ahead in enumerate(lead, start=5):
            while offered < k + ahead:
                offered += 1
                assert queue.offer(offered * 5 * MS, offered) is None
            given_to[k] = [payload for _, payload in queue.due(k * 5 * MS, False)]
        return given_to

    in_step = run([0] * len(steps))
    apart = run([offset - 3 if late else offset for late, offset in steps])
    assert in_step == apart


def test_queue_refuses_repeats_and_zero_and_starts_again_after_a_jump_back() -> None:
    queue: SpeedQueue[str] = SpeedQueue(0.02)
    assert queue.offer(0, "zero") == "stamp is zero"
    assert queue.offer(1000 * MS, "old") is None
    assert queue.offer(1000 * MS, "again") == "stamp repeats"
    assert queue.offer(951 * MS, "late") == "late sample"
    assert queue.late == 1
    assert list(queue.due(1010 * MS, False)) == []
    assert queue.offer(100 * MS, "new") is None
    assert list(queue.due(130 * MS, True)) == [(100 * MS, "new")]


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


@given(st.lists(st.tuples(st.floats(-0.2, 0.2), st.floats(-3.0, 3.0)), min_size=1, max_size=30))
def test_braked_wheels_are_never_taken_to_roll_faster_than_free_ones(samples: list[tuple[float, float]]) -> None:
    car = SpeedFilter()
    car.predict(MS, 0.0)
    car.start(20.0, 0.04)
    for k, (error, effort) in enumerate(samples, start=2):
        car.predict(k * 10 * MS, -effort)
        car.correct(car.speed * (1.0 + error), 1e-4, None, effort)
        assert car.compliance >= 0.0
        assert car.speed_variance > 0.0


def test_the_speed_has_as_much_of_the_radii_as_it_is_made_of_wheels() -> None:
    made = SpeedFilter()
    made.predict(1_000_000, 0.0)
    made.start(10.0, 0.01)
    assert made.by_wheels == 1.0
    made.correct(10.1, 0.01)
    assert made.by_wheels == 1.0
    made.correct(10.0, 0.005, by_wheels=0.0)
    assert made.by_wheels == pytest.approx(0.5, abs=0.01)
    for _ in range(50):
        made.correct(10.0, 0.001, by_wheels=0.0)
    assert made.by_wheels < 0.05
    made.start(10.0, 0.01, by_wheels=0.0)
    assert made.by_wheels == 0.0
