"""The law on the identified curve: closed forms, bounds, symmetry, and whatever inputs may come."""

from math import exp, inf, isfinite, nan

import numpy as np
import pytest
from friction_msgs.msg import FrictionCurve, Validity
from hypothesis import given, settings
from hypothesis import strategies as st

from abs_supervisor.law.brake_line import BrakeLine
from abs_supervisor.law.choice import Change, Law, LawChoice
from abs_supervisor.law.curve_law import CurveLaw
from abs_supervisor.law.disturbance import DisturbanceFilter
from abs_supervisor.law.explained import Explained
from abs_supervisor.law.released_wheel import ReleasedWheel
from abs_supervisor.law.road_curve import RoadCurve, curve_through
from abs_supervisor.law.set_point import slip_set_point
from abs_supervisor.law.three_commands import command_towards
from abs_supervisor.law.torque_set_point import steady_torque, torque_set_point
from abs_supervisor.law.usable_curve import CurveReport, Estimate, UsableCurve
from abs_supervisor.law.wheel_observer import WheelObserver, WheelState
from abs_supervisor.law.wheel_step import slip_of, wheel_step
from abs_supervisor.ros.curve_report import curve_report
from corner_sim.corner import SingleCorner
from friction_runtime.messages import from_nanoseconds
from vehicle_models import burckhardt
from vehicle_models.brake_actuator import ActuatorParameters, BrakeActuator, Command
from vehicle_models.reason import Reason
from vehicle_models.surfaces import TABLE_8_1, surface
from vehicle_models.vehicle import CornerParameters

CORNER = CornerParameters(radius=0.3, inertia=1.0, mass=225.0, vertical_load=225.0 * 9.81)
ACTUATOR = ActuatorParameters()
STEP = 5_000_000
DT = 0.005
SLIPS = st.floats(-2.0, 2.0)
ANY = st.floats(allow_nan=True, allow_infinity=True)


def road(name: str) -> RoadCurve:
    theta = surface(name)
    theta_1, theta_2, theta_3 = (float(value) for value in theta)
    return RoadCurve(theta_1, theta_2, theta_3, float(burckhardt.peak(theta)[0]))


DRY = road("dry")


def report(
    stamp: int,
    estimate: Estimate,
    curve: RoadCurve | None = DRY,
    stddev: float = 0.001,
    restarts: int = 0,
    samples: int = 50,
) -> CurveReport:
    return CurveReport(stamp, estimate, curve, stddev, 0.0, samples, restarts)


# the road


@pytest.mark.parametrize("name", TABLE_8_1)
def test_a_road_has_friction_slope_and_peak_of_its_burckhardt_curve(name: str) -> None:
    curve, theta = road(name), surface(name)
    for slip in (-0.2, 0.0, 0.03, 0.1, 0.4, 1.0):
        assert curve.friction(slip) == pytest.approx(float(burckhardt.friction(theta, slip)), abs=1e-12)
        assert curve.slope(slip) == pytest.approx(float(burckhardt.slope(theta, slip)), abs=1e-12)
    assert curve.mu_max == pytest.approx(float(burckhardt.peak(theta)[1]))


@given(ANY, ANY, ANY, ANY)
def test_a_curve_is_refused_or_finite(theta_1: float, theta_2: float, theta_3: float, lambda_max: float) -> None:
    try:
        curve = RoadCurve(theta_1, theta_2, theta_3, lambda_max)
    except ValueError:
        return
    assert 0.02 <= curve.lambda_max <= 0.5
    assert curve.mu_max > 0.0


@pytest.mark.parametrize("name", TABLE_8_1)
def test_a_peak_alone_gives_the_curve_of_a_road_with_this_peak(name: str) -> None:
    curve = road(name)
    found = curve_through(curve.lambda_max, curve.mu_max)
    assert found.mu_max == pytest.approx(curve.mu_max)
    assert found.slope(found.lambda_max) == pytest.approx(0.0, abs=1e-6 * found.slope(0.0))
    for share in (0.3, 0.6, 1.5, 2.0):
        slip = share * curve.lambda_max
        assert found.friction(slip) == pytest.approx(curve.friction(slip), rel=0.08)


