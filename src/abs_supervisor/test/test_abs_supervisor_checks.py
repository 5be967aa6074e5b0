"""The checks of a wheel's sensor and of its pressure: faults are found in time, and healthy ones are not blamed."""

from collections.abc import Callable
from math import nan

import numpy as np
import pytest

from abs_supervisor.guard import Guard, Seen
from abs_supervisor.pressure_check import PressureCheck
from abs_supervisor.tuning import EnvelopeTuning
from abs_supervisor.wheel_check import Surroundings, WheelCheck
from vehicle_models.brake_actuator import ActuatorParameters, BrakeActuator, Command
from vehicle_models.vehicle_file import load_vehicle

STEP, DT = 5_000_000, 0.005
CORNER = load_vehicle("chapter_corner").corner("front_left")
Reading = Callable[[int, float], float]


def first_text(reading: Reading, others: int = 3, samples: int = 400, torque: float = 500.0) -> tuple[int | None, str]:
    """Brake with 6 m/s^2 from 25 m/s; return the sample of the first contradiction, and its text."""
    check, random = WheelCheck(CORNER), np.random.default_rng(5)
    for k in range(samples):
        car = max(25.0 - 6.0 * DT * k, 0.0)
        true = car * 0.95 / CORNER.radius + 0.07 * float(random.standard_normal())
        around = Surroundings(torque, [car * 0.95] * others, car, True)
        text = check.update((k + 1) * STEP, reading(k, true), around)
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
    check, random, texts = WheelCheck(CORNER), np.random.default_rng(1), []
    for k in range(300):
        car, torque = 25.0 - DT * k, max(600.0 - 25.0 * max(k - 100, 0), 0.0)
        speed = max(car / CORNER.radius - 2.0 * k, 0.0) + acceleration * DT * max(k - 125, 0)
        noise = 0.07 * float(random.standard_normal())
        texts.append(check.update((k + 1) * STEP, speed + noise, Surroundings(torque, [car] * 3, car, False)))
    named = next((k for k, text in enumerate(texts) if text), None)
    assert (named is not None) == dead
    if named is not None:
        assert "its brake is released: dead" in texts[named]
        assert (named - 123) * DT <= 0.2, "after the brake is released"


def test_a_gap_between_samples_is_neither_a_jump_nor_a_sensor_that_is_stuck() -> None:
    check = WheelCheck(CORNER)
    for stamp, speed in ((1, 80.0), (401, 80.0), (801, 30.0), (802, 30.1)):
        assert check.update(stamp * STEP, speed, Surroundings(500.0)) == ""


def test_wheel_that_spins_up_as_a_road_can_make_it_is_healthy() -> None:
    assert first_text(lambda k, true: min(true, max(k - 50, 0) * 2.0)) == (None, "")


@pytest.mark.parametrize("others", [0, 3])
@pytest.mark.parametrize("acceleration", [15.0, 35.0])
def test_wheel_that_takes_seconds_to_come_back_on_ice_with_its_brake_open_is_healthy(
    acceleration: float, others: int
) -> None:
    check, random = WheelCheck(CORNER), np.random.default_rng(1)
    for k in range(-40, 1200):
        rim = min(CORNER.radius * acceleration * DT * max(k, 0), 25.0)
        speed = rim / CORNER.radius + 0.07 * float(random.standard_normal())
        around = Surroundings(600.0 if k < 0 else 0.0, [25.0] * others, 25.0, not others)
        assert check.update((k + 41) * STEP, speed, around) == ""


def test_a_wheel_that_was_far_behind_once_is_later_judged_as_if_it_had_not_been() -> None:
    def named_after(behind: bool) -> int:
        """Roll freely far behind the car for 0.2 s, or not; brake again, come back, and read less from 1400 on."""
        check, random = WheelCheck(CORNER), np.random.default_rng(1)
        for k in range(2400):
            rim = min(2.5 + 60.0 * DT * max(k - 500, 0), 25.0) if behind else 25.0
            if k >= 1400:
                rim = max(25.0 - 8.0 * DT * (k - 1400), 5.0)
            around = Surroundings(600.0 if k < 240 or 480 <= k < 520 else 0.0, [25.0] * 3, 25.0)
            if check.update((k + 1) * STEP, rim / CORNER.radius + 0.07 * float(random.standard_normal()), around):
                return k
        raise AssertionError("never named")

    assert named_after(behind=True) == named_after(behind=False) > 1400


@pytest.mark.parametrize("acceleration", [-3.0, 0.0, 3.0])
def test_sensor_that_reads_half_of_a_speed_that_changes_is_named_where_the_wheel_rolls_freely(
    acceleration: float,
) -> None:
    check, random, texts = WheelCheck(CORNER), np.random.default_rng(1), []
    for k in range(400):
        car = 25.0 + acceleration * DT * k
        speed = 0.5 * car / CORNER.radius + 0.07 * float(random.standard_normal())
        texts.append(check.update((k + 1) * STEP, speed, Surroundings(0.0, [car] * 3, car)))
    assert "rolling freely" in texts[-1]


