"""Stops of a car on two axles from 30 m/s with the supervisor in the loop, followed by wheel_slip.

The car cruises first (the engine holds the speed on the slope), then the driver demands 1.5 times the peak torque,
split between the wheels in proportion to their gains. Every wheel has its own detector of votes and supervisor, with
the shipped parameters. Its states command the brake without the intervention: the stops are manoeuvres with strong slip
for the estimators, no result about the supervisor. Sensor noise is drawn per run from its seed.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_supervisor.state_machine import COMMANDS, StateMachine
from benchmarks.abs.controllers import shipped as shipped_supervisor
from benchmarks.abs.panic_stop import DEMAND_RATIO
from benchmarks.measured import BMW_M8
from benchmarks.protocol import ACCELERATION_OFFSET, ACCELERATION_STDDEV, DT, SPEED, STEP
from corner_sim.car.driving import peak_pressures
from corner_sim.car.tyres import TYRES
from corner_sim.car_plant import CarModelParameters, CarPlant, SensorErrors, as_it_is, in_order
from corner_sim.driver import FOLLOWING
from corner_sim.road import Road
from corner_sim.sensors import CHAPTER_NOISE
from friction_adapter.map_file import load_map
from friction_bags.importers.table import Table
from friction_runtime.messages import to_nanoseconds
from friction_slope.detector import SlopeDetector
from friction_slope.estimate import Method, SlopeSample
from vehicle_models.brake_actuator import ActuatorParameters
from vehicle_models.constants import GRAVITY
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import Vehicle, four_wheels
from vehicle_models.vehicle_file import load_vehicle
from vehicle_models.wheel_forces import drag
from wheel_slip.estimator import SlipEstimator
from wheel_slip.parameters import SHIPPED, WheelSlipParameters
from wheel_slip.ros.processor import VEHICLE_SPEED, VEHICLE_VELOCITY, CarProcessor

Array = NDArray[np.float64]

CAR = load_vehicle("compact_car")
CRUISE = 10.0
"""Time before the brake onset [s]."""
END_SPEED = 3.0
"""[m/s]"""
GRADE = 0.02
"""Road slope [-], uphill for even seeds and downhill for odd ones."""
_NO_RELAXATION = 1e-3
"""[m] Tyres that relax and an accelerometer that pitches are left to the drives: with 0.3 m this control of the brakes,
which has no envelope, takes 30 s for a stop on snow."""
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
    """Brake once for each seed.

    Args:
        name: of the road.
        seeds: of the noise.
        grade_step: change of road slope half a braking time (by peak friction) after the onset.
        vehicle: the car, of four wheels; arrays per wheel are in the order of `four_wheels`.
        progress: called after each run with 1.

    Raises:
        ValueError: the car has not four wheels, or its rear wheels are not driven.
    """
    found = []
    for seed in seeds:
        found.append(_stop(name, seed, grade_step, cruising(vehicle)))
        progress(1)
    return found


def cruising(vehicle: Vehicle) -> Vehicle:
    """Return a car that can cruise, its wheels in the order of the plant.

    Raises:
        ValueError: the car has not four wheels, or its rear wheels are not driven.
    """
    ordered = in_order(vehicle)
    if not all(wheel.driven for wheel in ordered.wheels[2:]):
        raise ValueError(f"the rear wheels of '{vehicle.name}' are not driven ('driven'): it cannot cruise")
    return ordered


def _stop(name: str, seed: int, grade_step: float, vehicle: Vehicle) -> Stop:
    vehicle = replace(
        vehicle,
        wheels=tuple(replace(wheel, relaxation_length=_NO_RELAXATION) for wheel in vehicle.wheels),
        accelerometer=replace(vehicle.accelerometer, pitch_gain=0.0),
    )
    tyre = TYRES["burckhardt"][name]
    slope = GRADE if seed % 2 == 0 else -GRADE
    resistance = float(drag(vehicle, SPEED)) / vehicle.mass + GRAVITY * (slope + vehicle.rolling_resistance)
    parameters = CarModelParameters(
        slope=slope,
        hill=grade_step,
        hill_distance=SPEED * CRUISE + 0.375 * SPEED**2 / (GRAVITY * tyre.peak[1]),
        hill_length=0.1,
        drive_speeds=(SPEED + FOLLOWING * resistance,),
        drive_times=(0.0,),
        acceleration_delay=vehicle.accelerometer.delay,
    )
    errors = SensorErrors(CHAPTER_NOISE, ACCELERATION_STDDEV**2, ACCELERATION_OFFSET, seed)
    plant = CarPlant(vehicle, Road((name,), (0.0,)), parameters, ActuatorParameters(), errors, SPEED)
    gains = np.array([wheel.brake_gain for wheel in vehicle.wheels])
    peaks = np.array(peak_pressures(as_it_is(vehicle, tyre, parameters, errors)))
    demand = DEMAND_RATIO * float(gains @ peaks / gains.sum())
    controllers = _controllers(vehicle)
    onset = round(CRUISE / DT)
    wheel_speed: list[Array] = []
    acceleration: list[float] = []
    speed: list[float] = []
    slip: list[Array] = []
    for k in range(_LONGEST):
        sample = plant.sample()
        if sample.speed <= END_SPEED:
            break
        measured = plant.measure(sample)
        wheel_speed.append(measured.wheel_speed)
        acceleration.append(measured.acceleration)
        speed.append(sample.speed)
        slip.append(sample.slip)
        commands = np.zeros(len(controllers), dtype=np.int64)
        if k >= onset - _WARM_UP:
            torque = measured.brake_pressure * gains
            for i, controller in enumerate(controllers):
                commands[i] = controller.command((k + 1) * STEP, measured.wheel_speed[i], torque[i], k >= onset)
        plant.advance(demand if k >= onset else 0.0, commands)
    return Stop(onset, np.stack(wheel_speed), np.array(acceleration), np.array(speed), np.stack(slip))


class _Controller:
    """The shipped algorithms of vote and abs_supervisor of one wheel."""

    def __init__(self, detector: SlopeDetector, supervisor: StateMachine) -> None:
        self._detector = detector
        self._supervisor = supervisor

    def command(self, stamp: int, wheel_speed: float, torque: float, braking: bool) -> int:
        """Pass one sample through; return the command for it."""
        estimate = self._detector.update(SlopeSample(stamp, float(wheel_speed), float(torque)))
        self._supervisor.update(stamp, estimate.h, estimate.indicator, braking, isfinite(estimate.indicator))
        return int(COMMANDS[self._supervisor.state])


def _controllers(vehicle: Vehicle) -> list[_Controller]:
    slope, supervisor = shipped_supervisor()
    voting = slope.vote.detector(slope.detector)
    return [
        _Controller(
            SlopeDetector(vehicle.corner(wheel.name), Method.NO_SLIP, voting, slope.vote.no_slip),
            StateMachine(supervisor.thresholds, supervisor.tolerance),
        )
        for wheel in vehicle.wheels
    ]


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
                outputs += [answer for topic, answer in processor.process(name, message) if topic != VEHICLE_SPEED]
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