def test_the_law_takes_a_curve_of_another_family_by_its_peak() -> None:
    """A fit by the magic formula has lambda_max and mu_max, and no theta."""
    message = FrictionCurve(validity=Validity(reason=Reason.OK), samples=100, theta_1=nan, theta_2=nan, theta_3=nan)
    message.header.stamp = from_nanoseconds(STEP)
    message.lambda_max, message.mu_max = 0.14, 0.9
    found = curve_report(message)
    assert found.estimate is Estimate.VALID
    assert found.curve is not None
    assert found.curve.lambda_max == pytest.approx(0.14)
    assert found.curve.mu_max == pytest.approx(0.9)


# one step of the wheel


@pytest.mark.parametrize("name", TABLE_8_1)
@pytest.mark.parametrize("speed", [30.0, 5.0])
def test_two_samples_ahead_agree_with_an_exact_integration(name: str, speed: float) -> None:
    curve, theta = road(name), surface(name)
    slip = 0.8 * curve.lambda_max
    plant = SingleCorner(CORNER, [speed], [(1.0 - slip) * speed / CORNER.radius], max_step=1e-5)
    torque = 1.05 * steady_torque(CORNER, curve, slip)
    wheel_speed, car = float(plant.wheel_speed[0]), speed
    for _ in range(2):
        plant.step(torque, torque, theta, DT)
        wheel_speed, car = wheel_step(CORNER, curve, wheel_speed, car, torque, 0.0, DT)
    assert car == pytest.approx(float(plant.speed[0]), abs=2e-3)
    assert slip_of(car, CORNER.radius * wheel_speed) == pytest.approx(float(plant.slip[0]), abs=0.04 * curve.lambda_max)


@given(SLIPS, st.floats(0.0, 60.0), st.floats(0.0, 5000.0), st.floats(-2000.0, 2000.0), st.floats(1e-3, 0.02))
def test_a_step_is_finite_and_never_turns_backwards(
    slip: float, speed: float, torque: float, disturbance: float, dt: float
) -> None:
    for name in TABLE_8_1:
        wheel, car = wheel_step(
            CORNER, road(name), max((1.0 - slip) * speed / 0.3, 0.0), speed, torque, disturbance, dt
        )
        assert isfinite(wheel)
        assert wheel >= 0.0
        assert 0.0 <= car <= speed + 20.0 * dt


# the brake


@given(st.lists(st.sampled_from(list(Command)), min_size=3, max_size=40), st.floats(100.0, 2000.0))
def test_orders_under_way_do_what_the_hydraulics_do(commands: list[Command], demand: float) -> None:
    line, actuator = BrakeLine(ACTUATOR), BrakeActuator(1, DT, ACTUATOR)
    torque = 0.0
    for sample, command in enumerate(commands):
        stamp = sample * STEP
        line.order(stamp, command, demand)
        torque = line.torque_at(torque, stamp, stamp + STEP)
        assert torque == pytest.approx(float(actuator.step(demand, int(command))[0]), abs=1e-9)


# feed-forward, disturbance, commands


@pytest.mark.parametrize("name", TABLE_8_1)
def test_the_steady_torque_holds_its_slip(name: str) -> None:
    curve, theta = road(name), surface(name)
    slip = 0.9 * curve.lambda_max
    plant = SingleCorner(CORNER, [25.0], [(1.0 - slip) * 25.0 / CORNER.radius])
    torque = steady_torque(CORNER, curve, slip)
    for _ in range(40):
        plant.step(torque, torque, theta, DT)
    assert float(plant.slip[0]) == pytest.approx(slip, rel=0.02)
    assert steady_torque(CORNER, curve, curve.lambda_max) == pytest.approx(float(CORNER.peak_torque(theta)))