@pytest.mark.parametrize("car", ["chapter_corner", "compact_car"])
def test_wheel_that_a_small_torque_keeps_locked_on_ice_is_not_dead(car: str) -> None:
    corner = load_vehicle(car).corner("front_left")
    check, torque = WheelCheck(corner), 0.045 * corner.radius * corner.vertical_load
    assert not any(check.update((k + 1) * STEP, 0.0, Surroundings(torque, [25.0] * 3, 25.0)) for k in range(150))


def test_wrong_speed_of_the_car_does_not_blame_wheels_that_agree() -> None:
    check, random = WheelCheck(CORNER), np.random.default_rng(1)
    for k in range(400):
        rim = 25.0 - 6.0 * DT * k
        around = Surroundings(500.0, [rim, rim, rim], 0.5 * rim, False)
        assert check.update((k + 1) * STEP, rim / 0.3 + 0.07 * float(random.standard_normal()), around) == ""


def test_sensor_is_trusted_again_a_second_after_the_last_contradiction() -> None:
    check, random, texts = WheelCheck(CORNER), np.random.default_rng(1), []
    for k in range(600):
        rim = 25.0 - 3.0 * DT * k
        speed = 0.0 if 100 <= k < 160 else rim / 0.3 + 0.07 * float(random.standard_normal())
        texts.append(check.update((k + 1) * STEP, speed, Surroundings(400.0, [rim] * 3, rim, True)))
    assert all(texts[110:350])
    assert not any(texts[400:])


def pressures(
    demand: Callable[[int], float], command: Callable[[int], Command], change: Callable[[list[float]], float]
) -> list[str]:
    check, brake, random = PressureCheck(ActuatorParameters()), BrakeActuator(1, DT), np.random.default_rng(2)
    true, texts = [0.0] * 40, []
    for k in range(400):
        felt = change(true) + 3.2 * float(random.standard_normal())
        texts.append(check.update((k + 1) * STEP, felt, demand(k)))
        check.commanded((k + 1) * STEP, demand(k), command(k))
        true.append(float(brake.step(demand(k), command(k))[0]))
    return texts


