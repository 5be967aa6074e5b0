"""Identification of lambda_max over manoeuvres, surfaces and methods, beside the Cramer-Rao bound.

Studies: methods (the table of all methods), random (500 random curves), alarms (P(beyond the peak) against the true
crossing), model_error (bias by wrong parameters), outliers, surface_change.
"""

import argparse
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.special import lambertw

from benchmarks.identification import cramer_rao
from benchmarks.identification.runs import Batch, alarm_row, coverage, kept_from, make, peak_row
from benchmarks.identification.surface_change import surface_change
from benchmarks.protocol import CORNER, DT, RAMP_TIMES, SPEED, Truth, braking
from benchmarks.runner import Row
from friction_curve_id.chapter.friction_samples import FrictionSource
from friction_curve_id.exact_vehicle.curve_prior import CurvePrior
from friction_curve_id.methods import EXACT_VEHICLE, METHODS
from friction_parameters.command_line import count
from vehicle_models import burckhardt
from vehicle_models.surfaces import SURFACES, TABLE_8_1
from vehicle_models.vehicle import CornerParameters

Array = NDArray[np.float64]

SAMPLES = (40, 70, 100)
_FIRST_SEED = 20_000
"""Far from the seeds of the tuning."""
_RANDOM_MU, _RANDOM_LAMBDA, _RANDOM_RATIO = (0.1, 1.3), (0.03, 0.45), (0.3, 0.5)
"""Uniform; th3 / th1 over the range of the published roads."""


def roads() -> Array:
    """Parameters theta of the surfaces of Table 8.1, shape (4, 3)."""
    return np.array([SURFACES[name] for name in TABLE_8_1])


@cache
def on_roads(manoeuvre: str) -> Truth:
    """Drive a manoeuvre on each of these roads: made once, as its torque takes a second to find."""
    return braking(manoeuvre, roads())


def seeds_of(surface: int, count: int) -> list[tuple[int, Sequence[int]]]:
    """Runs of one surface: its number, and a seed each."""
    return [(surface, (_FIRST_SEED, surface, k)) for k in range(count)]


def methods(options: argparse.Namespace) -> list[Row]:
    """All methods on the surfaces of Table 8.1, after 40, 70 and 100 samples."""
    truth = on_roads(options.manoeuvre)
    lambda_max, mu_max = burckhardt.peak(truth.theta)
    source = FrictionSource(options.source)
    batches = [
        Batch(f"{name} {method}", method, truth, seeds_of(surface, options.seeds), source)
        for surface, name in enumerate(TABLE_8_1)
        for method in options.methods
    ]
    traces = make(batches, f"identification, manoeuvre {options.manoeuvre}", options.processes)
    bounds = _bounds(truth, None)
    with_prior = _bounds(truth, CurvePrior().information)
    rows: list[Row] = []
    for surface, name in enumerate(TABLE_8_1):
        truths = np.full(options.seeds, lambda_max[surface]), np.full(options.seeds, mu_max[surface])
        for method in options.methods:
            found = traces[f"{name} {method}"]
            kept = {f"kept_{limit}pct_from": kept_from(found, truths[0], limit) for limit in (10, 5)}
            for samples in SAMPLES:
                row: Row = {"manoeuvre": options.manoeuvre, "surface": name, "method": method}
                row |= peak_row(found, *truths, samples)
                row["crlb_pct"] = 100.0 * float(bounds[samples][surface])
                row["crlb_prior_pct"] = 100.0 * float(with_prior[samples][surface])
                rows.append(row | kept)
    return rows


def random_curves(options: argparse.Namespace) -> list[Row]:
    """Method exact_vehicle on curves drawn uniformly in mu_max and lambda_max, one noise seed each, beside its bound.

    The row `family` draws th3 / th1 from the range of the published roads, the row `wide` from a normal of its
    logarithm with standard deviation 0.3, wider than the prior: what the prior costs where it does not hold.
    """
    rows: list[Row] = []
    prior = CurvePrior().information
    for case in ("family", "wide"):
        truth = braking(options.manoeuvre, draw_curves(options.seeds, case))
        lambda_max = burckhardt.peak(truth.theta)[0]
        runs = [(k, (_FIRST_SEED, 10, k)) for k in range(options.seeds)]
        found = make([Batch(case, EXACT_VEHICLE, truth, runs)], f"random curves, {case}", options.processes)[case]
        for samples in SAMPLES:
            bound = _bounds(truth, prior)[samples]
            estimate, stddev = found["lambda_max"][:, samples - 1], found["lambda_max_stddev"][:, samples - 1]
            error = np.abs(estimate / lambda_max - 1.0)
            rmse, bound_rms = float(np.mean(error**2)) ** 0.5, float(np.mean(bound**2)) ** 0.5
            rows.append(
                {
                    "manoeuvre": options.manoeuvre,
                    "curves": case,
                    "samples": samples,
                    "runs": options.seeds,
                    "rmse_pct": 100.0 * rmse,
                    "bound_with_prior_pct": 100.0 * bound_rms,
                    "rmse_over_bound": rmse / bound_rms,
                    "coverage_95": coverage(estimate, stddev, lambda_max),
                    "max_pct": 100.0 * float(error.max()),
                    "failures": int((~(error <= 0.5)).sum()),
                    "divergences": found.exceptions,
                }
            )
    return rows


