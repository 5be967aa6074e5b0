"""The supervisor of one wheel on a plant of its own: no healthy brake is released, and a wheel that locks is."""

from math import exp, isfinite, nan
from typing import Any

import numpy as np
import pytest

from abs_supervisor.arbitration import Law
from abs_supervisor.curve_selector import CurveReport, Estimate
from abs_supervisor.intervention import Limit, Phase, Release
from abs_supervisor.measurements import Measurements
from abs_supervisor.road_curve import RoadCurve
from abs_supervisor.wheel_supervisor import WheelSupervisor
from vehicle_models import burckhardt
from vehicle_models.brake_actuator import ActuatorParameters, BrakeActuator, Command
from vehicle_models.surfaces import TABLE_8_1, surface
from vehicle_models.vehicle_file import load_vehicle

STEP, DT = 5_000_000, 0.005
CAR = load_vehicle("chapter_corner")
CORNER = CAR.corner("front_left")
WHEEL = CAR.wheel_names[0]


def curve(name: str, peak: float = nan) -> RoadCurve:
    """The curve of a road; with `peak` [-] one of its shape whose peak is there."""
    theta_1, theta_2, theta_3 = (float(value) for value in surface(name))
    true = float(burckhardt.peak(surface(name))[0])
    closer = true / peak if isfinite(peak) else 1.0
    return RoadCurve(theta_1, closer * theta_2, closer * theta_3, true / closer)


class Stop:
    """A corner that brakes: plant, hydraulics, and what the supervisor is told, right or wrong."""

    def __init__(self, road: str, share: float, by_curve: bool = True, speed: float = 25.0) -> None:
        """Brake with a `share` of the torque at the peak of a road."""
        self.supervisor = WheelSupervisor(WHEEL, CAR, ActuatorParameters(), by_curve=by_curve, obeyed=True)
        self.road, self.speed, self.wheel = curve(road), speed, speed / CORNER.radius
        self.demand = share * float(CORNER.peak_torque(surface(road)))
        self.torque, self.stamp = 0.0, 0
        self.told: RoadCurve | None = self.road
        self.slip_error, self.speed_error, self.frozen = 0.0, 1.0, False
        self.law = Command.INCREASE
        """What the state machine asks for."""
        self.others: list[float] = []
        self._brake, self._random = BrakeActuator(1, DT, ActuatorParameters()), np.random.default_rng(11)
        self.commands: list[Command] = []
        self.slips: list[float] = []

    @property
    def slip(self) -> float:
        return 1.0 - CORNER.radius * self.wheel / self.speed

    def step(self, demand: float | None = None, **seen: Any) -> Command:
        """Advance by a sample; values of `seen` replace those that are measured."""
        self.stamp += STEP
        demand = self.demand if demand is None else demand
        measured = self.wheel + 0.07 * float(self._random.standard_normal())
        speed = self.speed * self.speed_error
        slip = 1.0 - CORNER.radius * measured / speed + self.slip_error
        values = {"slip": slip, "slip_stddev": 0.004, "car_speed": speed, "car_speed_stddev": 0.1, **seen}
        torque = self.torque + 3.0 * float(self._random.standard_normal())
        if self.told is not None:
            # The estimator reports at every sample; a report counts 50 ms later.
            self.supervisor.curve.put(CurveReport(self.stamp, Estimate.VALID, self.told, 0.002, 0.0, 100, 0))
        self.supervisor.observe(self.stamp, Measurements(measured, torque, demand, self.others, **values))
        command = self.supervisor.decide(self.law if demand > 0.0 else Command.NONE)
        after = float(self._brake.step(demand, int(command))[0])
        self._drive(0.5 * (self.torque + after))
        self.torque = after
        self.commands.append(command)
        self.slips.append(self.slip)
        return command

    def _drive(self, torque: float) -> None:
        """Advance wheel and car by explicit steps that are short against the wheel's own time."""
        for _ in range(20):
            force = CORNER.vertical_load * self.road.friction(max(self.slip, 0.0))
            self.wheel += DT / 20 * (CORNER.radius * force - torque) / CORNER.inertia
            self.wheel = max(self.wheel, 0.0)
            self.speed = max(self.speed - DT / 20 * force / CORNER.mass, 0.2)

    def run(self, seconds: float, until: float = 3.0) -> list[Command]:
        """Roll for 0.5 s and brake; return the commands of the braking, down to a speed [m/s]."""
        for _ in range(100):
            self.step(0.0)
        self.commands.clear()
        self.slips.clear()
        for _ in range(round(seconds / DT)):
            if self.speed < until:
                break
            self.step()
        return self.commands


