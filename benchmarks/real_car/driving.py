"""Ordinary driving of random cars: no peak is passed, and none may be reported."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.real_car.answers import follow
from benchmarks.real_car.stops import ALARM
from benchmarks.rows import Row, at_most, not_judged
from benchmarks.run_lengths import run_lengths
from corner_sim.car.ordinary_driving import OrdinaryDriver
from corner_sim.car.random_car import random_car
from corner_sim.car.recording import Recording, record

DRIVE = 120.0
"""Length of a drive [s]; the hours are made of such drives, each of another car."""
LASTING = 0.05
"""Time for which P(beyond the peak) > 0.9 is a lasting alarm [s]."""


@dataclass(frozen=True)
class Drive:
    """A drive to make, with a random car."""

    seed: int
    road: str
    family: str
    method: str
    duration: float = DRIVE
    """[s]"""


@dataclass(frozen=True)
class DriveResult:
    """What was claimed in a drive, which never comes near the peak."""

    hours: float
    valid_peaks: int
    """Runs of valid messages, of all wheels."""
    lasting_alarms: int
    """Runs of P > 0.9 that last, of all wheels."""
    largest_slip: float
    """Largest slip of a tyre over its lambda_max, braking or driving."""


def record_drive(drive: Drive) -> Recording:
    """Drive; the estimator is not used."""
    # the drive has hills of its own: on snow no car with two driven wheels climbs more
    car = replace(random_car(drive.seed, drive.road, drive.family).parameters, slope=0.0)
    driver = OrdinaryDriver(car, drive.seed)
    return record(car, driver, drive.seed, speed=15.0, duration=drive.duration, surroundings=driver.surroundings)


def curves_of_drive(run: Recording, method: str) -> DriveResult:
    """Estimate the curves of a drive and count what is claimed."""
    found = follow(method, run, len(run.time))
    lasting = round(LASTING * run.parameters.sensors.sample_rate)
    return DriveResult(
        hours=float(run.time[-1]) / 3600.0,
        valid_peaks=len(run_lengths(found.valid == 1.0)),
        lasting_alarms=int(np.sum(run_lengths(found.probability_beyond_peak > ALARM) > lasting)),
        largest_slip=float(np.abs(run.tyre_slip / run.lambda_max).max()),
    )


def drive_rows(results: Sequence[DriveResult]) -> list[Row]:
    """Rows of all drives."""
    start = {"case": "ordinary driving", "road": "all", "stops": len(results)}
    hours = sum(result.hours for result in results)
    return [
        start | {"quantity": "valid peaks"} | at_most(sum(result.valid_peaks for result in results), 0),
        start | {"quantity": "lasting alarms"} | at_most(sum(result.lasting_alarms for result in results), 0),
        start | {"quantity": "hours"} | not_judged(hours),
        start
        | {"quantity": "largest slip over lambda_max"}
        | not_judged(max(result.largest_slip for result in results)),
    ]