def draw_curves(count: int, case: str) -> Array:
    """Random roads, shape (count, 3): mu_max and lambda_max uniform, th3 / th1 by case (see `random_curves`)."""
    generator = np.random.default_rng([_FIRST_SEED, 11])
    mu_max, lambda_max = generator.uniform(*_RANDOM_MU, count), generator.uniform(*_RANDOM_LAMBDA, count)
    uniform, normal = generator.uniform(*_RANDOM_RATIO, count), generator.normal(0.0, 0.3, count)
    # Above ratio lambda_max = 1/e there is no curve with this peak.
    ratio = uniform if case == "family" else np.minimum(0.4 * np.exp(normal), 0.36 / lambda_max)
    log_ratio = -np.real(lambertw(-ratio * lambda_max, -1))
    th1 = mu_max / (1.0 - np.exp(-log_ratio) * (1.0 + log_ratio))
    return np.stack([th1, log_ratio / lambda_max, ratio * th1], axis=-1)


def alarms(options: argparse.Namespace) -> list[Row]:
    """P(beyond the peak) > 0.9 against the true crossing, a row per surface and one over all."""
    truth = on_roads(options.manoeuvre)
    lambda_max = burckhardt.peak(truth.theta)[0]
    count = options.seeds
    batches = [Batch(name, EXACT_VEHICLE, truth, seeds_of(k, count)) for k, name in enumerate(TABLE_8_1)]
    traces = make(batches, "alarms", options.processes)
    rows: list[Row] = []
    for k, name in enumerate(TABLE_8_1):
        slip = np.tile(truth.slip[k], (count, 1))
        rows.append({"surface": name} | alarm_row(traces[name], slip, np.full(count, lambda_max[k]), DT))
    joined = replace(traces[TABLE_8_1[0]], values=np.concatenate([traces[name].values for name in TABLE_8_1]))
    slip, peaks = np.repeat(truth.slip, count, axis=0), np.repeat(lambda_max, count)
    rows.append({"surface": "all"} | alarm_row(joined, slip, peaks, DT))
    return rows


def model_error(options: argparse.Namespace) -> list[Row]:
    """Bias of lambda_max and mu_max at N = 100 where the estimator's parameters or inputs are wrong."""
    truth = on_roads(options.manoeuvre)
    lambda_max, mu_max = burckhardt.peak(truth.theta)
    changes: list[tuple[str, CornerParameters, float, float]] = [("none", CORNER, 0.0, 1.0)]
    for name, share in (("mass", 0.10), ("inertia", 0.10), ("radius", 0.01), ("vertical_load", 0.05)):
        for sign in (1.0, -1.0):
            wrong = replace(CORNER, **{name: getattr(CORNER, name) * (1.0 + sign * share)})
            changes.append((f"{name} {100 * sign * share:+.0f} %", wrong, 0.0, 1.0))
    changes += [(f"torque gain {100 * share:+.0f} %", CORNER, 0.0, 1.0 + share) for share in (0.05, -0.05)]
    changes += [(f"speed bias {bias:+.1f} m/s", CORNER, bias, 1.0) for bias in (0.5, -0.5)]
    seeds = {name: seeds_of(k, options.seeds) for k, name in enumerate(TABLE_8_1)}
    batches = [
        Batch(f"{surface} {text}", EXACT_VEHICLE, truth, runs, wheel=wheel, speed_bias=bias, torque_gain=gain)
        for surface, runs in seeds.items()
        for text, wheel, bias, gain in changes
    ]
    traces = make(batches, "model error", options.processes)
    rows: list[Row] = []
    for text, *_ in changes:
        row: Row = {"error": text, "seeds": options.seeds}
        for k, surface in enumerate(TABLE_8_1):
            found = traces[f"{surface} {text}"]
            row[f"{surface}_lambda_bias_pct"] = 100.0 * float(np.mean(found["lambda_max"][:, -1] / lambda_max[k] - 1.0))
            row[f"{surface}_mu_bias_pct"] = 100.0 * float(np.mean(found["mu_max"][:, -1] / mu_max[k] - 1.0))
            row[f"{surface}_restarts"] = int(np.nansum(found["restarted"]))
        rows.append(row)
    return rows


