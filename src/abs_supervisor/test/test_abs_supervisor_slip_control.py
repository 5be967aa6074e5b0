"""Slip control on the identified curve: closed forms, bounds, symmetry, and whatever inputs may come."""

from math import inf, isfinite, nan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abs_supervisor.brake_model import BrakeModel
from abs_supervisor.measurements import Measurements
from abs_supervisor.road_curve import RoadCurve, curve_through
from abs_supervisor.slip_control import (
    SlipController,
    followed_disturbance,
    nearest_command,
    slip_set_point,
    steady_torque,
    torque_set_point,
)
from abs_supervisor.wheel_observer import WheelObserver, WheelState, slip_of, wheel_step
from corner_sim.corner import SingleCorner
from vehicle_models import burckhardt
from vehicle_models.brake_actuator import ActuatorParameters, BrakeActuator, Command
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
    assert followed_disturbance(40.0, 40.0, 800.0) == pytest.approx(40.0)
    assert followed_disturbance(40.0 + 190.0, 40.0, 800.0) == pytest.approx(40.0)
    assert followed_disturbance(40.0 + 300.0, 40.0, 800.0) == pytest.approx(40.0 + 200.0)
    assert followed_disturbance(40.0 - 500.0, 40.0, 800.0) == pytest.approx(40.0 - 500.0)


@given(st.floats(-1e4, 1e4), st.floats(0.0, 1e4))
def test_no_more_is_followed_than_there_is(disturbance: float, steady: float) -> None:
    followed = followed_disturbance(disturbance, 0.0, steady)
    assert 0.0 <= followed / disturbance <= 1.0 if disturbance else followed == 0.0


@given(st.floats(0.0, 3000.0), st.floats(0.0, 3000.0), st.floats(0.0, 3000.0))
def test_the_demand_is_the_ceiling(wanted: float, torque: float, demand: float) -> None:
    command = nearest_command(wanted, torque, demand)
    if wanted >= demand or torque > demand:
        assert command is Command.INCREASE  # which is the driver's own pressure
    elif command is Command.INCREASE:
        assert wanted > torque or wanted >= demand - 20.0


def test_a_torque_within_the_band_is_held() -> None:
    assert nearest_command(500.0, 490.0, 900.0) is Command.HOLD
    assert nearest_command(500.0, 470.0, 900.0) is Command.INCREASE
    assert nearest_command(500.0, 530.0, 900.0) is Command.DECREASE


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


# the whole law


class Loop:
    """A wheel whose road is known, under the controller alone."""

    def __init__(self, name: str, speed: float = 30.0) -> None:
        self.curve, self._theta = road(name), surface(name)
        self.model = BrakeModel(ACTUATOR)
        self.controller = SlipController(CORNER, ACTUATOR, self.model)
        self.plant, self._brake = SingleCorner(CORNER, [speed]), BrakeActuator(1, DT)
        self._torque, self._stamp = np.zeros(1), 0

    def step(self, demand: float) -> Command:
        self._stamp += STEP
        plant, torque = self.plant, float(self._torque[0])
        self.model.update(self._stamp, torque, obeys=False)
        slip, speed = float(plant.slip[0]), float(plant.speed[0])
        measured = Measurements(float(plant.wheel_speed[0]), torque, demand, slip=slip, car_speed=speed)
        self.controller.observe(self._stamp, measured, self.curve)
        asked = self.controller.ask(slip, demand, self.curve, seen=True)
        self.model.order(self._stamp, asked, demand)
        after = self._brake.step(demand, int(asked))
        plant.step(self._torque, after, self._theta, DT)
        self._torque = after
        return asked


