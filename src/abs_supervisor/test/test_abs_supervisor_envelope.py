"""The envelope: what is evidence for a release, and how long one may last, whatever the law wants."""

from math import nan, pi, sin
from typing import Any

import numpy as np
import pytest

from abs_supervisor.envelope import Envelope
from abs_supervisor.release_caps import Cap
from abs_supervisor.release_evidence import Release, ReleaseEvidence, Wheel
from abs_supervisor.tuning import EnvelopeTuning, EvidenceTuning
from vehicle_models.brake_actuator import ActuatorParameters, Command
from vehicle_models.vehicle import CornerParameters

STEP = 5_000_000
DT = 0.005
RADIUS = 0.3
INERTIA = 1.0
CORNER = CornerParameters(radius=RADIUS, inertia=INERTIA, mass=375.0, vertical_load=3678.75)
SPEED = 20.0
DEMAND = 800.0


class Bench:
    """An envelope whose law always wants a release; the wheel's sensor has the noise of section 8.3.2."""

    def __init__(self, law: Command = Command.DECREASE, noise: float = 0.07) -> None:
        self.noise = noise
        self.envelope = Envelope(CORNER, ActuatorParameters(), EnvelopeTuning())
        self.law = law
        self.stamp = 0
        self.random = np.random.default_rng(7)
        self.rolled = False

    def sample(self, speed: float, car: float = SPEED, torque: float = 300.0, **known: float) -> Command:
        self.stamp += STEP
        noise = self.noise * float(self.random.standard_normal())
        wheel = Wheel(speed=speed / RADIUS + noise, braked=True, slip_stddev=0.003, car_deceleration=5.0)
        for name, value in known.items():
            setattr(wheel, name, value)
        self.envelope.look(self.stamp, wheel)
        command = self.envelope.judge(self.stamp, self.law, car, torque, DEMAND)
        self.envelope.commanded(self.stamp, command, DEMAND)
        return command

    def slipping(self, slip: float, count: int, torque: float = 300.0, **known: float) -> list[Command]:
        if not self.rolled:
            self.roll(torque)
        return [self.sample(SPEED * (1.0 - slip), torque=torque, slip=slip, **known) for _ in range(count)]

    def roll(self, torque: float = 300.0) -> None:
        """Before it slips, it rolls: that it falls is what confirms a slip."""
        self.rolled = True
        for _ in range(12):
            self.sample(SPEED, torque=torque, slip=0.0)


@pytest.mark.parametrize(
    ("slip", "lambda_max", "released"),
    [
        (0.19, nan, False),
        (0.25, nan, True),
        (0.07, 0.17, False),
        (0.11, 0.17, True),
        (0.03, 0.02, False),
        (0.25, 0.9, True),
    ],
)
def test_slip_is_evidence_above_half_of_the_peak_or_a_fifth_without_a_curve(
    slip: float, lambda_max: float, released: bool
) -> None:
    commands = Bench().slipping(slip, 40, lambda_max=lambda_max)
    assert (Command.DECREASE in commands) == released
    assert commands[0] is not Command.DECREASE, "one sample is no evidence"


@pytest.mark.parametrize(("slip", "released"), [(0.23, False), (0.27, True)])
def test_a_slip_that_stays_must_be_larger_by_a_quarter(slip: float, released: bool) -> None:
    bench, found = Bench(), []
    for k in range(300):
        # From rolling to a slip that stays, slowly enough for the wheel to decelerate like the car.
        now = slip * min(k / 200, 1.0)
        car = SPEED - 5.0 * DT * k
        found.append(bench.sample(car * (1.0 - now), slip=now))
    assert (Command.DECREASE in found) == released


def test_uncertain_curve_and_slip_need_more_slip() -> None:
    assert Command.DECREASE not in Bench().slipping(0.11, 40, lambda_max=0.1, lambda_max_stddev=0.15)
    assert Command.DECREASE not in Bench().slipping(0.11, 40, lambda_max=0.1, slip_stddev=0.08)
    assert Command.DECREASE in Bench().slipping(0.11, 40, lambda_max=0.1)


