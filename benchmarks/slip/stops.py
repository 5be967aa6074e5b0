"""Stops of a car on two axles from 30 m/s with the supervisor in the loop, followed by wheel_slip.

The car cruises first (the engine holds the speed on the slope), then the driver demands 1.5 times the peak torque,
split between the wheels in proportion to their gains. Every wheel has its own detector of votes and supervisor, with
the shipped parameters. Its states command the brake without the envelope: the stops are manoeuvres with strong slip for
the estimators, no result about the supervisor. Sensor noise is drawn per run from its seed.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path
from statistics import fmean

import numpy as np
from numpy.typing import NDArray

from abs_supervisor.fsm import COMMANDS
from abs_supervisor.supervisor import Evidence, Supervisor
from benchmarks.abs.controllers import shipped as shipped_supervisor
from benchmarks.abs.panic_stop import DEMAND_RATIO
from benchmarks.measured import BMW_M8
from benchmarks.protocol import ACCELERATION_STDDEV, DT, SPEED, STEP
from corner_sim.sensors import CHAPTER_NOISE
from corner_sim.two_axle import TwoAxleCar, peak_torque, split_torque
from friction_adapter.map_file import load_map
from friction_bags.importers.table import Table
from friction_runtime.messages import to_nanoseconds
from friction_slope.detector import SlopeDetector
from friction_slope.estimate import Method, SlopeSample
from vehicle_models import burckhardt
from vehicle_models.brake_actuator import ActuatorParameters, BrakeActuator
from vehicle_models.constants import GRAVITY
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.surfaces import surface
from vehicle_models.vehicle import Vehicle, four_wheels
from vehicle_models.vehicle_file import load_vehicle
from vehicle_models.wheel_forces import drag
from wheel_slip.estimator import SlipEstimator
from wheel_slip.parameters import SHIPPED, WheelSlipParameters
from wheel_slip.ros.processor import VEHICLE_VELOCITY, CarProcessor

Array = NDArray[np.float64]

CAR = load_vehicle("compact_car")
CRUISE = 10.0
"""Time before the brake onset [s]."""
END_SPEED = 3.0
"""[m/s]"""
ACCELERATION_OFFSET = 0.15
"""[m/s^2]"""
GRADE = 0.02
"""Road slope [-], uphill for even seeds and downhill for odd ones."""
_WARM_UP = 40
"""Samples the detectors see before the brake onset."""
_LONGEST = 12_000
"""Samples after which a stop is given up: one minute."""


@dataclass
class Stop:
    """One run: sensors and truth at every sample, n of them, until the end speed."""

    onset: int
    """Index of the first sample with brake demand."""
    wheel_speed: Array
    """Measured [rad/s], shape (n, 4)."""
    acceleration: Array
    """Measured [m/s^2], shape (n,)."""
    torque: Array
    """Brake torque [N m], true, shape (n, 4)."""
    speed: Array
    """True [m/s], shape (n,)."""
    slip: Array
    """True [-], shape (n, 4)."""


def stops(
    name: str,
    seeds: range,
    *,
    grade_step: float = 0.0,
    vehicle: Vehicle = CAR,
    progress: Callable[[int], None] = lambda _done: None,
) -> list[Stop]:
    """Brake once for each seed, side by side.

    Args:
        name: of the road.
        seeds: of the noise.
        grade_step: change of road slope half a braking time (by peak friction) after the onset.
        vehicle: the car, of four wheels; arrays per wheel are in the order of `four_wheels`. Its accelerometer is as
            late as it says, in whole samples.
        progress: called with the number of runs that have just ended.

    Raises:
        ValueError: the car has not four wheels, or none is driven.
    """
    count, theta = len(seeds), surface(name)
    grade = np.where(np.array(seeds) % 2 == 0, GRADE, -GRADE)
    wheels = four_wheels(vehicle)
    car = TwoAxleCar(vehicle, np.full(count, SPEED), grade=np.arctan(grade))
    demand = DEMAND_RATIO * split_torque(vehicle, np.asarray(peak_torque(vehicle, theta).sum()))
    actuators = [BrakeActuator(count, DT, ActuatorParameters()) for _ in wheels]
    controllers = _controllers(count, vehicle)
    generators = [np.random.default_rng(seed) for seed in seeds]
    onset = round(CRUISE / DT)
    step_at = onset + round(0.5 * SPEED / (GRAVITY * float(burckhardt.peak(theta)[1])) / DT)
    cruise = cruise_torque(vehicle, grade)
    torque: Array = np.zeros((count, len(wheels)))
    kept: list[list[Array]] = [[] for _ in range(5)]
    ends = np.full(count, -1)
    for k in range(_LONGEST):
        if k == step_at:
            car.grade = np.arctan(grade + grade_step)
        draws = np.stack([generator.standard_normal(9) for generator in generators])
        measured = car.wheel_speed + np.sqrt(CHAPTER_NOISE.wheel_speed_variance) * draws[:, :4]
        acceleration = car.specific_force(theta) + ACCELERATION_OFFSET + ACCELERATION_STDDEV * draws[:, 4]
        for store, values in zip(kept, (measured, acceleration, torque, car.speed, car.slip), strict=True):
            store.append(values.copy())
        ended = (ends < 0) & (car.speed <= END_SPEED)
        ends[ended] = k
        progress(int(ended.sum()))
        if np.all(ends >= 0):
            break
        commands = np.zeros((count, len(wheels)), dtype=np.int64)
        if k >= onset - _WARM_UP:
            felt = torque + np.sqrt(CHAPTER_NOISE.torque_variance) * draws[:, 5:]
            for i in np.flatnonzero(ends < 0).tolist():
                for j, controller in enumerate(controllers[i]):
                    commands[i, j] = controller.command((k + 1) * STEP, measured[i, j], felt[i, j], k >= onset)
        demanded = demand if k >= onset else np.zeros(len(wheels))
        after = np.stack([actuators[j].step(demanded[j], commands[:, j]) for j in range(len(wheels))], axis=1)
        car.step(torque, after, theta, DT, cruise if k < onset else 0.0)
        torque = after
    late = round(vehicle.accelerometer.delay / DT)
    kept[1] = [kept[1][0]] * late + kept[1][: len(kept[1]) - late]
    arrays = [np.stack(store) for store in kept]
    return [Stop(onset, *(array[: end if end >= 0 else None, i] for array in arrays)) for i, end in enumerate(ends)]


class _Controller:
    """The shipped algorithms of vote and abs_supervisor of one wheel."""

    def __init__(self, detector: SlopeDetector, supervisor: Supervisor) -> None:
        self._detector = detector
        self._supervisor = supervisor

    def command(self, stamp: int, wheel_speed: float, torque: float, braking: bool) -> int:
        """Pass one sample through; return the command for it."""
        estimate = self._detector.update(SlopeSample(stamp, float(wheel_speed), float(torque)))
        evidence = Evidence(estimate.h, estimate.indicator, isfinite(estimate.indicator), False, braking)
        self._supervisor.update(stamp, evidence)
        return int(COMMANDS[self._supervisor.state])


def _controllers(count: int, vehicle: Vehicle) -> list[list[_Controller]]:
    slope, supervisor = shipped_supervisor()
    voting = slope.vote.detector(slope.detector)
    return [
        [
            _Controller(
                SlopeDetector(vehicle.corner(wheel.name), Method.NO_SLIP, voting, slope.vote.no_slip),
                Supervisor(supervisor.thresholds, supervisor.tolerance),
            )
            for wheel in four_wheels(vehicle)
        ]
        for _ in range(count)
    ]


def cruise_torque(vehicle: Vehicle, grade: Array) -> Array:
    """Drive torque [N m] that holds SPEED on the slope.

    Raises:
        ValueError: no wheel is driven.
    """
    driven = [wheel.radius for wheel in vehicle.wheels if wheel.driven]
    if not driven:
        raise ValueError(f"no wheel of '{vehicle.name}' is driven ('driven'): it cannot cruise")
    weight = vehicle.mass * GRAVITY
    resistance = drag(vehicle, SPEED) + weight * (np.sin(np.arctan(grade)) + vehicle.rolling_resistance)
    return np.asarray(fmean(driven) * resistance)


BMW_STOP = (6.9, 9.0)
"""The stop in the file's time [s]."""
_BMW_WHEELS = ("w_fl_radps", "w_fr_radps", "w_rl_radps", "w_rr_radps")
"""Columns of the wheel speeds."""