def outliers(options: argparse.Namespace) -> list[Row]:
    """Five samples in a row off by ten times their noise: how far lambda_max moves, in its stated deviations.

    `before_to_after`: from the sample before the outliers to the fifth of them, over the deviation stated before.
    `without_to_with`: at N = 100 against the same run without outliers, over the deviation stated with them.
    """
    truth = on_roads(options.manoeuvre)
    firsts = (30, 45, 60, 75, 90)
    batches = []
    for k, surface in enumerate(TABLE_8_1):
        runs = seeds_of(k, options.seeds)
        batches.append(Batch(surface, EXACT_VEHICLE, truth, runs))
        for signals in ("w", "v", "T", "wvT"):
            batches += [
                Batch(
                    f"{surface} {signals} {first} {sign}", EXACT_VEHICLE, truth, runs, outliers=(first, sign, signals)
                )
                for first in firsts
                for sign in (1, -1)
            ]
    traces = make(batches, "outliers", options.processes)
    rows: list[Row] = []
    for surface in TABLE_8_1:
        clean = traces[surface]
        for signals in ("w", "v", "T", "wvT"):
            for first in firsts:
                found = [traces[f"{surface} {signals} {first} {sign}"] for sign in (1, -1)]
                moved, apart = [], []
                for trace in found:
                    value, stddev = trace["lambda_max"], trace["lambda_max_stddev"]
                    moved.append((value[:, first + 4] - value[:, first - 1]) / stddev[:, first - 1])
                    apart.append((value[:, -1] - clean["lambda_max"][:, -1]) / stddev[:, -1])
                row: Row = {"surface": surface, "signals": signals, "first_sample": first + 1}
                row["runs"] = 2 * options.seeds
                for name, distances in (("before_to_after", moved), ("without_to_with", apart)):
                    size = np.abs(np.concatenate(distances))
                    row[f"{name}_median"] = float(np.median(size))
                    row[f"{name}_p99"] = float(np.percentile(size, 99))
                    row[f"{name}_max"] = float(size.max())
                    row[f"{name}_within_1_pct"] = 100.0 * float(np.mean(size <= 1.0))
                row["restarts"] = int(sum(np.nansum(trace["restarted"]) for trace in found))
                rows.append(row)
    return rows


def _bounds(truth: Truth, prior: Array | None) -> dict[int, Array]:
    """Relative bound of lambda_max by number of samples, shape (roads,)."""
    found = cramer_rao.sensitivities(truth.theta, truth.torque, DT, SPEED)
    return {
        samples: cramer_rao.relative_bound(truth.theta, cramer_rao.information(found, samples), prior)
        for samples in SAMPLES
    }


_STUDIES: dict[str, Callable[[argparse.Namespace], list[Row]]] = {
    "methods": methods,
    "random": random_curves,
    "alarms": alarms,
    "model_error": model_error,
    "outliers": outliers,
    "surface_change": surface_change,
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this part."""
    parser.add_argument("--study", choices=_STUDIES, default="methods", help="what to study (default: methods)")
    parser.add_argument("--manoeuvre", choices=RAMP_TIMES, default="B", help="torque ramp: A 0.5 s, B 0.25 s, C 0.1 s")
    parser.add_argument("--seeds", type=count, default=500, help="noise seeds a surface")
    parser.add_argument("--methods", nargs="+", choices=METHODS, default=list(METHODS), help="for the study 'methods'")
    parser.add_argument(
        "--source",
        choices=[source.value for source in FrictionSource],
        default=FrictionSource.DEAD_RECKONED.value,
        help="how the chapter's methods make their friction samples",
    )
    parser.add_argument("--processes", type=count, default=2, help="processes that share the runs")


def run(options: argparse.Namespace) -> list[Row]:
    """Make the study and return its rows."""
    return _STUDIES[options.study](options)
