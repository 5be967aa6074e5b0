"""Plausibility of a wheel speed: faults are found in time, healthy ones are not blamed, a locked wheel is not dead."""

from collections.abc import Callable, Sequence
from math import nan
from typing import NamedTuple

import numpy as np
import pytest

from abs_supervisor.measurements import Measurements
from abs_supervisor.plausibility import CHECKS, Plausibility
from vehicle_models.vehicle_file import load_vehicle

STEP, DT = 5_000_000, 0.005
CORNER = load_vehicle("chapter_corner").corner("front_left")
Reading = Callable[[int, float], float]


class Around(NamedTuple):
    """What a wheel speed is compared with."""

    torque: float
    others: Sequence[float] = ()
    car: float = nan
    measured: bool = False


def look(check: Plausibility, stamp: int, speed: float, around: Around) -> str:
    seen = Measurements(
        speed, around.torque, nan, around.others, car_speed=around.car, car_speed_measured=around.measured
    )
    return check.update(stamp, seen, around.torque)


def first_text(reading: Reading, others: int = 3, samples: int = 400, torque: float = 500.0) -> tuple[int | None, str]:
    """Brake with 6 m/s^2 from 25 m/s; return the sample of the first contradiction, and its text."""
    check, random = Plausibility(CORNER), np.random.default_rng(5)
    for k in range(samples):
        car = max(25.0 - 6.0 * DT * k, 0.0)
        true = car * 0.95 / CORNER.radius + 0.07 * float(random.standard_normal())
        around = Around(torque, [car * 0.95] * others, car, True)
        text = look(check, (k + 1) * STEP, reading(k, true), around)
        if text:
            return k, text
    return None, ""


def test_healthy_wheel_is_not_blamed() -> None:
    assert first_text(lambda k, true: true) == (None, "")


@pytest.mark.parametrize(
    ("reading", "named"),
    [
        (lambda k, true: 0.0 if k >= 100 else true, "dead"),
        (lambda k, true: 72.5 if k >= 100 else true, "stuck"),
        (lambda k, true: 0.0 if k >= 100 and k % 4 < 2 else true, "flickers"),
        (lambda k, true: 1.4 * true if k >= 100 else true, "where the car"),
    ],
)
@pytest.mark.parametrize("others", [0, 3])
def test_faulty_sensor_is_named_within_100_ms(reading: Reading, named: str, others: int) -> None:
    at, text = first_text(reading, others)
    assert at is not None
    assert (at - 100) * DT <= 0.1
    assert named in text


def test_spike_is_left_to_the_law() -> None:
    assert first_text(lambda k, true: 0.0 if k == 100 else true) == (None, "")


def test_wheel_that_fell_to_zero_as_a_brake_can_make_it_is_locked_not_dead() -> None:
    assert first_text(lambda k, true: max(true - 1.5 * max(k - 100, 0), 0.0)) == (None, "")


def test_wheel_that_reads_zero_although_it_is_not_braked_is_dead() -> None:
    at, text = first_text(lambda k, true: 0.0, torque=0.0)
    assert at is not None
    assert at * DT <= 0.2
    assert "its brake is released: dead" in text


@pytest.mark.parametrize(("acceleration", "dead"), [(0.0, True), (15.0, False)])
def test_wheel_that_was_released_and_does_not_spin_up_is_dead_and_one_that_does_was_locked(
    acceleration: float, dead: bool
) -> None:
    """It has fallen to zero as a locked wheel does; the road gives the slow one 15 rad/s^2, as ice does."""
    check, random, texts = Plausibility(CORNER), np.random.default_rng(1), []
    for k in range(300):
        car, torque = 25.0 - DT * k, max(600.0 - 25.0 * max(k - 100, 0), 0.0)
        speed = max(car / CORNER.radius - 2.0 * k, 0.0) + acceleration * DT * max(k - 125, 0)
        noise = 0.07 * float(random.standard_normal())
        texts.append(look(check, (k + 1) * STEP, speed + noise, Around(torque, [car] * 3, car, False)))
    named = next((k for k, text in enumerate(texts) if text), None)
    assert (named is not None) == dead
    if named is not None:
        assert "its brake is released: dead" in texts[named]
        assert (named - 123) * DT <= 0.2, "after the brake is released"


def test_a_gap_between_samples_is_neither_a_jump_nor_a_sensor_that_is_stuck() -> None:
    check = Plausibility(CORNER)
    for stamp, speed in ((1, 80.0), (401, 80.0), (801, 30.0), (802, 30.1)):
        assert look(check, stamp * STEP, speed, Around(500.0)) == ""


def test_wheel_that_spins_up_as_a_road_can_make_it_is_healthy() -> None:
    assert first_text(lambda k, true: min(true, max(k - 50, 0) * 2.0)) == (None, "")