@dataclass(frozen=True)
class Followed:
    """Errors of one run, n samples from brake onset to the end speed."""

    speed: Array
    """Error of the speed [m/s], shape (n,)."""
    deviation: Array
    """Standard deviation the estimator gives for it [m/s], shape (n,)."""
    slip: Array
    """Error of the slip [-], shape (n, wheels)."""
    valid: float
    """Share of valid slips."""
    best_wheel_speed: Array
    """Error of the baseline's speed [m/s], shape (n,)."""
    best_wheel_slip: Array
    """Error of the baseline's slip [-], shape (n, wheels)."""


def shipped() -> WheelSlipParameters:
    """Return the shipped parameters."""
    parameters: WheelSlipParameters = SHIPPED["wheel_slip"].parameters
    return parameters


def follow(stop: Stop, vehicle: Vehicle = CAR, advance: Callable[[int], None] = lambda _done: None) -> Followed:
    """One stop of a car through the estimator; `advance` is called once, at the end."""
    wheels_of_car = four_wheels(vehicle)
    estimator = SlipEstimator(replace(vehicle, wheels=wheels_of_car), shipped().estimator)
    found: list[tuple[float, float]] = []
    wheels: list[list[float]] = []
    valid = 0
    for k, (measured, acceleration) in enumerate(zip(stop.wheel_speed, stop.acceleration, strict=True)):
        estimates = estimator.update((k + 1) * STEP, measured.tolist(), float(acceleration))
        if k >= stop.onset:
            found.append((estimates[0].vehicle_speed, estimates[0].vehicle_speed_variance))
            wheels.append([estimate.wheel_speed for estimate in estimates])
            valid += sum(not estimate.reason for estimate in estimates)
    advance(1)
    braked = slice(stop.onset, None)
    radii = np.array([wheel.radius for wheel in wheels_of_car])
    return _compare(
        np.array(found), np.array(wheels), stop.wheel_speed[braked], radii, stop.speed[braked], stop.slip[braked], valid
    )