@pytest.mark.parametrize(("noise", "released"), [(0.07, True), (0.21, False)])
def test_a_curve_that_was_fitted_to_a_noisy_wheel_speed_needs_more_slip(noise: float, released: bool) -> None:
    bench = Bench(noise=noise)
    bench.slipping(0.02, 200)
    assert (Command.DECREASE in bench.slipping(0.16, 40, lambda_max=0.216, lambda_max_stddev=0.026)) == released
    assert Command.DECREASE in bench.slipping(0.25, 40, lambda_max=0.216, lambda_max_stddev=0.026)


def test_without_slip_a_dive_of_the_wheel_is_evidence_and_ordinary_braking_is_not() -> None:
    braked, diving = Bench(), Bench()
    ordinary = [braked.sample(SPEED - 9.0 * DT * k) for k in range(200)]
    assert set(ordinary) == {Command.INCREASE}
    assert braked.envelope.release is Release.REFUSED
    dive = [diving.sample(SPEED - 60.0 * DT * k) for k in range(40)]
    assert Command.DECREASE in dive
    assert diving.envelope.release is Release.BY_DECELERATION


def test_wheel_of_unknown_slip_that_dived_gets_no_pressure_while_it_gains_speed() -> None:
    """It is back when it gains no more: how far it fell behind is not known, and the car may brake gently."""
    bench = Bench()
    for k in range(30):
        bench.sample(SPEED - 30.0 * DT * k)
    bottom = SPEED - 30.0 * DT * 29
    assert bench.envelope.release is Release.BY_DECELERATION
    bench.law = Command.INCREASE
    gains = [bench.sample(bottom + 16.0 * DT * k) for k in range(50)]
    assert set(gains[16:]) == {Command.HOLD}
    top = bottom + 16.0 * DT * 49
    back = [bench.sample(top - 2.0 * DT * k) for k in range(30)]
    assert set(back[10:]) == {Command.INCREASE}
    bench.law = Command.DECREASE
    assert bench.sample(top) is not Command.DECREASE, "the dive is over"


def test_wheel_of_unknown_slip_that_gains_speed_without_a_dive_is_not_held() -> None:
    bench = Bench(law=Command.INCREASE)
    assert {bench.sample(SPEED + 10.0 * DT * k) for k in range(60)} == {Command.INCREASE}


@pytest.mark.parametrize(("behind", "released"), [(0.15, False), (0.3, True), (nan, False)])
def test_without_slip_a_wheel_far_behind_the_others_is_evidence(behind: float, released: bool) -> None:
    bench = Bench()
    commands = [bench.sample(10.0 - 2.0 * DT * k, behind=behind, lambda_max=0.06) for k in range(40)]
    assert (Command.DECREASE in commands) == released


@pytest.mark.parametrize(
    ("deceleration", "alike", "released"), [(6.0, True, False), (6.0, False, True), (25.0, True, True)]
)
def test_slip_of_wheels_that_keep_together_and_never_fell_is_an_error_of_the_speed(
    deceleration: float, alike: bool, released: bool
) -> None:
    """An accelerometer that reads 1 m/s^2 too much makes a car faster and faster than all of its wheels."""
    bench, commands = Bench(), []
    bench.slipping(0.01, 40, alike=alike)
    for k in range(1, 400):
        rim = max(SPEED - deceleration * DT * k, 0.5)
        car = SPEED - 2.5 * DT * k
        commands.append(
            bench.sample(rim, car, slip=1.0 - rim / car, alike=alike, car_deceleration=5.0 if alike else 2.5)
        )
    assert (Command.DECREASE in commands) == released


def test_after_a_hard_application_of_the_brake_wheels_that_keep_together_are_believed_again() -> None:
    """A step of the pressure takes a wheel to its slip faster than any car brakes: that is no slide."""
    bench, commands = Bench(), []
    for k in range(400):
        slip = 0.12 * min(k / 20, 1.0)
        rim = (SPEED - 5.0 * DT * k) * (1.0 - slip)
        believed = slip + max(k - 100, 0) * 0.002
        commands.append(bench.sample(rim, slip=believed, alike=True))
    assert Command.DECREASE not in commands


def test_wheels_that_are_locked_together_are_released() -> None:
    bench = Bench()
    bench.slipping(0.01, 40, alike=True)
    dive = [
        bench.sample(max(SPEED - 30.0 * DT * k, 0.0), slip=min(30.0 * DT * k / SPEED, 1.0), alike=True)
        for k in range(900)
    ]
    assert Command.DECREASE in dive[:80]
    assert Command.DECREASE in dive[300:], "once the caps allow it"


