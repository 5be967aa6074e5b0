"""Burckhardt fits of measured straight-line slip sweeps of a tyre rig, per vertical load and inflation pressure."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.rows import Row
from friction_curve_id.chapter.maximum_likelihood import fit, initial_theta
from friction_curve_id.curve.burckhardt_curve import BurckhardtCurve
from friction_curve_id.curve.fitted_curve import FittedCurve
from friction_curve_id.interface import CurveEstimate
from vehicle_models import burckhardt

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
