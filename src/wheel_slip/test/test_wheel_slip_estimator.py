"""Vehicle speed from wheels and accelerometer alone: slides, faults and their reports."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import isnan, pi, sin, sqrt
from pathlib import Path

import numpy as np
import pytest

from vehicle_models.reason import Reason
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle, vehicle_path
from wheel_slip.estimate import SpeedSample, WheelEstimate
from wheel_slip.estimator import SlipEstimator
from wheel_slip.wheel_equation import B

STEP = 5_000_000
RADIUS = 0.3
OFFSET = 0.25
CAR = load_vehicle("chapter_car")
"""Four wheels of RADIUS; which of them the engine drives is not known."""


@dataclass
class Drive:
    """Truth and noisy sensors of a drive, n samples at 200 Hz."""

    speed: np.ndarray
    slip: np.ndarray
    wheel_speed: np.ndarray
    acceleration: np.ndarray


def drive(acceleration: Callable[[float], float], slip: Callable[[float], float], seconds: float, v0: float) -> Drive:
    """Car with the given acceleration [m/s^2] over time and the same slip of all wheels."""
    rng = np.random.default_rng(5)
    times = np.arange(round(seconds / 0.005)) * 0.005
    a = np.array([acceleration(t) for t in times])
    speed = v0 + np.concatenate([[0.0], np.cumsum(0.0025 * (a[1:] + a[:-1]))])
    slips = np.repeat(np.array([slip(t) for t in times])[:, np.newaxis], 4, axis=1)
    omega = (1.0 - slips) * speed[:, np.newaxis] / RADIUS
    return Drive(
        speed,
        slips,
        omega + 0.07 * rng.normal(size=omega.shape),
        a + OFFSET + 0.1 * rng.normal(size=a.shape),
    )


def hard_stop() -> Drive:
    """3 s at 30 m/s, then 8 m/s^2 with slips that swing between 2 and 20 %, never back to zero."""
    return drive(
        lambda t: -8.0 * min(max((t - 3.0) / 0.2, 0.0), 1.0),
        lambda t: 0.0 if t < 3.0 else min((t - 3.0) / 0.3, 1.0) * (0.11 + 0.09 * np.sin(20.0 * (t - 3.0))),
        5.5,
        30.0,
    )


def snow_slide() -> Drive:
    """3 s at 20 m/s, then only 1.4 m/s^2, with wheels that lose 10 % within half a second and stay there."""
    return drive(
        lambda t: -1.4 if t > 3.0 else 0.0,
        lambda t: 0.1 * min(max((t - 3.0) / 0.5, 0.0), 1.0),
        8.0,
        20.0,
    )


def driven(*wheels: str) -> Vehicle:
    """The car with an engine on these wheels."""
    return replace(CAR, wheels=tuple(replace(wheel, driven=wheel.name in wheels) for wheel in CAR.wheels))


def content(estimates: list[list[WheelEstimate]], speed: np.ndarray) -> str:
    """Everything that is estimated, in words: NaN is equal to NaN."""
    flat = [each for estimate in estimates for each in estimate]
    return repr(flat) + repr(speed)


def follow(
    d: Drive, estimator: SlipEstimator, *, imu: bool = True, first: int = 1
) -> tuple[list[list[WheelEstimate]], np.ndarray]:
    estimates = [
        estimator.update((first + k) * STEP, omega.tolist(), float(a) if imu else None)
        for k, (omega, a) in enumerate(zip(d.wheel_speed, d.acceleration, strict=True))
    ]
    return estimates, np.array([each[0].vehicle_speed for each in estimates])


@pytest.fixture
def estimator() -> SlipEstimator:
    return SlipEstimator(CAR)


@pytest.mark.parametrize(("make", "bound"), [(hard_stop, 0.1), (snow_slide, 0.15)])
def test_slide_is_bridged_and_far_better_than_the_best_wheel(
    make: Callable[[], Drive], bound: float, estimator: SlipEstimator
) -> None:
    d = make()
    estimates, speed = follow(d, estimator)
    sliding = slice(700, None)
    error = speed[sliding] - d.speed[sliding]
    best = (d.wheel_speed.max(axis=1) * RADIUS - d.speed)[sliding]
    assert np.max(np.abs(error)) < bound
    assert np.sqrt(np.mean(best**2)) > 8.0 * np.sqrt(np.mean(error**2))
    slips = np.array([[each.slip for each in row] for row in estimates[700:]])
    assert np.sqrt(np.mean((slips - d.slip[sliding]) ** 2)) < 0.01


def test_offset_is_learned_while_rolling_and_its_injection_does_not_matter() -> None:
    d = hard_stop()
    speeds = []
    for injected in (0.0, 0.35, -0.35):
        estimator = SlipEstimator(CAR)
        shifted = replace(d, acceleration=d.acceleration + injected)
        speeds.append(follow(shifted, estimator)[1])
        assert estimator.car.mean[B] == pytest.approx(OFFSET + injected, abs=0.03)
    learned = slice(400, None)
    assert np.max(np.abs(speeds[1] - speeds[0])[learned]) < 0.03
    assert np.max(np.abs(speeds[2] - speeds[0])[learned]) < 0.03


@pytest.mark.parametrize("slope", [-0.1, 0.06, 0.1])
def test_a_step_of_slope_under_a_car_that_coasts_is_no_slide(slope: float, estimator: SlipEstimator) -> None:
    """The accelerometer goes on reading nothing; the tyres have no force, so the wheels cannot slip."""
    d = drive(lambda t: -9.81 * slope if t > 3.0 else 0.0, lambda _t: 0.0, 9.0, 22.0)
    rng = np.random.default_rng(6)
    estimates, speed = follow(replace(d, acceleration=OFFSET + 0.1 * rng.normal(size=d.speed.size)), estimator)
    error = np.abs(speed - d.speed)[200:]
    deviation = np.sqrt([each[0].vehicle_speed_variance for each in estimates[200:]])
    assert np.max(error) < 0.35
    assert np.mean(error < 2.0 * deviation) > 0.9
    assert np.max(error[-400:]) < 0.1


def test_wheels_that_spring_back_above_the_speed_of_the_car_do_not_raise_it(estimator: SlipEstimator) -> None:
    """Released tyres turn all wheels a tenth faster than the car for 40 ms, five times a second."""
    d = drive(
        lambda t: -8.0 if t > 3.0 else 0.0,
        lambda t: 0.0 if t < 3.0 else (-0.1 if (t - 3.0) % 0.2 > 0.16 else 0.1),
        5.0,
        30.0,
    )
    _, speed = follow(d, estimator)
    assert np.max(np.abs(speed - d.speed)[600:]) < 0.2


def test_slope_step_while_rolling_is_relearned_in_two_seconds(estimator: SlipEstimator) -> None:
    d = drive(lambda _t: 0.0, lambda _t: 0.0, 10.0, 25.0)
    step = 0.02 * 9.81
    stepped = d.acceleration + np.where(np.arange(d.speed.size) > 1400, step, 0.0)
    offsets = []
    for k, (omega, a) in enumerate(zip(d.wheel_speed, stepped, strict=True)):
        estimator.update((k + 1) * STEP, omega.tolist(), float(a))
        offsets.append(estimator.car.mean[B])
    assert offsets[1399] == pytest.approx(OFFSET, abs=0.01)
    assert offsets[1800] == pytest.approx(OFFSET + step, abs=0.03)
    assert estimator.car.speed == pytest.approx(25.0, abs=0.05)


def test_uncertainty_grows_in_the_slide_and_covers_a_slope_step(estimator: SlipEstimator) -> None:
    d = hard_stop()
    stepped = d.acceleration + np.where(np.arange(d.speed.size) > 800, 0.02 * 9.81, 0.0)
    estimates, speed = follow(replace(d, acceleration=stepped), estimator)
    deviation = np.array([sqrt(each[0].vehicle_speed_variance) for each in estimates])
    # By samples it follows the noise of the readings, too: 6 ms, by which they may be late, times 0.3 m/s^2.
    assert np.all(np.diff(deviation[720:]) >= -2e-3) and np.all(np.diff(deviation[720::20]) >= -1e-3)
    assert deviation[-1] > 1.7 * deviation[720]
    error = np.abs(speed - d.speed)[720:]
    assert error[-1] > 0.1
    assert np.all(error <= 2.0 * deviation[720:])


def released_now_and_then(t: float) -> float:
    """Slip of wheels that swing up to 10 %, and roll for 0.3 s of every 0.6 s."""
    phase = (t - 3.0) % 0.6
    return 0.1 * sin(pi * phase / 0.3) if t > 3.0 and phase < 0.3 else 0.0


def test_where_wheels_are_released_for_a_moment_a_drifting_offset_stays_within_what_is_stated() -> None:
    d = drive(lambda t: -1.8 if t > 3.0 else 0.0, released_now_and_then, 12.0, 20.0)
    speeds, deviations = [], []
    for drift in (0.01, -0.01):
        estimator = SlipEstimator(CAR)
        drifting = d.acceleration + np.where(np.arange(d.speed.size) > 600, drift, 0.0)
        estimates, speed = follow(replace(d, acceleration=drifting), estimator)
        speeds.append(speed)
        deviations.append([sqrt(each[0].vehicle_speed_variance) for each in estimates])
    assert np.max(np.abs(np.array(speeds) - d.speed)[:, 700:]) < 0.25
    assert np.max((np.abs(np.array(speeds) - d.speed) / np.array(deviations))[:, 700:]) < 1.0


@pytest.mark.parametrize(("strength", "slip"), [(6.0, 0.03), (9.0, 0.05), (4.0, 0.02)])
def test_wheels_that_stand_still_in_a_slip_hardly_move_the_integrated_speed(
    strength: float, slip: float, estimator: SlipEstimator
) -> None:
    def grown(t: float) -> float:
        return min(max((t - 3.0) / 0.2, 0.0), 1.0)

    d = drive(lambda t: -strength * grown(t), lambda t: slip * grown(t), 3.0 + 22.0 / strength, 30.0)
    estimates, speed = follow(d, estimator)
    error = np.abs(speed - d.speed)[600:]
    deviation = np.sqrt([each[0].vehicle_speed_variance for each in estimates[600:]])
    assert np.all(error < np.maximum(0.25 * slip * d.speed[600:], 0.06))
    assert np.all(error < 2.0 * deviation)


@pytest.mark.parametrize("jump", [0.9, 4.0])
def test_car_returns_to_the_wheels_even_if_the_integrated_speed_is_far_off(
    jump: float, estimator: SlipEstimator
) -> None:
    """The accelerometer jumps as the slide begins and stays there: integration drifts away by metres."""
    d = drive(
        lambda t: -6.0 if 3.0 < t < 5.0 else 0.0, lambda t: 0.15 if 3.05 < t < 5.0 else 0.0, seconds=12.0, v0=30.0
    )
    jumped = d.acceleration + np.where(np.arange(d.speed.size) > 600, jump, 0.0)
    estimates, speed = follow(replace(d, acceleration=jumped), estimator)
    assert np.max(np.abs(speed - d.speed)[900:1000]) > 1.0
    assert abs(speed[-1] - d.speed[-1]) < min(0.25 * jump, 2.0 * sqrt(estimates[-1][0].vehicle_speed_variance))


def test_launch_with_spinning_driven_wheels_follows_the_free_ones() -> None:
    estimator = SlipEstimator(driven("rear_left", "rear_right"))
    d = drive(lambda t: 4.0 if t > 2.0 else 0.0, lambda _t: 0.0, 5.0, 5.0)
    spinning = d.wheel_speed.copy()
    spinning[420:, 2:] *= 1.4
    _, speed = follow(replace(d, wheel_speed=spinning), estimator)
    assert np.max(np.abs(speed - d.speed)[200:]) < 0.1


@pytest.mark.parametrize("reading", [0.0, 300.0], ids=["dead", "spinning"])
def test_one_faulty_wheel_does_not_disturb_the_speed(reading: float, estimator: SlipEstimator) -> None:
    d = hard_stop()
    faulty = d.wheel_speed.copy()
    faulty[:, 1] = reading
    estimates, speed = follow(replace(d, wheel_speed=faulty), estimator)
    error = np.abs(speed - d.speed)[100:]
    assert np.max(error) < 0.2
    assert np.all(error < [sqrt(row[0].vehicle_speed_variance) for row in estimates[100:]])


@pytest.mark.parametrize("blind_below", [0.0, 0.6], ids=["ideal", "encoders that read zero below 0.6 m/s"])
def test_a_wheel_that_is_stuck_at_the_speed_of_a_stop_is_not_the_speed_of_the_car_at_its_end(
    blind_below: float, estimator: SlipEstimator
) -> None:
    """The others count as blind below 0.6 m/s: they may as well be locked."""
    d = drive(lambda t: -5.0 if t > 3.0 else 0.0, lambda t: 0.02 if t > 3.0 else 0.0, 8.95, 30.0)
    d.wheel_speed[d.wheel_speed * RADIUS < blind_below] = 0.0
    d.wheel_speed[700:, 0] = d.wheel_speed[700, 0]
    _, speed = follow(d, estimator)
    assert d.speed[-1] < 0.3
    assert np.max(np.abs(speed - d.speed)[700:]) < 0.5


def test_silent_imu_wheels_serve_while_they_roll_and_a_slide_is_not_bridged_in_silence(
    estimator: SlipEstimator,
) -> None:
    d = hard_stop()
    estimates, speed = follow(d, estimator, imu=False)
    assert np.max(np.abs(speed - d.speed)[200:600]) < 0.1
    error = np.abs(speed - d.speed)[700:]
    deviation = np.sqrt([each[0].vehicle_speed_variance for each in estimates[700:]])
    refused = np.array([each[0].reason is Reason.UNCERTAIN for each in estimates[700:]])
    slid = d.slip[700:, 0] > 0.05
    assert np.all((error < 3.0 * deviation) | refused | ~slid) or refused.mean() > 0.5


@pytest.mark.parametrize("stuck", [False, True])
def test_wheels_that_keep_a_slip_in_a_hard_stop_whose_imu_went_are_not_taken_for_rolling(
    stuck: bool, estimator: SlipEstimator
) -> None:
    d = drive(lambda t: -10.0 if t > 3.0 else 0.0, lambda t: 0.16 * min(max((t - 3.0) / 0.3, 0.0), 1.0), 5.0, 30.0)
    gone = 700
    estimates = [
        estimator.update(
            (k + 1) * STEP,
            omega.tolist(),
            float(d.acceleration[min(k, gone) if stuck else k]) if stuck or k < gone else None,
        )[0]
        for k, omega in enumerate(d.wheel_speed)
    ]
    valid = [k for k in range(gone, len(estimates)) if estimates[k].reason is Reason.OK]
    assert len(valid) > 20, "the last reading serves for a while"
    assert all(abs(estimates[k].slip - 0.16) < 3.0 * sqrt(estimates[k].slip_variance) + 0.01 for k in valid)


def test_where_the_speed_is_vague_wheels_that_have_become_slow_have_no_wrong_slip(
    estimator: SlipEstimator,
) -> None:
    """To first order their slip would be near 1 with a small deviation, whatever the speed may be."""
    d = drive(
        lambda t: -10.0 if 3.0 < t < 5.9 else 0.0,
        lambda t: (0.08 + 0.07 * np.sin(20.0 * t)) * min(max((t - 3.0) / 0.3, 0.0), 1.0),
        6.0,
        30.0,
    )
    estimates = [
        estimator.update((k + 1) * STEP, omega.tolist(), float(d.acceleration[k]) if k < 600 else None)
        for k, omega in enumerate(d.wheel_speed)
    ]
    for k, row in enumerate(estimates):
        for each in row if k >= 1100 else ():
            slow = abs(each.vehicle_speed - d.speed[k]) < 2.0 * sqrt(each.vehicle_speed_variance)
            assert slow and (
                each.reason is not Reason.OK or abs(each.slip - d.slip[k, 0]) < 2.0 * sqrt(each.slip_variance)
            )
    assert estimates[-1][0].reason is Reason.UNCERTAIN


def test_stuck_imu_is_left_out_and_said(estimator: SlipEstimator) -> None:
    d = drive(lambda t: -2.0 if t > 3.0 else 0.0, lambda _t: 0.0, 6.0, 25.0)
    stuck = np.where(np.arange(d.speed.size) > 500, d.acceleration[500], d.acceleration)
    estimates, speed = follow(replace(d, acceleration=stuck), estimator)
    assert estimator.accelerometer_text
    error = np.abs(speed - d.speed)[1000:]
    assert np.max(error) < 0.3
    assert np.all(error < 2.0 * np.sqrt([row[0].vehicle_speed_variance for row in estimates[1000:]]))


def test_accelerometer_without_noise_is_not_taken_for_stuck_while_the_wheels_agree(estimator: SlipEstimator) -> None:
    d = drive(lambda _t: 0.0, lambda _t: 0.0, 3.0, 25.0)
    for k, omega in enumerate(d.wheel_speed):
        estimator.update((k + 1) * STEP, omega.tolist(), 0.0)
        assert not estimator.accelerometer_text


def test_all_wheels_locked_from_the_start_give_no_speed(estimator: SlipEstimator) -> None:
    d = drive(lambda _t: -7.0, lambda _t: 1.0, 2.0, 25.0)
    estimates, _ = follow(d, estimator)
    assert all(
        each.reason in (Reason.UNCERTAIN, Reason.NO_SPEED, Reason.NOT_READY) for row in estimates for each in row
    )
    assert min(sqrt(row[0].vehicle_speed_variance) for row in estimates[100:]) > 100.0


def test_standstill_is_low_speed_with_speed_zero_and_the_start_from_it_is_followed(estimator: SlipEstimator) -> None:
    d = drive(lambda t: 2.0 if t > 2.0 else 0.0, lambda _t: 0.0, 5.0, 0.0)
    # Encoders read nothing below half a metre a second.
    blind = np.where(d.wheel_speed * RADIUS < 0.5, 0.0, d.wheel_speed)
    estimates, speed = follow(replace(d, wheel_speed=blind), estimator)
    assert estimates[390][0].reason is Reason.LOW_SPEED
    assert isnan(estimates[390][0].slip)
    assert abs(speed[390]) < 0.05
    assert np.max(np.abs(speed - d.speed)[100:]) < 0.1
    assert estimates[-1][0].reason is Reason.OK


def test_a_stop_in_reverse_is_the_mirror_image_of_one_forwards(estimator: SlipEstimator) -> None:
    """Before, a car that braked backwards was one that accelerates, and was up to 0.6 m/s wrong with 0.05."""
    d = hard_stop()
    backwards = replace(d, wheel_speed=-d.wheel_speed, acceleration=-d.acceleration, speed=-d.speed)
    ahead, back = (follow(each, one)[1] for each, one in ((d, SlipEstimator(CAR)), (backwards, estimator)))
    np.testing.assert_allclose(back, -ahead, atol=1e-4)


def test_reverse_has_a_speed_and_no_slip(estimator: SlipEstimator) -> None:
    estimates, speed = follow(drive(lambda _t: 0.0, lambda _t: 0.0, 2.0, -3.0), estimator)
    assert speed[-1] == pytest.approx(-3.0, abs=0.05)
    assert all(each.reason is Reason.LOW_SPEED for each in estimates[-1])


def test_speed_sensor_that_drops_out_hands_over_to_the_wheels(estimator: SlipEstimator) -> None:
    d = hard_stop()
    for k in range(600):
        samples = [SpeedSample((k + 1) * STEP, d.speed[k] + 0.01, 1e-3)] if k < 300 else []
        row = estimator.update((k + 1) * STEP, d.wheel_speed[k].tolist(), float(d.acceleration[k]), samples)
        if k > 20:
            assert row[0].vehicle_speed == pytest.approx(d.speed[k], abs=0.1)
    assert not estimator.speed_sensor.speaks(600 * STEP)


def after_gap(seconds: float, estimator: SlipEstimator) -> tuple[WheelEstimate, list[WheelEstimate]]:
    """A hard stop with a gap in the middle of the slide: the estimate before the gap, and those after it."""
    d = hard_stop()
    rows = []
    for k in range(850):
        stamp = (k + 1) * STEP + (round(seconds * 1e9) if k >= 700 else 0)
        rows.append(estimator.update(stamp, d.wheel_speed[k].tolist(), float(d.acceleration[k]))[0])
    return rows[699], rows[700:]


def test_short_gap_leaves_a_speed_in_doubt(estimator: SlipEstimator) -> None:
    before, after = after_gap(0.5, estimator)
    assert [each.reason for each in after[:4]] == [Reason.GAP] * 4
    assert after[0].vehicle_speed_variance > 25.0 * before.vehicle_speed_variance


def test_after_a_long_gap_in_a_slide_nothing_is_known(estimator: SlipEstimator) -> None:
    _, after = after_gap(20.0, estimator)
    assert {each.reason for each in after} <= {Reason.GAP, Reason.NO_SPEED, Reason.UNCERTAIN}
    for each, speed in zip(after, hard_stop().speed[700:850], strict=True):
        assert isnan(each.vehicle_speed) or abs(each.vehicle_speed - speed) < 2.0 * sqrt(each.vehicle_speed_variance)


@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_rewound_stamps_after_reset_repeat_the_outputs(noise: float, estimator: SlipEstimator) -> None:
    d = snow_slide()
    d.wheel_speed += noise * np.random.default_rng(6).normal(size=d.wheel_speed.shape)
    first, speed = follow(d, estimator)
    estimator.reset()
    assert content(first, speed) == content(*follow(d, estimator))


@pytest.mark.parametrize("every", [8, 2])
def test_slow_inputs_are_followed_too(every: int, estimator: SlipEstimator) -> None:
    d = hard_stop()
    for k in range(0, d.speed.size, every):
        row = estimator.update((k + 1) * STEP, d.wheel_speed[k].tolist(), float(d.acceleration[k]))
        if k > 200:
            # The newest acceleration stands for the whole interval: at its change over 0.2 s that is a few cm/s.
            assert row[0].vehicle_speed == pytest.approx(d.speed[k], abs=0.05 + 0.005 * every * 8.0)


def test_a_wheel_that_spins_beyond_a_slip_of_1_5_has_no_slip_and_the_car_keeps_its_speed() -> None:
    estimator = SlipEstimator(load_vehicle("chapter_corner"))
    found: list[WheelEstimate] = []
    rng = np.random.default_rng(5)
    for k in range(1, 600):
        spun = 1.0 if k < 200 else 1.0 + min(0.02 * (k - 200), 4.0)
        known = [SpeedSample(k * STEP, 10.0 + 0.1 * rng.normal(), 0.01)]
        found += estimator.update(k * STEP, (10.0 * spun / RADIUS,), 0.1 * rng.normal(), known)
    assert all(abs(each.slip) <= 1.5 for each in found if each.reason is Reason.OK)
    assert min(each.slip for each in found if each.reason is Reason.OK) < -1.3
    assert found[-1].reason is Reason.BAD_INPUT
    assert isnan(found[-1].slip)
    assert found[-1].vehicle_speed == pytest.approx(10.0, abs=0.2)
    assert "spins" in found[-1].text


@pytest.mark.parametrize(("stated", "expected"), [(0.17, "0.400"), (0.6, "0.600")])
def test_an_offset_is_as_uncertain_as_the_vehicle_file_states_and_as_a_slope_makes_it_at_least(
    stated: float, expected: str, tmp_path: Path
) -> None:
    file = tmp_path / "car.yaml"
    shipped = vehicle_path("compact_car").read_text()
    assert "bias: {value: 0.0, stddev: 0.17}" in shipped
    file.write_text(shipped.replace("bias: {value: 0.0, stddev: 0.17}", f"bias: {{value: 0.0, stddev: {stated}}}"))
    estimator = SlipEstimator(load_vehicle(file))
    assert f"{estimator.car.covariance[B, B] ** 0.5:.3f}" == expected


def test_a_wheel_that_repeats_its_speed_in_a_braking_is_named_and_does_not_draw_the_speed_of_the_car() -> None:
    found, estimator = hard_stop(), SlipEstimator(CAR)
    stuck = round(3.5 / 0.005)
    errors, reasons = [], []
    for k, (wheels, acceleration) in enumerate(zip(found.wheel_speed, found.acceleration, strict=True)):
        read = [float(found.wheel_speed[min(k, stuck), 0]), *wheels[1:].tolist()]
        estimates = estimator.update((k + 1) * STEP, read, float(acceleration))
        if k >= stuck + 20 and found.speed[k] > 5.0:
            reasons.append(estimates[0].reason)
            errors.append((estimator.car.speed - found.speed[k]) / sqrt(estimator.car.variance))
    assert set(reasons) == {Reason.WHEEL_SENSOR}
    assert np.abs(errors).max() < 2.0


@pytest.mark.parametrize("wheel", [0, 2])
def test_a_wheel_speed_that_jumps_before_a_braking_is_not_an_accelerometer_that_fails(wheel: int) -> None:
    """Rear-driven: the speed hangs on two wheels, and one of them was believed."""
    found, estimator = hard_stop(), SlipEstimator(load_vehicle("compact_car"))
    errors = []
    for k, (wheels, acceleration) in enumerate(zip(found.wheel_speed, found.acceleration, strict=True)):
        time, read = 0.005 * k, wheels.tolist()
        if time > 2.85:
            read[wheel] *= 0.95
        torque = 8.0 * min(max((time - 3.02) / 0.2, 0.0), 1.0) * 1500.0 * RADIUS / 4.0
        estimator.update((k + 1) * STEP, read, float(acceleration), torques=(torque,) * 4)
        if time > 2.85:
            errors.append(estimator.car.speed - found.speed[k])
    assert np.abs(errors).max() < 0.3


@pytest.mark.parametrize("factor", [0.95, 1.05])
def test_a_wheel_whose_speed_jumps_as_no_force_makes_it_has_no_slip(factor: float) -> None:
    found, estimator = hard_stop(), SlipEstimator(load_vehicle("compact_car"))
    for k in range(590):  # before the brakes
        read = found.wheel_speed[k].tolist()
        if k > 300:
            read[0] *= factor
        row = estimator.update((k + 1) * STEP, read, float(found.acceleration[k]), torques=(0.0,) * 4)
        if k > 350:
            assert row[0].reason is Reason.WHEEL_SENSOR
            assert isnan(row[0].slip)
            assert all(each.reason is Reason.OK for each in row[1:])


@pytest.mark.parametrize("car", ["chapter_car", "chapter_corner"])
def test_slips_are_as_uncertain_as_encoder_rings_that_are_not_round_make_them(car: str) -> None:
    """By 2 %, once in a turn: no filter averages that out."""
    found, vehicle = hard_stop(), load_vehicle(car)
    estimator, count = SlipEstimator(vehicle), len(vehicle.wheels)
    angles = np.cumsum(found.wheel_speed * 0.005, axis=0) + np.array([0.0, 1.0, 3.0, 4.5])
    read = (found.wheel_speed * (1.0 + 0.02 * np.sin(angles)))[:, :count]
    off = []
    for k, (wheels, acceleration) in enumerate(zip(read, found.acceleration, strict=True)):
        row = estimator.update((k + 1) * STEP, wheels.tolist(), float(acceleration))
        if k > 200:
            assert all(each.reason is Reason.OK for each in row)
            off += [abs(each.slip - found.slip[k, 0]) / sqrt(each.slip_variance) for each in row]
    assert np.mean(np.array(off) > 3.0) < 0.01
    assert np.mean(np.array(off) > 1.0) > 0.05  # nor are they much wider than that