def test_wheels_that_stand_stay_released_where_their_slip_is_not_known_any_more() -> None:
    """And get their pressure back when they turn again."""
    bench = Bench()
    for k in range(50):
        rim = max(SPEED - 200.0 * DT * k, 0.0)
        bench.sample(rim, slip=1.0 - rim / SPEED)
    assert {bench.sample(0.0, car=7.0) for _ in range(10)} == {Command.DECREASE}
    back = [bench.sample(min(100.0 * DT * k, 0.9 * SPEED - 5.0 * DT * k)) for k in range(80)]
    assert Command.DECREASE not in back[60:]


def test_known_slip_is_believed_in_place_of_other_wheels() -> None:
    assert Command.DECREASE not in Bench().slipping(0.05, 40, behind=0.5)


def test_known_small_slip_contradicts_a_dive() -> None:
    bench = Bench()
    commands = [bench.sample(SPEED - 60.0 * DT * k, slip=0.05) for k in range(40)]
    assert set(commands) == {Command.INCREASE}


def test_dive_at_half_of_the_slip_for_a_release_stops_the_rise_of_the_pressure() -> None:
    bench = Bench()
    commands = [bench.sample(SPEED - 60.0 * DT * k, slip=0.15) for k in range(40)]
    assert commands[-1] is Command.HOLD
    assert Command.DECREASE not in commands
    assert bench.sample(SPEED - 60.0 * DT * 40, slip=0.15, torque=DEMAND) is Command.INCREASE


@pytest.mark.parametrize("noise", [0.07, 0.21])
def test_ripple_of_the_encoder_that_was_learned_is_no_evidence(noise: float) -> None:
    evidence, random = ReleaseEvidence(RADIUS, EvidenceTuning()), np.random.default_rng(3)
    speed, angle, verdicts = 30.0, 0.0, []
    for k in range(600):
        braked = k >= 100
        speed -= 7.0 * DT * braked
        angle += speed / RADIUS * DT
        ripple = 0.02 * sin(angle)
        measured = speed / RADIUS * (1.0 + ripple) + noise * float(random.standard_normal())
        evidence.update(k * STEP + STEP, Wheel(speed=measured, slip=-ripple, slip_stddev=0.004, braked=braked))
        verdicts.append(evidence.verdict)
    assert evidence.scatter_is_learned
    assert set(verdicts) == {Release.REFUSED}


def test_deceleration_has_the_standard_deviation_that_it_says() -> None:
    evidence, random = ReleaseEvidence(RADIUS, EvidenceTuning()), np.random.default_rng(3)
    errors, stated = [], []
    for k in range(4000):
        speed = 80.0 + 10.0 * sin(0.2 * pi * k * DT)
        rate = 2.0 * pi * float(np.cos(0.2 * pi * k * DT))
        evidence.update(k * STEP + STEP, Wheel(speed=speed + 0.07 * float(random.standard_normal()), braked=True))
        if k > 300:
            errors.append(-evidence.deceleration - RADIUS * rate)
            stated.append((evidence.release_deceleration - 1.3 * 9.81) / 3.0)
    assert np.mean(stated) == pytest.approx(np.std(errors), rel=0.15)


def test_release_ends_with_the_evidence() -> None:
    bench = Bench()
    assert bench.slipping(0.4, 10)[-1] is Command.DECREASE
    assert bench.slipping(0.0, 10)[-1] is Command.INCREASE


def longest(commands: list[Command]) -> float:
    most = now = 0
    for each in commands:
        now = now + 1 if each is Command.DECREASE else 0
        most = max(most, now)
    return most * DT


def test_wheel_that_does_not_recover_is_released_for_300_ms_and_its_pressure_returns_slowly() -> None:
    bench = Bench()
    commands = bench.slipping(1.0, 90)
    assert longest(commands) == pytest.approx(0.3, abs=1.5 * DT)
    assert bench.envelope.caps.count == 1
    capped = commands[commands.index(Command.DECREASE) + 60 :]
    returning = capped[: capped.index(Command.DECREASE)] if Command.DECREASE in capped else capped
    assert len(returning) * DT >= 0.1 - DT
    share = returning.count(Command.INCREASE) / len(returning)
    assert share * 5000.0 <= 2000.0 + 1e-9 + 5000.0 / len(returning)
    assert set(returning) == {Command.INCREASE, Command.HOLD}