def test_an_error_of_the_brake_gain_cancels() -> None:
    """A gain that is 20 % too low in the file scales curve and torque alike: the pressure asked for is the same."""
    low = RoadCurve(0.8 * DRY.theta_1, DRY.theta_2, 0.8 * DRY.theta_3, DRY.lambda_max)
    slip = 0.92 * DRY.lambda_max
    assert steady_torque(CORNER, low, slip) / 0.8 == pytest.approx(steady_torque(CORNER, DRY, slip))


def test_slow_disturbances_are_followed_and_fast_ones_only_where_they_are_large() -> None:
    found = DisturbanceFilter()
    for _ in range(300):
        found.learn(40.0, DT)
    slow = found.slow
    assert slow == pytest.approx(40.0, rel=0.02)
    assert found.followed(slow, 800.0) == pytest.approx(slow)
    assert found.followed(slow + 190.0, 800.0) == pytest.approx(slow)
    assert found.followed(slow + 300.0, 800.0) == pytest.approx(slow + 200.0)
    assert found.followed(slow - 500.0, 800.0) == pytest.approx(slow - 500.0)


def test_the_slow_part_is_learned_at_once_and_forgotten_in_its_own_time() -> None:
    """A load that is 20 % off is so from the first sample on; a bump later is not."""
    found = DisturbanceFilter()
    for _ in range(12):
        found.learn(400.0, DT)
    assert found.slow > 0.5 * 400.0
    for _ in range(300):
        found.learn(400.0, DT)
    before = found.slow
    for _ in range(12):
        found.learn(0.0, DT)
    assert found.slow == pytest.approx(before * exp(-0.2), rel=0.02)


@given(st.floats(-1e4, 1e4), st.floats(0.0, 1e4))
def test_no_more_is_followed_than_there_is(disturbance: float, steady: float) -> None:
    followed = DisturbanceFilter().followed(disturbance, steady)
    assert 0.0 <= followed / disturbance <= 1.0 if disturbance else followed == 0.0


@given(st.floats(0.0, 3000.0), st.floats(0.0, 3000.0), st.floats(0.0, 3000.0), st.floats(0.1, 50.0))
def test_the_demand_is_the_ceiling(wanted: float, torque: float, demand: float, band: float) -> None:
    command = command_towards(wanted, torque, demand, band)
    if wanted >= demand or torque > demand:
        assert command is Command.INCREASE  # which is the driver's own pressure
    elif command is Command.INCREASE:
        assert wanted > torque or wanted >= demand - band


def test_a_torque_within_the_band_is_held() -> None:
    assert command_towards(500.0, 490.0, 900.0, 20.0) is Command.HOLD
    assert command_towards(500.0, 470.0, 900.0, 20.0) is Command.INCREASE
    assert command_towards(500.0, 530.0, 900.0, 20.0) is Command.DECREASE


# the set-point


def test_the_peak_is_passed_until_it_is_seen_and_kept_away_from_afterwards_and_at_low_speed() -> None:
    assert slip_set_point(DRY, False, 30.0) == pytest.approx(1.10 * DRY.lambda_max)
    assert slip_set_point(DRY, True, 30.0) == pytest.approx(0.92 * DRY.lambda_max)
    assert slip_set_point(DRY, False, 4.0) == slip_set_point(DRY, True, 4.0) == pytest.approx(0.81 * DRY.lambda_max)
    assert slip_set_point(DRY, True, 0.0) == pytest.approx(0.70 * DRY.lambda_max)


def test_far_beyond_the_peak_the_torque_stays_below_what_the_road_gives() -> None:
    slip = 0.92 * DRY.lambda_max
    ahead = WheelState(wheel_speed=0.4 * 20.0 / 0.3, speed=20.0, torque=900.0, slip=0.6)
    given_by_road = CORNER.radius * CORNER.vertical_load * DRY.friction(0.6)
    assert torque_set_point(CORNER, ACTUATOR, DRY, ahead, slip, 0.0, 0.0) < given_by_road


