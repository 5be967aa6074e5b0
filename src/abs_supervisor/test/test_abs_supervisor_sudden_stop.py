"""A dead sensor of a hard-braked wheel is distinguished from a lock by its first sample."""

from collections.abc import Sequence

import numpy as np
import pytest

from abs_supervisor.wheel_check import Surroundings, WheelCheck
from vehicle_models.vehicle_file import load_vehicle

STEP, DT = 5_000_000, 0.005
CORNER = load_vehicle("compact_car").corner("front_left")
CAR = 25.0
NOISE = 0.07


def texts_of(speeds: Sequence[float], torques: Sequence[float], stamps: Sequence[int] | None = None) -> list[str]:
    check = WheelCheck(CORNER)
    stamps = stamps or [(k + 1) * STEP for k in range(len(speeds))]
    return [
        check.update(stamp, speed, Surroundings(torque, [CAR] * 3, CAR, False))
        for stamp, speed, torque in zip(stamps, speeds, torques, strict=True)
    ]


def dive(to: float, torque: float, samples: int) -> tuple[list[float], list[float]]:
    """Wheel speeds of 40 samples that fall to `to` with 340 rad/s^2, then the zeros of a dead sensor; torques.

    From the death on the brake is released, never to less than 700 N m.
    """
    random = np.random.default_rng(8)
    falling = [min(to + 340.0 * DT * (39 - k), 75.0) + NOISE * float(random.standard_normal()) for k in range(40)]
    released = [max(torque - 25.0 * k, 700.0) for k in range(samples)]
    return [*falling, *[0.0] * samples], [torque] * 40 + released


@pytest.mark.parametrize(("to", "torque"), [(50.0, 2150.0), (40.0, 1900.0), (28.0, 2150.0), (14.0, 1000.0)])
def test_sensor_that_dies_while_its_wheel_dives_is_named_at_once_and_for_good_with_the_brake_still_closed(
    to: float, torque: float
) -> None:
    texts = texts_of(*dive(to, torque, 200))
    assert not any(texts[:40])
    named = next((k - 40 for k, text in enumerate(texts) if text), None)
    assert named is not None
    assert named * DT <= 0.02
    assert all("dead" in text for text in texts[40 + named :])


def test_sensor_that_dies_between_two_samples_so_that_one_reads_half_is_named_as_well() -> None:
    speeds, torques = dive(50.0, 2150.0, 100)
    speeds[40] = 20.0
    assert "dead" in texts_of(speeds, torques)[-1]


@pytest.mark.parametrize("torque", [100.0, 600.0, 1500.0, 2600.0])
@pytest.mark.parametrize("last", np.linspace(0.0, 0.95, 20))
def test_wheel_that_locks_on_a_road_without_any_friction_is_never_dead_though_its_brake_and_stamps_err(
    torque: float, last: float
) -> None:
    """A brake stronger than its gain says by a fifth, which stays closed.

    The wheel comes to rest after the share `last` of a sample, of which the first stamp is late by 2 ms.
    """
    random = np.random.default_rng(7)
    hardest = 1.2 * torque / CORNER.inertia
    rest = (40 + int(70.0 / hardest / DT) + last) * DT
    speeds = [
        min(max(rest - k * DT, 0.0) * hardest, 60.0) + NOISE * float(random.standard_normal()) for k in range(400)
    ]
    stamps = [(k + 1) * STEP + 2_000_000 * (k == int(rest / DT + 1e-9)) for k in range(400)]
    torques = [torque + 3.2 * float(random.standard_normal()) for _ in speeds]
    assert not any("dead" in text for text in texts_of(speeds, torques, stamps))


@pytest.mark.parametrize("period", [1, 2, 10])
@pytest.mark.parametrize("torque", [150.0, 900.0, 2400.0])
def test_wheel_that_locks_is_not_dead_at_any_sample_time_nor_with_samples_that_are_lost(
    period: int, torque: float
) -> None:
    random = np.random.default_rng(period)
    kept = [k for k in range(0, 2400, period) if k % 7 < 5]
    speeds = [max(60.0 - max(k - 400, 0) * 1e-3 * torque / CORNER.inertia, 0.0) for k in kept]
    noisy = [speed + NOISE * float(random.standard_normal()) for speed in speeds]
    texts = texts_of(noisy, [torque] * len(kept), [(k + 1) * 1_000_000 for k in kept])
    assert not any(texts)


def test_wheel_that_is_locked_is_not_dead_because_of_one_reading_that_is_too_large() -> None:
    speeds = [0.0] * 200
    speeds[100] = 17.0
    assert not any(texts_of(speeds, [600.0] * 200))


def test_wheel_whose_sensor_loses_its_signal_at_walking_speed_is_not_dead() -> None:
    random = np.random.default_rng(3)
    speeds = [30.0 - 22.7 * k / 199 + NOISE * float(random.standard_normal()) for k in range(200)]
    assert speeds[-1] * CORNER.radius == pytest.approx(2.2, abs=0.1)
    assert not any(texts_of([*speeds, *[0.0] * 100], [200.0] * 300))


def test_spike_to_zero_of_a_wheel_that_dives_is_left_to_the_law() -> None:
    speeds, torques = dive(30.0, 2150.0, 0)
    speeds[30] = speeds[31] = 0.0
    assert not any(texts_of(speeds, torques))