def follow_bmw(path: Path, offset: float = 0.0) -> Followed:
    """The measured stop through the wheel processor, without the reference speed, which gives the true slip."""
    processor = CarProcessor(BMW_M8, shipped())
    found: list[tuple[float, float]] = []
    wheels: list[list[float]] = []
    measured: list[list[float]] = []
    truth: list[float] = []
    valid = 0
    signal_map = load_map("bmw")
    table = Table(path, signal_map)
    for row in table.rows():
        stamp = round(row["t_s"] * NANOSECONDS) + signal_map.stamp_offset
        outputs = []
        for name, message in table.of_row(row):
            if name == "imu/data":
                message.linear_acceleration.x += offset
            if name in processor.sensors and name != VEHICLE_VELOCITY:
                outputs += [answer for _, answer in processor.process(name, message)]
        inside = BMW_STOP[0] <= row["t_s"] <= BMW_STOP[1] and row["vx_mps"] > END_SPEED
        if inside and outputs and to_nanoseconds(outputs[0].header.stamp) == stamp:
            found.append((outputs[0].vehicle_speed, outputs[0].vehicle_speed_stddev ** 2))
            wheels.append([output.wheel_speed for output in outputs])
            measured.append([row[column] for column in _BMW_WHEELS])
            truth.append(row["vx_mps"])
            valid += sum(output.validity.valid for output in outputs)
    speed, radii = np.array(truth), np.array(BMW_M8.radii)
    slip = 1.0 - np.array(measured) * radii / speed[:, np.newaxis]
    return _compare(np.array(found), np.array(wheels), np.array(measured), radii, speed, slip, valid)


def _compare(
    found: Array, wheels: Array, measured: Array, radii: Array, speed: Array, slip: Array, valid: int
) -> Followed:
    best = (measured * radii).max(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        # With all wheels locked the baseline has no slip; it counts as zero.
        best_slip = np.where(best[:, np.newaxis] > 0.0, 1.0 - measured * radii / best[:, np.newaxis], 0.0)
    return Followed(
        speed=found[:, 0] - speed,
        deviation=np.sqrt(found[:, 1]),
        slip=1.0 - wheels * radii / found[:, :1] - slip,
        valid=valid / slip.size,
        best_wheel_speed=best - speed,
        best_wheel_slip=best_slip - slip,
    )