def test_a_large_error_of_the_wheel_speed_asks_for_no_more_than_the_brake_can_end() -> None:
    """Under T* the wheel moves by a; while the torque goes back at its rate, the wheel covers the rest of the error."""
    slip, speed = 0.92 * DRY.lambda_max, 25.0
    wanted = (1.0 - slip) * speed / CORNER.radius
    steady = steady_torque(CORNER, DRY, slip)
    for error in (-2.0, -12.0, -30.0):
        ahead = WheelState(wanted + error, speed, steady, slip_of(speed, CORNER.radius * (wanted + error)))
        found = steady - torque_set_point(CORNER, ACTUATOR, DRY, ahead, slip, 400.0, 0.0) + 400.0
        swept = CORNER.inertia * (found / CORNER.inertia) ** 2 / (2.0 * ACTUATOR.apply_rate)
        assert found > 0.0
        assert swept <= abs(error) * 1.0001 or ahead.slip > 1.5 * slip


def test_the_torque_falls_below_that_of_the_peak_without_a_step() -> None:
    slip = 0.9 * DRY.lambda_max
    speeds = np.arange(6.0, 2.0, -0.05)
    torques = []
    for speed in speeds.tolist():
        ahead = WheelState((1.0 - slip) * speed / CORNER.radius, speed, 800.0, slip)
        torques.append(torque_set_point(CORNER, ACTUATOR, DRY, ahead, slip, 200.0, 0.0))
    peak = steady_torque(CORNER, DRY, DRY.lambda_max)
    assert torques[-1] == pytest.approx(0.96 * peak)
    assert np.abs(np.diff(torques[25:])).max() < 0.005 * peak


# a wheel whose brake is open


def _opened(gain: float, slip: float, torque: float = 0.0, samples: int = 30) -> ReleasedWheel:
    """Follow a wheel that gains speed at a rate [rad/s^2]."""
    released = ReleasedWheel()
    for sample in range(samples):
        released.update(sample * STEP, CORNER, 40.0 + gain * sample * DT, torque, slip, DRY.lambda_max)
    return released


def test_a_wheel_with_an_open_brake_that_gains_no_speed_rolls_whatever_its_slip() -> None:
    assert _opened(gain=-3.0, slip=0.6).rolls
    assert not _opened(gain=100.0, slip=0.6).rolls
    assert not _opened(gain=-3.0, slip=0.1).rolls
    assert not _opened(gain=-3.0, slip=0.6, torque=200.0).rolls
    assert not _opened(gain=-3.0, slip=0.6, samples=9).rolls


def test_a_rolling_wheel_counts_as_slipping_again_when_it_dives_or_its_slip_is_small() -> None:
    released = _opened(gain=-3.0, slip=0.6)
    released.update(31 * STEP, CORNER, 40.0, 400.0, 0.6, DRY.lambda_max)
    assert released.rolls
    released.update(32 * STEP, CORNER, 30.0, 400.0, 0.6, DRY.lambda_max)
    assert not released.rolls
    released = _opened(gain=-3.0, slip=0.6)
    released.update(31 * STEP, CORNER, 40.0, 400.0, 0.1, DRY.lambda_max)
    assert not released.rolls


# which curve, which law


def test_a_curve_counts_from_twenty_samples_and_its_peak_as_seen_after_three_valid_ones() -> None:
    known = UsableCurve()
    known.take(report(STEP, Estimate.VALID, samples=19))
    assert known.curve is None
    for sample in range(3):
        assert not known.seen
        known.take(report((sample + 2) * STEP, Estimate.VALID))
    assert known.curve is DRY
    assert known.seen


def test_a_fit_that_began_anew_displaces_a_curve_that_explains_the_wheel_only_when_it_is_sure() -> None:
    other = road("snow")
    for explained in (True, False):
        known = UsableCurve()
        for sample in range(1, 4):
            known.take(report(sample * STEP, Estimate.VALID))
        known.take(report(4 * STEP, Estimate.VAGUE, other, stddev=0.05, restarts=1), explained)
        assert known.curve is (DRY if explained else other)
        assert known.changed is not explained
    known.take(report(5 * STEP, Estimate.VAGUE, other, restarts=2), explained=True)
    assert known.curve is other