def cycling(k: int) -> Command:
    return (
        (Command.INCREASE, Command.DECREASE, Command.HOLD, Command.INCREASE)[k // 13 % 4] if k > 120 else Command.NONE
    )


@pytest.mark.parametrize("level", [150.0, 500.0, 1200.0])
@pytest.mark.parametrize("command", [lambda k: Command.NONE, cycling])
def test_pressure_that_follows_is_not_blamed(level: float, command: Callable[[int], Command]) -> None:
    texts = pressures(lambda k: level if k >= 100 else 0.0, command, lambda true: true[-1])
    assert not any(texts)


@pytest.mark.parametrize("level", [150.0, 500.0, 1200.0])
@pytest.mark.parametrize(
    "change", [lambda true: 0.0, lambda true: 0.5 * true[-1], lambda true: true[-13]], ids=["stuck", "half", "late"]
)
def test_pressure_that_does_not_follow_is_named_within_half_a_second(
    level: float, change: Callable[[list[float]], float]
) -> None:
    texts = pressures(lambda k: level if k >= 100 else 0.0, lambda k: Command.NONE, change)
    named = next(k for k, text in enumerate(texts) if text)
    assert 0.0 < (named - 100) * DT <= 0.5


@pytest.mark.parametrize("level", [55.0, 77.0, 150.0])
def test_half_of_a_gentle_pressure_is_named_and_one_with_tolerances_is_not(level: float) -> None:
    halved = pressures(lambda k: level if k >= 100 else 0.0, lambda k: Command.NONE, lambda true: 0.5 * true[-1])
    named = next(k for k, text in enumerate(halved) if text)
    assert 0.0 < (named - 100) * DT <= 0.5
    assert "N m" in halved[named]
    for gain, offset in ((0.85, -8.0), (1.15, 8.0)):
        with_tolerances = pressures(
            lambda k: level if k >= 100 else 0.0,
            cycling,
            lambda true, gain=gain, offset=offset: gain * true[-1] + offset,  # type: ignore[misc]
        )
        assert not any(with_tolerances)


@pytest.mark.parametrize("rate", [100.0, 400.0, 2000.0])
def test_pressure_that_follows_a_pedal_that_moves_is_not_blamed(rate: float) -> None:
    def pedal(k: int) -> float:
        return min(rate * DT * k, 300.0) - min(max(rate * DT * (k - 250), 0.0), 200.0)

    assert not any(pressures(pedal, lambda k: Command.NONE, lambda true: true[-1]))


@pytest.mark.parametrize(
    ("others", "slip", "slides"),
    [
        ([3.0, 3.0, 0.3], nan, True),
        ([3.0, 0.3, 0.3], nan, False),  # one may be stuck
        ([1.0, 1.0, 1.0], nan, False),
        ([3.0], nan, False),
        ([3.0, 3.0, 3.0], 0.9, False),  # known: the speed of the car is, too
    ],
)
def test_two_other_wheels_show_that_a_slow_wheel_of_unknown_slip_slides(
    others: list[float], slip: float, slides: bool
) -> None:
    guard = Guard(CORNER, EnvelopeTuning(), ActuatorParameters(), commands=True)
    guard.look(STEP, Seen(1.0, torque=100.0, demand=300.0, others=others, slip=slip))
    assert guard.slides == slides


@pytest.mark.parametrize(
    ("others", "measured"),
    [([10.0] * 3, False), ([10.0] * 3, True), ([10.0, 10.0, 15.0], False), ([], False)],
)
def test_no_speed_of_the_car_releases_a_wheel_that_keeps_its_own(others: list[float], measured: bool) -> None:
    guard, random = Guard(CORNER, EnvelopeTuning(), ActuatorParameters(), commands=True), np.random.default_rng(1)
    commands = []
    for k in range(40):
        speed = 10.0 / CORNER.radius + 0.07 * float(random.standard_normal())
        slip, car = (0.0, 10.0) if k < 20 else (0.5, 20.0)
        guard.look(
            k * STEP + STEP,
            Seen(speed, 500.0, 500.0, others, slip=slip, slip_stddev=0.01, car_speed=car, car_is_measured=measured),
        )
        commands.append(guard.command(k * STEP + STEP, Command.DECREASE))
    assert Command.DECREASE not in commands


@pytest.mark.parametrize(
    ("rim", "others", "longer"),
    [(0.0, [0.0, 15.0, 15.0], True), (0.0, [15.0] * 3, False), (0.0, [], False), (8.0, [0.0, 15.0, 15.0], False)],
)
def test_a_release_lasts_longer_only_where_two_wheels_stand_by_what_the_wheels_say(
    rim: float, others: list[float], longer: bool
) -> None:
    """One that stands alone may be a dead sensor."""
    guard, random = Guard(CORNER, EnvelopeTuning(), ActuatorParameters(), commands=True), np.random.default_rng(1)
    torque, commands = 2400.0, []
    for k in range(1, 130):
        dived = max(20.0 - 1.0 * max(k - 20, 0), rim)
        speed = dived / CORNER.radius + 0.07 * float(random.standard_normal())
        slip = 1.0 - dived / 20.0
        around = [dived if each < rim + 1.0 else each for each in others]
        guard.look(
            k * STEP,
            Seen(speed, torque, 2400.0, around, slip=slip, slip_stddev=0.01, car_speed=20.0, car_is_measured=True),
        )
        commands.append(guard.command(k * STEP, Command.DECREASE))
        torque = max(torque - 25.0, 0.0) if commands[-1] is Command.DECREASE else torque
    released = commands[commands.index(Command.DECREASE) :]
    ends = next((k for k, each in enumerate(released) if each is not Command.DECREASE), len(released))
    assert (ends * 0.005 > 0.35) == longer


def test_single_wheel_of_unknown_slip_says_that_it_cannot_tell_a_lock_from_standstill() -> None:
    guard = Guard(CORNER, EnvelopeTuning(), ActuatorParameters(), commands=True)
    guard.look(STEP, Seen(1.0, torque=100.0, demand=300.0))
    assert "locked" in guard.unchecked
    guard.look(2 * STEP, Seen(1.0, torque=100.0, demand=300.0, car_speed=0.3, slip=0.0))
    assert "locked" not in guard.unchecked


@pytest.mark.parametrize("follows", [False, True])
def test_all_wheels_that_lock_are_no_standstill_without_a_speed_of_the_car_or_with_one_that_follows_them(
    follows: bool,
) -> None:
    guard, random = Guard(CORNER, EnvelopeTuning(), ActuatorParameters(), commands=True), np.random.default_rng(1)
    commands = []
    for k in range(100):
        rim = max(20.0 - 0.5 * max(k - 50, 0), 0.0)
        speed = rim / CORNER.radius + 0.07 * float(random.standard_normal())
        car = rim if follows else nan
        guard.look(k * STEP + STEP, Seen(speed, torque=900.0, demand=900.0, others=[rim] * 3, car_speed=car))
        commands.append(guard.command(k * STEP + STEP, Command.DECREASE))
    assert Command.DECREASE not in commands[:50]
    assert commands[-1] is Command.DECREASE


def test_one_wheel_that_is_stuck_at_its_speed_does_not_keep_the_brake_from_the_driver_at_the_end_of_a_stop() -> None:
    guard = Guard(CORNER, EnvelopeTuning(), ActuatorParameters(), commands=True)
    for k in range(400):
        rim = max(20.0 - 0.06 * k, 1.0)
        guard.look(
            k * STEP + STEP,
            Seen(rim / CORNER.radius, torque=900.0, demand=900.0, others=[rim, rim, 20.0], car_speed=rim),
        )
        command = guard.command(k * STEP + STEP, Command.INCREASE)
    assert command is Command.NONE


def test_unknown_torque_makes_no_jump_of_a_wheel_that_stops() -> None:
    check = WheelCheck(CORNER)
    for k in range(100):
        assert check.update((k + 1) * STEP, max(80.0 - 2.0 * k, 0.0), Surroundings(nan)) == ""
