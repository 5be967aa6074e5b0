"""Consistency of the stated deviations of speed and slip: drives of random cars, and measured laps of a race car.

The race car's accelerometer follows the wheels more than a second late. The speed of the file is the truth; the wheels
are those of the file over the nominal radii of the vehicle file, which are wrong by 1.3 %.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.engine import results_of
from benchmarks.measured import INDY_AV21
from benchmarks.runner import Row, at_least, at_most, not_judged
from benchmarks.slip.car_drives import cases, drive, ordinary_drive
from benchmarks.slip.recorded_drive import LEAST_SPEED, covered, estimates
from benchmarks.slip.stops import shipped
from corner_sim.car.recording import Recording
from friction_adapter.map_file import load_map
from friction_bags.importers.table import Table
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Vehicle
from wheel_slip.estimate import SpeedSample
from wheel_slip.estimator import EstimatorParameters, SlipEstimator

_WHEELS = ("wheel_fl(kmph)", "wheel_fr(kmph)", "wheel_rl(kmph)", "wheel_rr(kmph)")
_KMH = 1.0 / 3.6
_MOVES = 5.0
"""[m/s] slower samples are not judged."""
_LARGEST_Z_OF_LAPS = 1.5
_LEAST_COVERED = 0.9


def laps_rows(path: Path) -> list[Row]:
    """Drive the laps with the file's speed as that of a sensor, and without; two rows each."""
    return [row for sensor in (True, False) for row in _rows(path, sensor)]


def _rows(path: Path, sensor: bool) -> list[Row]:
    estimator = SlipEstimator(INDY_AV21, shipped().estimator)
    variance = shipped().speed_sensor.stddev ** 2
    radii = np.array(INDY_AV21.radii)
    errors: list[float] = []
    deviations: list[float] = []
    moving = 0
    for row in Table(path, load_map("iac")).rows():
        stamp, speed = round(row["time(s)"] * NANOSECONDS), row["vx(m/s)"]
        wheels = np.array([row[column] for column in _WHEELS]) * _KMH / radii
        measured = [SpeedSample(stamp, speed, variance)] if sensor else []
        estimate = estimator.update(stamp, wheels.tolist(), row["ax(m/s^2)"], measured)[0]
        moving += speed > _MOVES
        if speed > _MOVES and estimate.reason is Reason.OK:
            errors.append(estimate.vehicle_speed - speed)
            deviations.append(estimate.vehicle_speed_variance**0.5)
    z = np.array(errors) / np.array(deviations)
    said = {
        "case": f"laps of a race car, {'with' if sensor else 'without'} its speed sensor",
        "method": "wheel_slip",
        "speed_rms": float(np.sqrt(np.mean(np.square(errors)))),
        "valid": len(errors) / moving,
    }
    return [
        {**said, "quantity": "RMS of z", **at_most(float(np.sqrt(np.mean(z**2))), _LARGEST_Z_OF_LAPS)},
        {**said, "quantity": "coverage of 95 %", **at_least(float(np.mean(np.abs(z) < 1.96)), _LEAST_COVERED)},
    ]


Array = NDArray[np.float64]
_LEAST_Z, _LARGEST_Z = 0.4, 1.3
"""Range of the RMS of the error over its deviation [-]: below it the deviation says too little, above it is wrong."""
_LEAST_COVERAGE = 90.0


@dataclass(frozen=True)
class Judged:
    """Errors over the samples with a valid slip, of the speed in reverse too, and what was stated for them."""

    speed: Array
    """Error of the speed [m/s], (N,)."""
    speed_deviation: Array
    """[m/s], (N,)"""
    slip: Array
    """Errors of the valid slips [-], (M,)."""
    slip_deviation: Array
    """[-], (M,)"""
    valid: float
    """Share of valid slips [%]."""