def test_a_curve_that_was_vague_itself_is_not_kept_by_fits_that_began_anew() -> None:
    """From dry to snow a fit went astray to a peak of 0.78 and ended; the law then held a slip of 0.46 to the end."""
    astray, other = road("cobblestone"), road("snow")
    known = UsableCurve()
    known.take(report(STEP, Estimate.VAGUE, astray, stddev=0.3 * astray.lambda_max))
    for sample in range(2, 40):
        vague = report(sample * STEP, Estimate.VAGUE, other, stddev=2.0 * other.lambda_max, restarts=1)
        known.take(vague, explained=True)
        assert known.curve is (astray if sample * STEP <= STEP + 0.15e9 else other)


@pytest.mark.parametrize(
    ("peak", "level", "stddev", "displaces"),
    [
        (0.4, 1.0, 0.006, False),  # a fit that is less sure than the one before
        (0.4, 1.0, 0.0001, True),  # surer
        (2.0, 1.0, 0.03, False),
        (0.4, 0.6, 0.006, True),  # the road gives less
    ],
)
def test_on_one_road_a_fit_that_began_anew_tells_the_level_of_friction_and_not_another_peak(
    peak: float, level: float, stddev: float, displaces: bool
) -> None:
    known = UsableCurve()
    for sample in range(3):
        known.take(report(sample * STEP, Estimate.VALID))
    shape = curve_through(peak * DRY.lambda_max, DRY.mu_max)
    scale = level * DRY.mu_max / shape.friction(DRY.lambda_max)
    other = RoadCurve(scale * shape.theta_1, shape.theta_2, scale * shape.theta_3, shape.lambda_max)
    for sample in range(3, 10):
        known.take(report(sample * STEP, Estimate.VALID, other, stddev, restarts=1), explained=True)
        assert known.changed == (sample == 3)
    assert known.curve is not None
    assert known.curve.lambda_max == pytest.approx(other.lambda_max if displaces else DRY.lambda_max)
    assert known.curve.friction(DRY.lambda_max) == pytest.approx(level * DRY.mu_max)


def test_a_curve_stays_while_newer_fits_are_not_sure() -> None:
    known = UsableCurve()
    known.take(report(STEP, Estimate.VALID))
    for sample in range(2, 100):
        known.take(report(sample * STEP, Estimate.VAGUE, road("snow"), stddev=0.05, restarts=1), explained=True)
    assert known.curve is DRY


def test_a_vague_estimate_does_not_displace_a_peak_that_was_seen() -> None:
    known, vague = UsableCurve(), road("snow")
    for sample in range(3):
        known.take(report(sample * STEP, Estimate.VALID))
    known.take(report(4 * STEP, Estimate.VAGUE, vague, stddev=0.3 * vague.lambda_max))
    assert known.curve is DRY
    known.take(report(5 * STEP, Estimate.VAGUE, vague, stddev=0.2 * vague.lambda_max))
    assert known.curve is vague


def test_of_vague_estimates_of_another_road_the_surest_counts() -> None:
    known = UsableCurve()
    known.take(report(STEP, Estimate.VALID))
    for sample in range(3):
        known.take(report((sample + 2) * STEP, Estimate.VALID))
    curves = [road(name) for name in ("snow", "wet", "cobblestone")]
    for sample, (curve, share) in enumerate(zip(curves, (1.4, 1.5, 0.8), strict=True)):
        vague = CurveReport((sample + 9) * STEP, Estimate.VAGUE, curve, share * curve.lambda_max, 1.0, 50, 1)
        known.take(vague)
        assert known.curve is curves[(0, 0, 2)[sample]]


@pytest.mark.parametrize("valid", [False, True])
def test_a_fit_on_its_way_that_was_sure_for_a_moment_gives_way_to_what_it_says_later(valid: bool) -> None:
    """From dry to snow three estimates were sure of three times the peak; the law held it until the wheel locked."""
    known, snow, astray = UsableCurve(), road("snow"), road("dry")
    sure = Estimate.VALID if valid else Estimate.VAGUE
    for sample in range(3):
        known.take(CurveReport(sample * STEP, sure, astray, 0.18 * astray.lambda_max, 0.9, 50, 0))
    for sample in range(3, 60):
        known.take(CurveReport(sample * STEP, Estimate.VAGUE, snow, 0.35 * snow.lambda_max, 0.9, 50, 0))
        assert known.curve is (astray if valid or (sample - 2) * STEP <= 0.15e9 else snow)


