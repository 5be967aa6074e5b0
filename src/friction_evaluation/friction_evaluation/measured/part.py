"""Curves from measured data: whole-vehicle mode on a BMW stop and on laps of an Indy car, fits of tyre-rig sweeps.

See measured_data.py for where the data are.
"""

import argparse
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from rich.progress import track

from friction_curve_id.interface import CurveEstimate
from friction_curve_id.vehicle.vehicle_samples import VehicleSample
from friction_curve_id.vehicle.whole_vehicle import WholeVehicle
from friction_evaluation.measured.tyre_rig import estimate_columns, tyre_rig_rows
from friction_evaluation.measured_data import BMW, BMW_M8, IAC, INDY_AV21, TYRE_RIG, data_directory
from friction_evaluation.rows import Row
from vehicle_models.vehicle import Vehicle

_KMH = 1.0 / 3.6


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this part."""
    parser.add_argument("--data", type=Path, default=data_directory(), help="directory of the measured data")


def run(options: argparse.Namespace) -> list[Row]:
    """Return one row a car and one a bin of the tyre rig.

    Raises:
        SystemExit: a file is absent.
    """
    for name in (BMW, IAC, TYRE_RIG):
        if not (options.data / name).is_file():
            raise SystemExit(f"measured data are absent: {options.data / name} (give --data, or set FRICTION_DATA)")
    rows = [
        vehicle_row("BMW M8, ABS stop", bmw_samples(options.data / BMW), BMW_M8),
        vehicle_row("Indy AV-21, laps", iac_samples(options.data / IAC), INDY_AV21),
    ]
    return rows + tyre_rig_rows(options.data / TYRE_RIG)


def bmw_samples(path: Path) -> Iterator[VehicleSample]:
    """Samples of the BMW M8."""
    data = np.genfromtxt(path, delimiter=",", names=True)
    wheels = [data[f"w_{wheel}_radps"] for wheel in ("fl", "fr", "rl", "rr")]
    for time, speed, acceleration, *speeds in zip(data["t_s"], data["vx_mps"], data["ax_mps2"], *wheels, strict=True):
        yield VehicleSample(float(time), float(speed), float(acceleration), tuple(map(float, speeds)))


def iac_samples(path: Path) -> Iterator[VehicleSample]:
    """Samples of the Indy AV-21. The file holds rim speeds: the radius cancels in the slip."""
    data = np.genfromtxt(path, delimiter=",", names=True)
    names = zip(("fl", "fr", "rl", "rr"), INDY_AV21.radii, strict=True)
    wheels = [data[f"wheel_{wheel}kmph"] * _KMH / radius for wheel, radius in names]
    for time, speed, acceleration, *speeds in zip(data["times"], data["vxms"], data["axms2"], *wheels, strict=True):
        yield VehicleSample(float(time), float(speed), float(acceleration), tuple(map(float, speeds)))


def vehicle_row(name: str, samples: Iterator[VehicleSample], car: Vehicle) -> Row:
    """Feed the whole-vehicle estimator sample by sample: its last estimate, and how many of them were valid."""
    vehicle, reasons = WholeVehicle(car), Counter[str]()
    last: CurveEstimate | None = None
    best: CurveEstimate | None = None
    for sample in track(list(samples), description=name):
        answer = vehicle.update(sample)
        reasons[answer.reason.name.lower()] += 1
        if isinstance(answer, CurveEstimate):
            last = answer
            best = answer if answer.valid else best
    row: Row = {"data": "vehicle", "case": name}
    shown = best or last
    if shown is not None:
        row |= estimate_columns(shown)
    row["valid_estimates"] = reasons.pop("ok", 0)
    row["other_answers"] = ", ".join(f"{reason} {count}" for reason, count in reasons.most_common())
    return row
