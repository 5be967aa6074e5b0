"""One stop through wheel_slip with its shipped parameters, and the errors of speed and slip over it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.measured_data import BMW_M8
from benchmarks.protocol import STEP
from benchmarks.slip.stops import CAR, END_SPEED, Stop
from friction_adapter.map_file import load_map
from friction_bags.importers.table import Table
from friction_runtime.stamps import to_nanoseconds
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.two_axle import four_wheels
from vehicle_models.vehicle import Vehicle
from wheel_slip.estimator import SlipEstimator
from wheel_slip.parameters import SHIPPED, WheelSlipParameters
from wheel_slip.ros.processor import VEHICLE_VELOCITY, CarProcessor

Array = NDArray[np.float64]

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
            found.append((outputs[0].vehicle_speed, outputs[0].vehicle_speed_variance))
            wheels.append([output.wheel_speed for output in outputs])
            measured.append([row[column] for column in _BMW_WHEELS])
            truth.append(row["vx_mps"])
            valid += sum(output.valid for output in outputs)
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