def test_the_old_road_serves_until_the_new_one_has_twenty_samples() -> None:
    known, snow = UsableCurve(), road("snow")
    for sample in range(3):
        known.take(report(sample * STEP, Estimate.VALID))
    known.take(report(3 * STEP, Estimate.VAGUE, snow, restarts=1, samples=8))
    assert (known.curve, known.changed, known.seen) == (DRY, False, True)
    known.take(report(4 * STEP, Estimate.VAGUE, snow, restarts=1, samples=20))
    assert (known.curve, known.changed, known.seen) == (snow, True, False)


def test_a_curve_outlives_quiet_but_not_an_estimator_that_has_none() -> None:
    known = UsableCurve()
    known.take(report(0, Estimate.VALID))
    known.take(report(400 * STEP, Estimate.QUIET, None))
    assert known.curve is DRY
    known.take(report(430 * STEP, Estimate.NONE, None))
    assert known.curve is DRY
    known.take(report(431 * STEP, Estimate.NONE, None))
    assert known.curve is None


@pytest.mark.parametrize(
    ("lost", "after", "cause"),
    [
        ({"slip": False}, 0.02, Change.SLIP_LOST),
        ({"curve": False}, 0.15, Change.NO_CURVE),
    ],
)
def test_the_slope_takes_over_when_something_is_lost_and_gives_back(
    lost: dict[str, bool], after: float, cause: Change
) -> None:
    choice = LawChoice()
    good = {"braking": True, "slip": True, "curve": True}
    choice.update(0, **{**good, **lost, "slip": True})
    stamps = range(STEP, round(after * 1e9) + STEP, STEP) or [STEP]
    for stamp in stamps:
        assert choice.law is Law.CURVE
        choice.update(stamp, **{**good, **lost})
    assert (choice.law, choice.cause) == (Law.SLOPE_SIGN, cause)
    choice.update(stamps[-1] + STEP, **good)
    assert (choice.law, choice.cause) == (Law.CURVE, Change.RETURNED)


def test_a_curve_that_is_lost_within_a_braking_gives_way_at_once() -> None:
    """It was kept for 0.15 s already: the driver's pressure for as long again locks a wheel."""
    choice = LawChoice()
    assert choice.update(STEP, braking=True, slip=True, curve=True) is Law.CURVE
    assert choice.update(2 * STEP, braking=True, slip=True, curve=False) is Law.SLOPE_SIGN
    assert choice.cause is Change.NO_CURVE
    assert choice.update(3 * STEP, braking=True, slip=True, curve=True) is Law.CURVE
    choice.update(4 * STEP, braking=False, slip=True, curve=False)
    assert choice.update(5 * STEP, braking=True, slip=True, curve=False) is Law.CURVE


def test_a_curve_that_does_not_explain_its_wheel_gives_way_at_once_and_is_back_when_it_does() -> None:
    choice = LawChoice()
    assert choice.update(STEP, True, True, True, explains=False) is Law.SLOPE_SIGN
    assert choice.cause is Change.NO_CURVE
    assert choice.update(2 * STEP, True, True, True, explains=True) is Law.CURVE


@pytest.mark.parametrize(("share", "samples", "holds"), [(0.6, 110, True), (0.6, 130, False), (0.4, 1000, True)])
def test_a_torque_that_the_curve_does_not_explain_must_be_large_and_last(
    share: float, samples: int, holds: bool
) -> None:
    explained = Explained()
    for k in range(samples):
        explained.update(k * STEP, share)
    assert explained.holds == holds


def test_a_curve_explains_its_wheel_again_when_little_is_left_for_as_long() -> None:
    explained = Explained()
    shares = [0.6] * 200 + [0.4] * 200 + [0.3] * 110
    for k, share in enumerate(shares):
        explained.update(k * STEP, share)
    assert not explained.holds
    for k in range(20):
        explained.update((len(shares) + k) * STEP, 0.3)
    assert explained.holds


