"""Identification of lambda_max by the chapter's methods over manoeuvres and surfaces, beside the Cramer-Rao bound."""

import argparse
from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from benchmarks.identification import cramer_rao
from benchmarks.identification.runs import Batch, kept_from, make, peak_row
from benchmarks.protocol import DT, RAMP_TIMES, SPEED, Truth, braking
from benchmarks.runner import Row
from friction_curve_id.chapter.friction_samples import FrictionSource
from friction_curve_id.methods import CHAPTER_METHODS
from friction_parameters.command_line import count
from vehicle_models import burckhardt
from vehicle_models.surfaces import SURFACES, TABLE_8_1

Array = NDArray[np.float64]

SAMPLES = (40, 70, 100)
_FIRST_SEED = 20_000
"""Far from the seeds of the tuning."""


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


def run(options: argparse.Namespace) -> list[Row]:
    """All methods on the surfaces of Table 8.1, after 40, 70 and 100 samples."""
    truth = on_roads(options.manoeuvre)
    lambda_max, mu_max = burckhardt.peak(truth.theta)
    source = FrictionSource(options.source)
    batches = [
        Batch(f"{name} {method}", method, truth, seeds_of(surface, options.seeds), source)
        for surface, name in enumerate(TABLE_8_1)
        for method in options.methods
    ]
    traces = make(batches, f"identification, manoeuvre {options.manoeuvre}")
    bounds = _bounds(truth)
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
                rows.append(row | kept)
    return rows


def _bounds(truth: Truth) -> dict[int, Array]:
    """Relative bound of lambda_max by number of samples, shape (roads,)."""
    found = cramer_rao.sensitivities(truth.theta, truth.torque, DT, SPEED)
    return {
        samples: cramer_rao.relative_bound(truth.theta, cramer_rao.information(found, samples)) for samples in SAMPLES
    }


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this part."""
    parser.add_argument("--manoeuvre", choices=RAMP_TIMES, default="B", help="torque ramp: A 0.5 s, B 0.25 s, C 0.1 s")
    parser.add_argument("--seeds", type=count, default=500, help="noise seeds a surface")
    parser.add_argument("--methods", nargs="+", choices=CHAPTER_METHODS, default=list(CHAPTER_METHODS))
    parser.add_argument(
        "--source",
        choices=[source.value for source in FrictionSource],
        default=FrictionSource.DEAD_RECKONED.value,
        help="how the chapter's methods make their friction samples",
    )