def test_wheel_that_is_seen_to_recover_may_be_released_for_longer_but_not_for_more_than_a_second_in_two() -> None:
    bench = Bench()
    bench.slipping(1.0, 6)
    speeds = [18.0 * min(k / 240, 1.0) for k in range(240)]
    commands = [bench.sample(v, slip=1.0 - v / SPEED) for v in speeds]
    assert longest(commands) > 0.5
    assert bench.envelope.caps.cap in (Cap.SHARE, Cap.RETURN)
    flags = np.array([each is Command.DECREASE for each in commands + bench.slipping(1.0, 1200)])
    in_two_seconds = np.convolve(flags, np.ones(400)) * DT
    assert in_two_seconds.max() <= 1.0 + 1e-9
    assert in_two_seconds.max() > 0.5


@pytest.mark.parametrize(
    ("torque", "stands", "released"), [(1900.0, True, 0.39), (1900.0, False, 0.3), (5e4, True, 0.6)]
)
def test_wheels_that_stand_are_released_until_their_brakes_are_open(
    torque: float, stands: bool, released: float
) -> None:
    """It takes 0.38 s from 1900 N m, and 10 ms of delay; no torque is a reason for more than twice `longest`."""
    bench = Bench()
    bench.roll(torque)
    commands: list[Command] = []
    for _ in range(150):
        falls = commands.count(Command.DECREASE) * DT * 5000.0
        commands.append(bench.sample(0.0, slip=1.0, torque=max(torque - falls, 0.0), stands=stands))
    assert longest(commands) == pytest.approx(released, abs=1.5 * DT)


def test_cap_is_named_while_it_holds() -> None:
    bench = Bench()
    seen = []
    for _ in range(400):
        bench.slipping(1.0, 1)
        seen.append(bench.envelope.caps.cap)
    assert set(seen) == {Cap.NONE, Cap.CONTINUOUS, Cap.RETURN}


def test_fail_safe_after_a_cap_is_immediate_and_what_was_released_counts_on() -> None:
    bench = Bench()
    bench.slipping(1.0, 190)
    bench.law = Command.NONE
    assert bench.slipping(1.0, 1) == [Command.NONE]
    bench.law = Command.DECREASE
    flags = [each is Command.DECREASE for each in bench.slipping(1.0, 200)]
    assert sum(flags) * DT < 0.6


def test_pressure_that_has_returned_to_the_demand_is_not_held() -> None:
    bench = Bench()
    bench.slipping(1.0, 70)
    assert bench.envelope.caps.cap is Cap.CONTINUOUS
    assert bench.sample(0.0, slip=1.0, torque=DEMAND) is Command.INCREASE


@pytest.mark.parametrize("law", list(Command))
def test_near_standstill_the_driver_has_the_brake(law: Command) -> None:
    bench = Bench(law)
    for _ in range(20):
        assert bench.sample(0.0, car=1.4, slip=1.0) is Command.NONE
    assert bench.envelope.caps.cap is Cap.LOW_SPEED


def test_jump_back_in_time_keeps_the_counts() -> None:
    bench = Bench()
    bench.slipping(0.1, 5)
    bench.slipping(1.0, 90)
    counts = (bench.envelope.refused, bench.envelope.caps.count)
    assert min(counts) > 0
    bench.envelope.restart()
    assert (bench.envelope.refused, bench.envelope.caps.count) == counts


def test_parameters_in_the_wrong_order_are_refused() -> None:
    with pytest.raises(ValueError, match="least_slip"):
        EvidenceTuning(least_slip=0.3, slip_without_curve=0.2)


@pytest.mark.parametrize(
    ("slip", "stddev", "expected"),
    [(0.05, 0.003, Command.INCREASE), (0.11, 0.003, Command.HOLD), (0.07, 0.03, Command.HOLD)],
)
def test_a_hold_needs_a_slip_that_may_well_be_that_of_a_release(slip: float, stddev: float, expected: Command) -> None:
    commands = Bench(Command.HOLD).slipping(slip, 40, lambda_max=0.17, slip_stddev=stddev)
    assert set(commands) == {expected}