def consistency_rows(vehicle: Vehicle, parameters: EstimatorParameters, seeds: Sequence[int]) -> list[Row]:
    """Return the rows of all drives, each with one car for each seed."""
    jobs = [(name, vehicle, parameters, seed) for name in cases() for seed in seeds]
    judged = results_of(_of_case, jobs, "drives")
    rows: list[Row] = []
    for k, name in enumerate(cases()):
        rows += case_rows(name, judged[k * len(seeds) : (k + 1) * len(seeds)])
    ordinary = [(vehicle, parameters, seed) for seed in range(seeds[0], seeds[0] + 8 * len(seeds))]
    return rows + case_rows("ordinary driving", results_of(_of_ordinary, ordinary, "ordinary driving"))


def _of_case(job: tuple[str, Vehicle, EstimatorParameters, int]) -> Judged:
    name, vehicle, parameters, seed = job
    case = cases()[name]
    of_wheels = replace(parameters.wheel_filter, edges=case.edges, missing_teeth=case.missing_teeth)
    if case.edges:
        vehicle = replace(vehicle, wheels=tuple(replace(each, encoder_teeth=case.teeth) for each in vehicle.wheels))
    return judge(drive(case, vehicle, seed), vehicle, replace(parameters, wheel_filter=of_wheels))


def _of_ordinary(job: tuple[Vehicle, EstimatorParameters, int]) -> Judged:
    vehicle, parameters, seed = job
    return judge(ordinary_drive(seed), vehicle, parameters)


def judge(run: Recording, vehicle: Vehicle, parameters: EstimatorParameters) -> Judged:
    """Follow a recording without a speed sensor and compare with the truth."""
    estimator = SlipEstimator(vehicle, parameters)
    speeds, slips = [], []
    valid = 0
    for answers, speed, slip in zip(estimates(estimator, run, vehicle), run.speed, run.slip, strict=True):
        found = [
            (answer.slip - true, answer.slip_variance)
            for answer, true in zip(answers, slip, strict=True)
            if not answer.reason
        ]
        valid += len(found)
        # In reverse there is a speed, and no slip.
        if (found or (speed < 0.0 and isfinite(answers[0].vehicle_speed))) and abs(speed) > LEAST_SPEED:
            speeds.append((answers[0].vehicle_speed - speed, answers[0].vehicle_speed_variance))
            slips += found
    of_speed, of_slip = np.reshape(speeds, (-1, 2)), np.reshape(slips, (-1, 2))
    return Judged(
        of_speed[:, 0], np.sqrt(of_speed[:, 1]), of_slip[:, 0], np.sqrt(of_slip[:, 1]), 100.0 * valid / run.slip.size
    )


def case_rows(case: str, runs: Sequence[Judged]) -> list[Row]:
    """Return the rows of one kind of drive: what has to hold of all its runs together."""
    error = np.concatenate([run.speed for run in runs])
    z = error / np.concatenate([run.speed_deviation for run in runs])
    slip_z = np.concatenate([run.slip / run.slip_deviation for run in runs])
    start = {"case": case, "runs": len(runs)}
    if not error.size:
        return [{**start, "quantity": "valid [%]", **not_judged(0.0)}]
    spread = float(np.sqrt(np.mean(z**2)))
    of_slip = at_least(covered(slip_z), _LEAST_COVERAGE) if slip_z.size else not_judged(float("nan"))
    return [
        {**start, "quantity": "z of the speed, RMS", **at_most(spread, _LARGEST_Z)},
        {**start, "quantity": "z of the speed, RMS, not less", **at_least(spread, _LEAST_Z)},
        {**start, "quantity": "coverage of the speed [%]", **at_least(covered(z), _LEAST_COVERAGE)},
        {**start, "quantity": "coverage of the slip [%]", **of_slip},
        {**start, "quantity": "speed RMS [m/s]", **not_judged(float(np.sqrt(np.mean(error**2))))},
        {**start, "quantity": "valid [%]", **not_judged(float(np.mean([run.valid for run in runs])))},
    ]