@pytest.mark.parametrize("others", [0, 3])
@pytest.mark.parametrize("acceleration", [15.0, 35.0])
def test_wheel_that_takes_seconds_to_come_back_on_ice_with_its_brake_open_is_healthy(
    acceleration: float, others: int
) -> None:
    check, random = Plausibility(CORNER), np.random.default_rng(1)
    for k in range(-40, 1200):
        rim = min(CORNER.radius * acceleration * DT * max(k, 0), 25.0)
        speed = rim / CORNER.radius + 0.07 * float(random.standard_normal())
        around = Around(600.0 if k < 0 else 0.0, [25.0] * others, 25.0, not others)
        assert look(check, (k + 41) * STEP, speed, around) == ""


def test_a_wheel_that_was_far_behind_once_is_later_judged_as_if_it_had_not_been() -> None:
    def named_after(behind: bool) -> int:
        """Roll freely far behind the car for 0.2 s, or not; brake again, come back, and read less from 1400 on."""
        check, random = Plausibility(CORNER), np.random.default_rng(1)
        for k in range(2400):
            rim = min(2.5 + 60.0 * DT * max(k - 500, 0), 25.0) if behind else 25.0
            if k >= 1400:
                rim = max(25.0 - 8.0 * DT * (k - 1400), 5.0)
            around = Around(600.0 if k < 240 or 480 <= k < 520 else 0.0, [25.0] * 3, 25.0)
            if look(check, (k + 1) * STEP, rim / CORNER.radius + 0.07 * float(random.standard_normal()), around):
                return k
        raise AssertionError("never named")

    assert named_after(behind=True) == named_after(behind=False) > 1400


@pytest.mark.parametrize("acceleration", [-3.0, 0.0, 3.0])
def test_sensor_that_reads_half_of_a_speed_that_changes_is_named_where_the_wheel_rolls_freely(
    acceleration: float,
) -> None:
    check, random, texts = Plausibility(CORNER), np.random.default_rng(1), []
    for k in range(400):
        car = 25.0 + acceleration * DT * k
        speed = 0.5 * car / CORNER.radius + 0.07 * float(random.standard_normal())
        texts.append(look(check, (k + 1) * STEP, speed, Around(0.0, [car] * 3, car)))
    assert "rolling freely" in texts[-1]


@pytest.mark.parametrize("car", ["chapter_corner", "compact_car"])
def test_wheel_that_a_small_torque_keeps_locked_on_ice_is_not_dead(car: str) -> None:
    corner = load_vehicle(car).corner("front_left")
    check, torque = Plausibility(corner), 0.045 * corner.radius * corner.vertical_load
    assert not any(look(check, (k + 1) * STEP, 0.0, Around(torque, [25.0] * 3, 25.0)) for k in range(150))


def test_wrong_speed_of_the_car_does_not_blame_wheels_that_agree() -> None:
    check, random = Plausibility(CORNER), np.random.default_rng(1)
    for k in range(400):
        rim = 25.0 - 6.0 * DT * k
        around = Around(500.0, [rim, rim, rim], 0.5 * rim, False)
        assert look(check, (k + 1) * STEP, rim / 0.3 + 0.07 * float(random.standard_normal()), around) == ""


def test_sensor_is_trusted_again_a_second_after_the_last_contradiction() -> None:
    check, random, texts = Plausibility(CORNER), np.random.default_rng(1), []
    for k in range(600):
        rim = 25.0 - 3.0 * DT * k
        speed = 0.0 if 100 <= k < 160 else rim / 0.3 + 0.07 * float(random.standard_normal())
        texts.append(look(check, (k + 1) * STEP, speed, Around(400.0, [rim] * 3, rim, True)))
    assert all(texts[110:350])
    assert not any(texts[400:])


def test_unknown_torque_makes_no_jump_of_a_wheel_that_stops() -> None:
    check = Plausibility(CORNER)
    for k in range(100):
        assert look(check, (k + 1) * STEP, max(80.0 - 2.0 * k, 0.0), Around(nan)) == ""


COMPACT = load_vehicle("compact_car").corner("front_left")
CAR = 25.0
NOISE = 0.07


def texts_of(speeds: Sequence[float], torques: Sequence[float], stamps: Sequence[int] | None = None) -> list[str]:
    check = Plausibility(COMPACT)
    stamps = stamps or [(k + 1) * STEP for k in range(len(speeds))]
    return [
        look(check, stamp, speed, Around(torque, [CAR] * 3, CAR, False))
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
    hardest = 1.2 * torque / COMPACT.inertia
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
    speeds = [max(60.0 - max(k - 400, 0) * 1e-3 * torque / COMPACT.inertia, 0.0) for k in kept]
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
    assert speeds[-1] * COMPACT.radius == pytest.approx(2.2, abs=0.1)
    assert not any(texts_of([*speeds, *[0.0] * 100], [200.0] * 300))


def test_spike_to_zero_of_a_wheel_that_dives_is_left_to_the_law() -> None:
    speeds, torques = dive(30.0, 2150.0, 0)
    speeds[30] = speeds[31] = 0.0
    assert not any(texts_of(speeds, torques))


def test_each_check_of_the_table_has_a_condition_in_words_and_a_text_of_its_own() -> None:
    assert len({check.name for check in CHECKS}) == len({check.condition for check in CHECKS}) == len(CHECKS)
    assert all(check.lasts >= 0.0 and check.text for check in CHECKS)