def test_without_braking_no_curve_is_missed() -> None:
    choice = LawChoice()
    for sample in range(400):
        choice.update(sample * STEP, braking=False, slip=True, curve=False)
    assert choice.law is Law.CURVE


# the whole law


def _stop(name: str, speed: float = 30.0) -> tuple[np.ndarray, np.ndarray]:
    """Brake with everything known; return the slips and the speeds."""
    curve, theta = road(name), surface(name)
    law, plant, actuator = (
        CurveLaw(CORNER, ACTUATOR),
        SingleCorner(CORNER, [speed]),
        BrakeActuator(1, DT),
    )
    demand, torque = 1.5 * float(CORNER.peak_torque(theta)), np.zeros(1)
    slips, speeds = [], []
    for sample in range(1, 12_000):
        stamp = sample * STEP
        law.learn(report(stamp, Estimate.VALID, curve))
        car = float(plant.speed[0])
        asked = law.ask(stamp, float(plant.wheel_speed[0]), car, float(plant.slip[0]), float(torque[0]), demand, True)
        assert asked is not None
        law.commanded(stamp, asked, demand)
        after = actuator.step(demand, int(asked))
        plant.step(torque, after, theta, DT)
        torque = after
        slips.append(float(plant.slip[0]))
        speeds.append(car)
        if car < 1.5:
            break
    return np.array(slips), np.array(speeds)


@pytest.mark.parametrize("name", TABLE_8_1)
def test_with_everything_known_the_slip_is_held_and_no_wheel_locks(name: str) -> None:
    slips, speeds = _stop(name)
    held = slips[(speeds > 8.0) & (speeds < 24.0)]
    lambda_max = road(name).lambda_max
    assert held.mean() == pytest.approx(0.92 * lambda_max, rel=0.05)
    assert held.max() < 1.3 * lambda_max
    assert slips.max() < 0.9


def test_until_a_curve_is_known_the_drivers_pressure_passes() -> None:
    law = CurveLaw(CORNER, ACTUATOR)
    asked = [law.ask(k * STEP, 100.0, 30.0, 0.0, 100.0, 1000.0, True) for k in range(1, 30)]
    assert set(asked) == {Command.INCREASE}
    assert law.ask(40 * STEP, 100.0, 30.0, 0.0, 100.0, 1000.0, True) is None
    assert law.choice.cause is Change.NO_CURVE


@pytest.mark.parametrize(("speed", "keeps"), [(4.0, True), (20.0, False), (nan, False)])
def test_at_the_end_of_a_stop_the_torque_is_kept_when_slip_is_lost(speed: float, keeps: bool) -> None:
    """At 4 m/s it is enough to know what the road gives; faster, or without a speed, the driver's pressure passes."""
    law, slip = CurveLaw(CORNER, ACTUATOR), 0.92 * DRY.lambda_max
    torque = 0.99 * steady_torque(CORNER, DRY, slip)
    for k in range(1, 100):
        law.learn(report(k * STEP, Estimate.VALID))
        law.ask(k * STEP, 4.0 * (1.0 - slip) / CORNER.radius, 4.0, slip, torque, 2000.0, True)
        law.commanded(k * STEP, Command.HOLD, 2000.0)
    asked = [law.ask(k * STEP, 10.0, speed, nan, torque, 2000.0, True) for k in range(100, 110)]
    assert set(asked) == ({Command.HOLD} if keeps else {Command.INCREASE, None})
    assert law.choice.law is (Law.CURVE if keeps else Law.SLOPE_SIGN)


