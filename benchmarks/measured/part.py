"""Curves from measured data: whole-vehicle mode on a BMW stop and on laps of an Indy car, fits of tyre-rig sweeps.

The method `car` follows both logs as well. Neither holds what it needs: that of the BMW has the torque demanded of the
brakes ahead of the ABS valves instead of pressures, that of the Indy car a commanded line pressure without a known
gain. It must not be valid there. Every signal of the BMW stop is moved by 20 ms either way, too: the peak of the log as
it is has to stay in the interval, and `car` silent.

See measured_data.py for where the data are.
"""

import argparse
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.progress import track

from benchmarks.measured.tyre_rig import estimate_columns, tyre_rig_rows
from benchmarks.measured_data import BMW, BMW_M8, IAC, INDY_AV21, TYRE_RIG, data_directory
from benchmarks.rows import Row, at_most
from friction_curve_id.car import CarEstimator, CarEstimatorParameters, CarSample
from friction_curve_id.interface import CurveEstimate
from friction_curve_id.vehicle.vehicle_samples import VehicleSample
from friction_curve_id.vehicle.whole_vehicle import WholeVehicle
from friction_parameters.parameter import ParameterError
from vehicle_models.vehicle import Vehicle

Array = NDArray[np.float64]

_KMH = 1.0 / 3.6
SIGNALS: Mapping[str, tuple[str, ...]] = {
    "speed": ("vx_mps",),
    "acceleration": ("ax_mps2",),
    "wheel speeds": ("w_fl_radps", "w_fr_radps", "w_rl_radps", "w_rr_radps"),
    "torque": ("brake_torque_can",),
}
"""Columns of the log of the BMW M8."""
SHIFT = 0.02
"""Time by which a signal of the BMW stop is moved [s]."""
_INTERVAL = 1.96


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this part."""
    parser.add_argument("--data", type=Path, default=data_directory(), help="directory of the measured data")


def run(options: argparse.Namespace) -> list[Row]:
    """Return one row a car and one a bin of the tyre rig.

    Raises:
        ParameterError: a file is absent.
    """
    for name in (BMW, IAC, TYRE_RIG):
        if not (options.data / name).is_file():
            raise ParameterError(f"measured data are absent: {options.data / name} (give --data, or set FRICTION_DATA)")
    rows = [
        vehicle_row("BMW M8, ABS stop", bmw_samples(bmw_columns(options.data / BMW)), BMW_M8),
        vehicle_row("Indy AV-21, laps", iac_samples(options.data / IAC), INDY_AV21),
    ]
    rows += [
        car_row("BMW M8, ABS stop", bmw_car_samples(bmw_columns(options.data / BMW)), BMW_M8, counted=False),
        car_row("Indy AV-21, laps", iac_car_samples(options.data / IAC), INDY_AV21, counted=True),
    ]
    rows += shifted_rows(options.data / BMW)
    return rows + tyre_rig_rows(options.data / TYRE_RIG)


def bmw_columns(path: Path, signal: str = "", late: float = 0.0) -> dict[str, Array]:
    """Columns of the BMW M8's log.

    Args:
        path: of the log.
        signal: of SIGNALS, or empty.
        late: time by which that signal comes late [s].
    """
    data = np.genfromtxt(path, delimiter=",", names=True)
    columns = {name: data[name] for name in data.dtype.names or ()}
    for name in SIGNALS.get(signal, ()):
        columns[name] = np.interp(data["t_s"] - late, data["t_s"], data[name])
    return columns


def bmw_samples(data: Mapping[str, Array]) -> Iterator[VehicleSample]:
    """Samples of the BMW M8, of its columns."""
    wheels = [data[name] for name in SIGNALS["wheel speeds"]]
    for time, speed, acceleration, *speeds in zip(data["t_s"], data["vx_mps"], data["ax_mps2"], *wheels, strict=True):
        yield VehicleSample(float(time), float(speed), float(acceleration), tuple(map(float, speeds)))


def iac_samples(path: Path) -> Iterator[VehicleSample]:
    """Samples of the Indy AV-21. The file holds rim speeds: the radius cancels in the slip."""
    data = np.genfromtxt(path, delimiter=",", names=True)
    names = zip(("fl", "fr", "rl", "rr"), INDY_AV21.radii, strict=True)
    wheels = [data[f"wheel_{wheel}kmph"] * _KMH / radius for wheel, radius in names]
    for time, speed, acceleration, *speeds in zip(data["times"], data["vxms"], data["axms2"], *wheels, strict=True):
        yield VehicleSample(float(time), float(speed), float(acceleration), tuple(map(float, speeds)))


def bmw_car_samples(data: Mapping[str, Array], front: float = 0.65) -> Iterator[CarSample]:
    """Samples of the BMW M8 with its demanded torque as pressures.

    Args:
        data: its columns.
        front: share of the torque at the front axle, which was not recorded [-].
    """
    demanded = np.maximum(-data["brake_torque_can"], 0.0)
    shares = [0.5 * front / wheel.brake_gain for wheel in BMW_M8.wheels[:2]]
    shares += [0.5 * (1.0 - front) / wheel.brake_gain for wheel in BMW_M8.wheels[2:]]
    pressures = demanded[:, np.newaxis] * np.array(shares)
    for k, sample in enumerate(bmw_samples(data)):
        yield CarSample(sample.time, sample.wheel_speeds, pressures[k], sample.acceleration)


def iac_car_samples(path: Path) -> Iterator[CarSample]:
    """Samples of the Indy AV-21 with its commanded line pressure at every wheel."""
    data = np.genfromtxt(path, delimiter=",", names=True)
    for pressure, sample in zip(data["brake_ped_cmdkPa"], iac_samples(path), strict=True):
        yield CarSample(sample.time, sample.wheel_speeds, [1e3 * float(pressure)] * 4, sample.acceleration)


def shifted_rows(path: Path) -> list[Row]:
    """Each signal of the BMW stop moved by SHIFT either way: the intervals then hold the peak of the log as it is."""
    straight = vehicle_row("BMW M8, ABS stop", bmw_samples(bmw_columns(path)), BMW_M8)
    rows: list[Row] = []
    for signal in SIGNALS:
        for late in (-SHIFT, SHIFT):
            name = f"BMW M8, {signal} {1e3 * abs(late):.0f} ms {'late' if late > 0.0 else 'early'}"
            moved = bmw_columns(path, signal, late)
            if signal != "torque":
                rows.append(shifted_row(name, vehicle_row(name, bmw_samples(moved), BMW_M8), straight))
            if signal != "speed":
                rows.append(car_row(name, bmw_car_samples(moved), BMW_M8, counted=False))
    return rows


def shifted_row(name: str, found: Row, straight: Row) -> Row:
    """How far the peak of `straight` is outside of what was found, in deviations; 0 if that is not valid."""
    row: Row = {"data": "shifted", "case": name, "quantity": "deviations to the peak of the log as it is"}
    if not found["valid"]:
        return row | at_most(0.0, _INTERVAL) | {"valid": False}
    lambda_stddev = (found["lambda_high"] - found["lambda_max"]) / _INTERVAL
    of_lambda = abs(found["lambda_max"] - straight["lambda_max"]) / lambda_stddev
    of_mu = abs(found["mu_max"] - straight["mu_max"]) / found["mu_max_stddev"]
    shown = {each: found[each] for each in ("lambda_max", "lambda_low", "lambda_high", "mu_max", "valid")}
    return row | at_most(max(of_lambda, of_mu), _INTERVAL) | shown


def car_row(name: str, samples: Iterator[CarSample], car: Vehicle, counted: bool) -> Row:
    """Feed the estimator of all wheels: how many of its answers were valid, and why the others were not."""
    estimator = CarEstimator(car, CarEstimatorParameters(counted=counted, max_gap=0.1))
    reasons = Counter[str]()
    for sample in track(list(samples), description=f"{name}, method car"):
        reasons.update(answer.reason.name.lower() for answer in estimator.update(sample))
    row: Row = {"data": "car", "case": name, "quantity": "valid estimates"}
    row |= at_most(reasons.pop("ok", 0), 0)
    row["other_answers"] = ", ".join(f"{reason} {count}" for reason, count in reasons.most_common())
    return row


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