@pytest.mark.parametrize("by_curve", [True, False])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("road", TABLE_8_1)
def test_ordinary_braking_is_the_drivers_whatever_the_law_asks_for(road: str, share: float, by_curve: bool) -> None:
    stop = Stop(road, share, by_curve)
    stop.law = Command.INCREASE if by_curve else Command.DECREASE
    assert Command.DECREASE not in stop.run(3.0)
    assert stop.supervisor.intervention.phase is Phase.STANDBY
    assert stop.torque == pytest.approx(stop.demand, rel=0.02)


@pytest.mark.parametrize("road", TABLE_8_1)
def test_with_more_than_the_road_takes_the_slip_is_held_and_no_wheel_locks(road: str) -> None:
    stop = Stop(road, 1.5)
    stop.run(8.0, until=8.0)
    assert Command.DECREASE in stop.commands
    assert max(stop.slips) < 0.8
    assert np.mean(stop.slips[200:]) == pytest.approx(stop.road.lambda_max, rel=0.35)


WRONG: dict[str, dict[str, Any]] = {
    "slip too large by 0.3": {"slip_error": 0.3},
    "speed too high by 30 %": {"speed_error": 1.3},
    "peak at 0.04": {"told": 0.04},
}


@pytest.mark.parametrize("name", WRONG)
@pytest.mark.parametrize("share", [0.3, 0.6])
@pytest.mark.parametrize("road", TABLE_8_1)
def test_a_valid_and_wrong_input_releases_no_brake_of_a_wheel_that_keeps_its_slip(
    road: str, share: float, name: str
) -> None:
    stop, right = Stop(road, share), Stop(road, share)
    for field, value in WRONG[name].items():
        setattr(stop, field, curve(road, value) if field == "told" else value)
    assert Command.DECREASE not in stop.run(3.0)
    right.run(3.0)
    assert 25.0 - stop.speed > 0.9 * (25.0 - right.speed)


def test_a_law_that_always_asks_for_a_release_gets_none_before_the_wheel_slips() -> None:
    stop = Stop("dry", 0.8, by_curve=False)
    stop.law = Command.DECREASE
    stop.told = None
    stop.run(2.0)
    assert Command.DECREASE not in stop.commands
    assert stop.supervisor.intervention.refused == 1
    assert stop.supervisor.intervention.release is Release.REFUSED


def test_without_slip_a_wheel_that_dives_is_released_until_it_is_back() -> None:
    stop = Stop("dry", 2.0, by_curve=False)
    stop.law = Command.DECREASE
    for _ in range(100):
        stop.step(0.0, slip=nan, car_speed=nan)
    given = [stop.step(slip=nan, car_speed=nan) for _ in range(120)]
    first = given.index(Command.DECREASE)
    assert stop.slips[100 + first] < 0.6
    assert Command.DECREASE in given
    assert min(stop.slips[100 + first :]) < 0.3 or max(stop.slips) < 0.9


@pytest.mark.parametrize("road", ["wet", "snow"])
def test_where_the_slip_is_lost_the_slopes_sign_is_in_force_with_all_that_belongs_to_it(road: str) -> None:
    commands = []
    for by_curve in (True, False):
        stop = Stop(road, 1.5, by_curve)
        stop.told = None
        for _ in range(100):
            stop.step(0.0, slip=nan, car_speed=nan)
        for _ in range(500):
            stop.law = Command.DECREASE if stop.slip > 0.15 else Command.INCREASE
            stop.step(slip=nan, car_speed=nan)
        assert stop.supervisor.law is Law.SLOPE_SIGN
        commands.append(stop.commands)
    assert Command.DECREASE in commands[0]
    assert commands[0] == commands[1]