@pytest.mark.parametrize(("gain", "raised"), [(20.0, False), (100.0, True)])
def test_a_wheel_that_is_back_before_its_brake_gets_pressure_on_its_way(gain: float, raised: bool) -> None:
    """At a slip of 0.6 and 20 m/s it needs 0.6 s, or 0.12 s; the brake 0.02 s, 0.03 s, and 0.1 s for 500 N m."""
    bench = Bench()
    bench.slipping(0.1, 10)
    bench.slipping(0.7, 20, torque=800.0)
    bench.law, lowest = Command.INCREASE, 0.4 * SPEED
    given = [
        bench.sample(rim, torque=300.0, slip=1.0 - rim / SPEED)
        for rim in (lowest + gain * DT * (k - 10) for k in range(11))
    ]
    assert given[-1] is (Command.INCREASE if raised else Command.HOLD)


def test_a_hold_is_not_counted_as_a_release() -> None:
    bench = Bench(Command.HOLD)
    bench.slipping(0.12, 600, lambda_max=0.17)
    assert bench.envelope.caps.count == 0
    assert bench.envelope.release is Release.NOT_WANTED


@pytest.mark.parametrize(
    ("releases", "stddev", "torque", "expected"),
    [
        (10, 0.04, 280.0, Command.HOLD),
        (10, 0.04, 200.0, Command.INCREASE),
        (10, 0.01, 280.0, Command.INCREASE),
        (0, 0.04, 280.0, Command.INCREASE),
    ],
)
def test_where_slip_is_vague_a_hold_passes_near_the_torque_with_which_the_wheel_was_last_released(
    releases: int, stddev: float, torque: float, expected: Command
) -> None:
    """300 N m were too much, at a slip of 0.5; then the wheel rolls, as far as can be told."""
    bench = Bench()
    bench.slipping(0.5, releases, lambda_max=0.17, torque=300.0)
    bench.law = Command.HOLD
    commands = bench.slipping(0.0, 40, lambda_max=0.17, slip_stddev=stddev, torque=torque)
    assert commands[-1] is expected


def test_when_braking_begins_again_what_the_road_gave_is_forgotten() -> None:
    bench = Bench()
    bench.slipping(0.5, 10, lambda_max=0.17, torque=300.0)
    bench.law = Command.NONE
    bench.slipping(0.0, 1)
    bench.law = Command.HOLD
    commands = bench.slipping(0.0, 40, lambda_max=0.17, slip_stddev=0.04, torque=300.0)
    assert set(commands) == {Command.INCREASE}


PEAK = 700.0
"""[N m] that the road gave. Its loss beyond the peak stops the wheel within 45 ms at 2 m/s; the brake needs 59 ms."""


def at_the_end_of_a_stop(
    law: Command, releases: int = 10, speed: float = 2.0, slip: float = 0.15, share: float = 1.0
) -> list[Command]:
    """Return the commands where slip has a standard deviation of 0.1, after releases at PEAK with a slip of 0.5."""
    bench = Bench()
    for _ in range(12):
        bench.sample(speed, car=speed, torque=PEAK, slip=0.0)
    for _ in range(releases):
        bench.sample(0.5 * speed, car=speed, torque=PEAK, slip=0.5, lambda_max=0.17)
    bench.law = law
    known = {"slip": slip, "slip_stddev": 0.1, "lambda_max": 0.17}
    return [bench.sample((1.0 - slip) * speed, car=speed, torque=share * PEAK, **known) for _ in range(20)]


def test_torque_that_the_road_gave_is_lowered_a_little_where_a_dive_outruns_the_brake() -> None:
    assert set(at_the_end_of_a_stop(Command.DECREASE)) == {Command.DECREASE}
    assert set(at_the_end_of_a_stop(Command.DECREASE, share=0.96)) == {Command.DECREASE}


@pytest.mark.parametrize("less", [{"releases": 0}, {"slip": 0.03}, {"share": 0.94}])
def test_it_is_not_lowered_where_one_of_the_witnesses_is_missing(less: dict[str, Any]) -> None:
    assert Command.DECREASE not in at_the_end_of_a_stop(Command.DECREASE, **less)[4:]


def test_a_trim_is_no_news_of_the_road() -> None:
    """Else each would allow the next, further down."""
    bench = Bench()
    bench.slipping(0.5, 10, lambda_max=0.17, torque=PEAK)
    commands = []
    for k in range(60):
        torque = (1.0 - 0.005 * k) * PEAK
        commands.append(bench.sample(1.7, car=2.0, torque=torque, slip=0.15, slip_stddev=0.1, lambda_max=0.17))
    assert commands[8] is Command.DECREASE
    assert Command.DECREASE not in commands[11:]


