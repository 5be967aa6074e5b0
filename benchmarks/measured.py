"""Whole-vehicle fits of measured drives (BMW stop, Putnam laps), and curve fits of tyre-rig sweeps.

The data are not part of the project: --data names their directory, else the environment variable FRICTION_DATA, else
shared/data beside the repository. The README lists the files.
"""

import argparse
import os
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.progress import track

from benchmarks.runner import Row, at_most
from friction_curve_id.car import CarEstimator, CarEstimatorParameters, CarSample
from friction_curve_id.chapter.maximum_likelihood import fit, initial_theta
from friction_curve_id.curve.burckhardt_curve import BurckhardtCurve
from friction_curve_id.curve.fitted_curve import FittedCurve
from friction_curve_id.interface import CurveEstimate
from friction_curve_id.vehicle.vehicle_samples import VehicleSample
from friction_curve_id.vehicle.whole_vehicle import WholeVehicle
from friction_parameters.parameter import ParameterError
from vehicle_models import burckhardt
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle

BMW, IAC, TYRE_RIG = "bmw_m8_abs_stop_100hz.csv", "iac_av21_putnam_25hz.csv", "fsae_ttc_straight_line.csv"
BMW_M8 = load_vehicle("bmw_m8")
INDY_AV21 = load_vehicle("indy_av21")


def data_directory() -> Path:
    """FRICTION_DATA, or ../shared/data from where the command is run: beside the repository."""
    return Path(os.environ.get("FRICTION_DATA", Path("../shared/data").resolve()))


Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

LOAD_BINS = ((550.0, 800.0), (1400.0, 1700.0), (2000.0, 3200.0))
"""[N]"""
_PRESSURES = (83.0, 97.0)
"""Inflation pressures of the two runs [kPa]."""
_PRESSURE_TOLERANCE = 3.0
"""[kPa]"""
_FIRST = 20
"""Samples of lowest slip that (8.11) starts from."""
_NEW_SWEEP = 0.05
"""A pause of the recording longer than this [s] begins a new sweep."""
_REACH = 1.96
"""Half the width of a 95 % interval, in standard deviations."""


def tyre_rig_rows(path: Path) -> list[Row]:
    """Fit every bin as a whole and the two halves of its sweeps.

    Only braking counts (slip > 0). A bin is one load at one pressure: the run at 97 kPa has a tenth to a quarter less
    friction than the one at 83 kPa, which no single curve fits.
    """
    data = np.genfromtxt(path, delimiter=",", names=True)
    slip, load, friction = -data["SL"], -data["FZ"], data["FX"] / data["FZ"]
    sweeps = _sweeps(data["ET"], slip)
    rows: list[Row] = []
    for pressure in _PRESSURES:
        for low, high in LOAD_BINS:
            chosen = (load >= low) & (load <= high) & (slip > 0.0)
            chosen &= np.abs(data["P"] - pressure) < _PRESSURE_TOLERANCE
            numbers = np.unique(sweeps[chosen])
            first = np.isin(sweeps, numbers[: len(numbers) // 2])
            name = {"data": "tyre rig", "case": f"{low / 1e3:g}-{high / 1e3:g} kN, {pressure:.0f} kPa"}
            rows.append(
                name | {"sweeps": len(numbers)} | _bin(slip, friction, (chosen, chosen & first, chosen & ~first))
            )
    return rows


def _bin(slip: Array, friction: Array, parts: Sequence[Flags]) -> Row:
    whole, *halves = [_fit(slip[part], friction[part]) for part in parts]
    estimate, residual_rms = whole
    intervals = [_interval(half) for half, _ in halves]
    row = estimate_columns(estimate) | {"residual_rms": residual_rms}
    for name, (low, high) in zip(("first_half", "second_half"), intervals, strict=True):
        row |= {f"{name}_low": low, f"{name}_high": high}
    row["halves_overlap"] = max(low for low, _ in intervals) <= min(high for _, high in intervals)
    return row


def _fit(slip: Array, friction: Array) -> tuple[CurveEstimate, float]:
    lowest = np.argsort(slip)[:_FIRST]
    found = fit(slip, friction, initial_theta(slip[lowest], friction[lowest]))
    residuals = friction - burckhardt.friction(found.theta, slip)
    curve = FittedCurve(BurckhardtCurve(), found.theta, found.covariance)
    return curve.estimate(float(slip[-1]), len(slip), float(np.max(slip))), float(np.sqrt(np.mean(residuals**2)))


def _interval(estimate: CurveEstimate) -> tuple[float, float]:
    """95 % interval of lambda_max; everything beyond 0 where the fitted curve has no peak in (0, 1)."""
    reach = _REACH * estimate.lambda_max_stddev
    if not np.isfinite(reach):
        return 0.0, np.inf
    return max(estimate.lambda_max - reach, 0.0), estimate.lambda_max + reach


def estimate_columns(estimate: CurveEstimate) -> Row:
    """Columns of the curve and of its 95 % interval of lambda_max."""
    low, high = _interval(estimate)
    return {
        "samples": estimate.samples,
        "theta_1": float(estimate.theta[0]),
        "theta_2": float(estimate.theta[1]),
        "theta_3": float(estimate.theta[2]),
        "lambda_max": estimate.lambda_max,
        "lambda_low": low,
        "lambda_high": high,
        "mu_max": estimate.mu_max,
        "mu_max_stddev": estimate.mu_max_stddev,
        "valid": estimate.valid,
        "reason": estimate.reason.name.lower(),
    }


def _sweeps(time: Array, slip: Array) -> NDArray[np.int64]:
    """Number of the sweep of each sample: up and down of one recording are two."""
    recording = np.concatenate([[0], np.cumsum(np.diff(time) > _NEW_SWEEP)])
    numbers = np.zeros(len(time), dtype=np.int64)
    for k in range(int(recording[-1]) + 1):
        inside = np.flatnonzero(recording == k)
        top = inside[np.argmax(slip[inside])]
        numbers[inside] = 2 * k + (inside > top)
    return numbers


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
    estimator = CarEstimator(car, CarEstimatorParameters(wheel_speed_is_interval_mean=counted, max_gap=0.1))
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
