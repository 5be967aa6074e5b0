"""The measured laps of a race car through wheel_slip: its accelerometer follows the wheels more than a second late.

The speed of the file is the truth. The wheels are those of the file over the nominal radii of the vehicle file, which
are wrong by 1.3 %.
"""

from pathlib import Path

import numpy as np

from benchmarks.measured_data import INDY_AV21
from benchmarks.rows import Row, at_least, at_most
from benchmarks.slip.following import shipped
from friction_adapter.map_file import load_map
from friction_bags.importers.table import Table
from vehicle_models.nanoseconds import NANOSECONDS
from wheel_slip.estimate import Reason
from wheel_slip.estimator import SlipEstimator
from wheel_slip.speed_sample import SpeedSample

_WHEELS = ("wheel_fl(kmph)", "wheel_fr(kmph)", "wheel_rl(kmph)", "wheel_rr(kmph)")
_KMH = 1.0 / 3.6
_MOVES = 5.0
"""[m/s] slower samples are not judged."""
_LARGEST_Z = 1.5
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
        {**said, "quantity": "RMS of z", **at_most(float(np.sqrt(np.mean(z**2))), _LARGEST_Z)},
        {**said, "quantity": "coverage of 95 %", **at_least(float(np.mean(np.abs(z) < 1.96)), _LEAST_COVERED)},
    ]