@pytest.mark.parametrize(("name", "gives_way"), [("snow", True), ("dry", False)])
def test_a_curve_of_another_road_gives_way_to_the_slopes_sign(name: str, gives_way: bool) -> None:
    """The wheel keeps a slip of 0.02 under a torque that dry gives there, four times the peak's of snow."""
    law, slip = CurveLaw(CORNER, ACTUATOR), 0.02
    torque = steady_torque(CORNER, DRY, slip)
    asked = []
    for k in range(1, 301):
        law.learn(report(k * STEP, Estimate.VALID, road(name)))
        asked.append(law.ask(k * STEP, 20.0 * (1.0 - slip) / CORNER.radius, 20.0, slip, torque, 2000.0, True))
        law.commanded(k * STEP, Command.HOLD, 2000.0)
    assert None not in asked[:100]
    assert (asked[-1] is None) == gives_way
    assert law.choice.cause is (Change.NO_CURVE if gives_way else Change.NONE)


def test_below_the_peak_the_demand_passes_whatever_it_is() -> None:
    """Ordinary braking: the law asks for nothing but the driver's pressure."""
    for share in (0.1, 0.5, 0.9):
        law, plant, actuator = (
            CurveLaw(CORNER, ACTUATOR),
            SingleCorner(CORNER, [30.0]),
            BrakeActuator(1, DT),
        )
        demand, torque = share * float(CORNER.peak_torque(surface("wet"))), np.zeros(1)
        for sample in range(1, 400):
            stamp = sample * STEP
            law.learn(report(stamp, Estimate.VALID, road("wet")))
            asked = law.ask(
                stamp,
                float(plant.wheel_speed[0]),
                float(plant.speed[0]),
                float(plant.slip[0]),
                float(torque[0]),
                demand,
                True,
            )
            assert asked is Command.INCREASE
            law.commanded(stamp, asked, demand)
            after = actuator.step(demand, int(asked))
            plant.step(torque, after, surface("wet"), DT)
            torque = after


NUMBERS = st.one_of(st.floats(-1e6, 1e6), st.sampled_from([nan, inf, -inf, 0.0]))


@settings(max_examples=150, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.integers(1, 10 * STEP),
            st.floats(-10.0, 400.0),
            NUMBERS,
            NUMBERS,
            NUMBERS,
            st.floats(0.0, 1e4),
            st.booleans(),
            st.sampled_from(list(Estimate)),
            st.sampled_from(TABLE_8_1),
            NUMBERS,
            st.integers(0, 3),
            st.integers(0, 100),
        ),
        max_size=40,
    )
)
def test_whatever_comes_the_law_answers_with_a_command_or_gives_way(rows: list[tuple]) -> None:
    law, stamp = CurveLaw(CORNER, ACTUATOR), 0
    for ahead, wheel, speed, slip, torque, demand, braking, estimate, name, stddev, restarts, samples in rows:
        stamp += ahead
        told = estimate in (Estimate.VALID, Estimate.VAGUE)
        law.learn(CurveReport(stamp, estimate, road(name) if told else None, stddev, stddev, samples, restarts))
        asked = law.ask(stamp, wheel, speed, slip, torque, demand, braking)
        assert asked is None or isinstance(asked, Command)
        assert not braking or law.choice.law is Law.CURVE or asked is None
        assert not law.torque_set_point > demand
        law.commanded(stamp, Command.HOLD if asked is None else asked, demand)


def test_the_observer_finds_a_torque_that_the_curve_does_not_explain() -> None:
    """The road gives 10 % more than the curve says: that is the disturbance torque."""
    theta = np.asarray(surface("dry"), dtype=np.float64)
    weak = RoadCurve(DRY.theta_1 / 1.1, DRY.theta_2, DRY.theta_3 / 1.1, DRY.lambda_max)
    torque = 0.8 * float(CORNER.peak_torque(theta))
    plant = SingleCorner(CORNER, [30.0])
    observer = WheelObserver(CORNER, ACTUATOR)
    for sample in range(1, 120):
        observer.ordered((sample - 3) * STEP, Command.HOLD, torque)
        observer.update(sample * STEP, float(plant.wheel_speed[0]), float(plant.speed[0]), torque, weak)
        plant.step(torque, torque, theta, DT)
    missing = (
        CORNER.radius * CORNER.vertical_load * (float(plant.friction(theta)[0]) - weak.friction(float(plant.slip[0])))
    )
    assert observer.disturbance == pytest.approx(missing, rel=0.05)