@pytest.mark.parametrize("name", TABLE_8_1)
def test_with_everything_known_the_slip_is_held_and_no_wheel_locks(name: str) -> None:
    loop = Loop(name)
    slips, speeds = [], []
    while loop.plant.speed[0] > 1.5:
        speeds.append(float(loop.plant.speed[0]))
        loop.step(1.5 * float(CORNER.peak_torque(surface(name))))
        slips.append(float(loop.plant.slip[0]))
    held = np.array(slips)[(np.array(speeds) > 8.0) & (np.array(speeds) < 24.0)]
    lambda_max = road(name).lambda_max
    assert held.mean() == pytest.approx(0.92 * lambda_max, rel=0.05)
    assert held.max() < 1.3 * lambda_max
    assert max(slips) < 0.9


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_below_the_peak_the_demand_passes_whatever_it_is(share: float) -> None:
    """Ordinary braking: the law asks for nothing but the driver's pressure."""
    loop = Loop("wet")
    demand = share * float(CORNER.peak_torque(surface("wet")))
    assert {loop.step(demand) for _ in range(400)} == {Command.INCREASE}


def test_at_the_end_of_a_stop_the_torque_is_kept_when_slip_is_unknown() -> None:
    """At 4 m/s it is enough to know what the road gives."""
    model = BrakeModel(ACTUATOR)
    controller, slip = SlipController(CORNER, ACTUATOR, model), 0.92 * DRY.lambda_max
    torque = 0.99 * steady_torque(CORNER, DRY, slip)
    asked = set()
    for k in range(1, 110):
        known = k < 100
        model.update(k * STEP, torque, obeys=False)
        wheel = 4.0 * (1.0 - slip) / CORNER.radius
        controller.observe(k * STEP, Measurements(wheel, torque, 2000.0, slip=slip, car_speed=4.0), DRY)
        command = controller.ask(slip if known else nan, 2000.0, DRY, seen=True)
        model.order(k * STEP, Command.HOLD, 2000.0)
        asked |= set() if known else {command}
    assert asked == {Command.HOLD}


NUMBERS = st.one_of(st.floats(-1e6, 1e6), st.sampled_from([nan, inf, -inf, 0.0]))
ROWS = st.tuples(
    st.integers(1, 10 * STEP),
    st.floats(-10.0, 400.0),
    st.floats(-1e6, 1e6),
    NUMBERS,
    NUMBERS,
    st.floats(0.0, 1e4),
    st.sampled_from(TABLE_8_1),
    st.booleans(),
)


@settings(max_examples=150, deadline=None)
@given(st.lists(ROWS, max_size=40))
def test_whatever_comes_the_law_answers_with_a_command(rows: list[tuple]) -> None:
    model = BrakeModel(ACTUATOR)
    controller, stamp = SlipController(CORNER, ACTUATOR, model), 0
    for ahead, wheel, speed, slip, torque, demand, name, seen in rows:
        stamp += ahead
        model.update(stamp, torque, obeys=True)
        controller.observe(stamp, Measurements(wheel, torque, demand, slip=slip, car_speed=speed), road(name))
        asked = controller.ask(slip, demand, road(name), seen)
        assert isinstance(asked, Command)
        assert not controller.torque_set_point > demand
        model.order(stamp, asked, demand)


def test_the_observer_finds_a_torque_that_the_curve_does_not_explain() -> None:
    """The road gives 10 % more than the curve says: that is the disturbance torque."""
    theta = np.asarray(surface("dry"), dtype=np.float64)
    weak = RoadCurve(DRY.theta_1 / 1.1, DRY.theta_2, DRY.theta_3 / 1.1, DRY.lambda_max)
    torque = 0.8 * float(CORNER.peak_torque(theta))
    plant = SingleCorner(CORNER, [30.0])
    model = BrakeModel(ACTUATOR)
    observer = WheelObserver(CORNER, model)
    for sample in range(1, 120):
        model.order((sample - 3) * STEP, Command.HOLD, torque)
        observer.update(sample * STEP, float(plant.wheel_speed[0]), float(plant.speed[0]), torque, weak)
        plant.step(torque, torque, theta, DT)
    missing = (
        CORNER.radius * CORNER.vertical_load * (float(plant.friction(theta)[0]) - weak.friction(float(plant.slip[0])))
    )
    assert observer.disturbance == pytest.approx(missing, rel=0.05)