def test_a_release_that_does_not_help_spends_its_budget_and_the_pressure_returns_slowly() -> None:
    """The wheel stands and stays so: a brake that is open must let it turn."""
    stop = Stop("snow", 3.0, by_curve=False)
    stop.law = Command.DECREASE
    for _ in range(100):
        stop.step(0.0)
    limits = set()
    for _ in range(400):
        stop.step()
        stop.wheel = min(stop.wheel, 8.0)  # something else holds it
        limits.add(stop.supervisor.intervention.limit)
    assert Limit.NO_SPIN_UP in limits or Limit.BUDGET in limits
    assert Limit.RETURN in limits
    assert stop.supervisor.intervention.limited >= 1
    released = np.mean([each is Command.DECREASE for each in stop.commands[100:]])
    assert released < 0.75


def test_budget_is_spent_by_releases_and_refilled_by_time() -> None:
    stop, budgets = Stop("dry", 1.5), []
    for k in range(300):
        stop.step(0.0 if k < 100 else None)
        budgets.append(stop.supervisor.intervention.budget)
    assert set(budgets[:100]) == {1.0}
    assert min(budgets) < 0.98
    for _ in range(600):
        stop.step(0.0)
    assert stop.supervisor.intervention.budget == 1.0
    assert stop.supervisor.intervention.phase is Phase.STANDBY


def test_near_standstill_the_driver_has_the_brake() -> None:
    stop = Stop("dry", 0.5, speed=6.0)
    stop.run(3.0, until=1.2)
    stop.step()
    assert stop.commands[-1] is Command.NONE
    assert stop.supervisor.intervention.limit is Limit.LOW_SPEED


def test_all_wheels_that_lock_together_are_no_standstill() -> None:
    """Without a speed of the car: the fastest wheel is carried on at 12 m/s^2."""
    stop = Stop("snow", 3.0, by_curve=False)
    stop.law = Command.DECREASE
    stop.told = None
    for k in range(400):
        stop.others = [CORNER.radius * stop.wheel] * 3
        stop.step(0.0 if k < 100 else None, slip=nan, car_speed=nan)
    assert Command.DECREASE in stop.commands[100:180]


@pytest.mark.parametrize(("others", "slides"), [([3.0, 3.0, 0.3], True), ([3.0, 0.3, 0.3], False), ([3.0], False)])
def test_two_other_wheels_show_that_a_slow_wheel_of_unknown_slip_slides(others: list[float], slides: bool) -> None:
    supervisor = WheelSupervisor(WHEEL, CAR, ActuatorParameters(), by_curve=False, obeyed=True)
    supervisor.observe(STEP, Measurements(1.0, torque=100.0, demand=300.0, others=others))
    assert supervisor.car.slides == slides


def test_what_could_not_be_checked_is_named() -> None:
    supervisor = WheelSupervisor(WHEEL, CAR, ActuatorParameters(), by_curve=False, obeyed=True)
    supervisor.observe(STEP, Measurements(1.0, torque=100.0, demand=300.0))
    assert "whether a wheel that stands is locked" in supervisor.unchecked
    supervisor.observe(2 * STEP, Measurements(1.0, torque=100.0, demand=300.0, car_speed=0.3, slip=0.0))
    assert "locked" not in supervisor.unchecked
    assert "no friction curve" in supervisor.unchecked


def test_a_speed_from_the_wheels_alone_is_the_degraded_mode() -> None:
    supervisor = WheelSupervisor(WHEEL, CAR, ActuatorParameters(), by_curve=False, obeyed=True)
    for inertial in (True, False):
        supervisor.observe(STEP * (2 - inertial), Measurements(80.0, 0.0, 0.0, inertial=inertial))
        assert supervisor.degraded is not inertial


@pytest.mark.parametrize("ratio", [0.1, 0.3])
def test_a_tyre_that_gives_little_when_locked_does_not_stay_locked(ratio: float) -> None:
    """Its wheel takes its time to turn again: it is not dead."""
    stop = Stop("dry", 1.5)
    peak = stop.road.lambda_max

    class Falling(RoadCurve):
        """A curve that falls to a share of its peak at full slip."""

        def friction(self, slip: float) -> float:
            mu = super().friction(min(slip, peak))
            beyond = max(slip - peak, 0.0)
            return mu * (ratio + (1.0 - ratio) * exp(-beyond / 0.15))

    true = stop.road
    stop.road = Falling(true.theta_1, true.theta_2, true.theta_3, peak)
    stop.run(3.0, until=8.0)
    locked = np.array(stop.slips) > 0.95
    assert not stop.supervisor.plausibility.text
    longest = max((len(run) for run in "".join("x" if each else " " for each in locked).split()), default=0)
    assert longest * DT < 0.5