def test_torque_is_not_raised_beyond_what_the_road_gave_where_a_dive_outruns_the_brake() -> None:
    assert set(at_the_end_of_a_stop(Command.INCREASE, share=1.05)) == {Command.HOLD}


@pytest.mark.parametrize("less", [{"releases": 0}, {"speed": 4.0}, {"slip": 0.03}, {"share": 0.97}])
def test_elsewhere_it_is_raised(less: dict[str, Any]) -> None:
    assert set(at_the_end_of_a_stop(Command.INCREASE, **{"share": 1.05, **less})) == {Command.INCREASE}


@pytest.mark.parametrize(("faster", "released"), [(1.0, False), (2.0, False), (8.0, True)])
def test_wheels_that_together_lose_far_more_speed_than_their_car_slip(faster: float, released: bool) -> None:
    """On snow all dive with 10 m/s^2 where the car brakes with 2; an accelerometer is not wrong by so much."""
    bench, commands = Bench(), []
    bench.slipping(0.01, 40, alike=True, car_deceleration=2.0)
    for k in range(100):
        rim, car = SPEED - (2.0 + faster) * DT * k, SPEED - 2.0 * DT * k
        slip = 1.0 - rim / car
        commands.append(bench.sample(rim, car, slip=slip, alike=True, lambda_max=0.06, car_deceleration=2.0))
    assert (Command.DECREASE in commands) == released


def test_a_wheel_rolls_for_reference_only_where_it_has_slipped_and_the_driver_asks_for_more() -> None:
    bench = Bench()
    bench.slipping(0.02, 40)
    assert not bench.envelope.may_roll(300.0, DEMAND), "nothing has shown that it slips"
    bench.slipping(0.3, 40)
    assert bench.envelope.may_roll(300.0, DEMAND)
    assert not bench.envelope.may_roll(0.95 * DEMAND, DEMAND), "the driver limits the pressure, not the road"
    assert not bench.envelope.may_roll(nan, DEMAND)
    bench.slipping(0.05, 4)
    assert not bench.envelope.may_roll(300.0, DEMAND), "its slip is not that of a release any more"


@pytest.mark.parametrize(
    ("law", "car", "expected"),
    [
        (Command.INCREASE, SPEED, Command.DECREASE),
        (Command.HOLD, SPEED, Command.DECREASE),
        (Command.NONE, SPEED, Command.NONE),
        (Command.INCREASE, 1.0, Command.NONE),
    ],
)
def test_a_roll_for_reference_is_named_and_never_takes_the_brake_from_the_driver(
    law: Command, car: float, expected: Command
) -> None:
    bench = Bench()
    bench.slipping(0.3, 40)
    stamp = bench.stamp + STEP
    assert bench.envelope.judge(stamp, law, car, 300.0, DEMAND, rolls=True) is expected
    assert (bench.envelope.release is Release.REFERENCE) == (expected is Command.DECREASE)


@pytest.mark.parametrize("rises", [True, False])
def test_a_valid_slip_and_curve_release_no_wheel_that_keeps_its_speed(rises: bool) -> None:
    """They may be wrong. It is held while the wheel is looked at, and then gets its pressure."""
    bench, most = Bench(), 0.9 * DEMAND
    bench.roll(100.0 if rises else most)
    commands = []
    for k in range(200):
        torque = min(100.0 + 10.0 * k, most) if rises else most
        car, share = SPEED - 5.0 * DT * k, 1.0 - 0.03 * min(k / 50, 1.0)
        known = {"slip": 0.3, "lambda_max": 0.04, "lambda_max_stddev": 0.002}
        commands.append(bench.sample(share * car, car, torque=torque, **known))
    assert Command.DECREASE not in commands
    assert 0.4 <= commands.count(Command.HOLD) / len(commands) <= 0.6


def test_a_wheel_that_loses_speed_while_its_brake_does_not_rise_confirms_a_slip() -> None:
    bench = Bench()
    bench.roll(500.0)
    commands = []
    for k in range(40):
        rim, car = SPEED - 14.0 * DT * k, SPEED - 5.0 * DT * k
        commands.append(bench.sample(rim, car, torque=500.0, slip=0.06 + 1.0 - rim / car, lambda_max=0.1))
    assert Command.DECREASE in commands[:20]
