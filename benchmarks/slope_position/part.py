"""Slope signs in ABS stops, in and out of the loop: how many samples have one, are right, and how soon."""

import argparse
from collections.abc import Sequence
from itertools import product

import numpy as np

from benchmarks.engine import results_of
from benchmarks.runner import Row, at_least
from benchmarks.slope_position.driving import ROADS, driving_rows, make_drive
from benchmarks.slope_position.loop import LAWS, loop_cases, make_loop
from benchmarks.slope_position.stops import CASES, Case, Stop, make_stop
from friction_parameters.command_line import count
from friction_slope.estimate import Method

SHORTEST = 0.03
"""Passing that is too short to be told [s]."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this part."""
    parser.add_argument("--seeds", type=count, default=20, help="stops of each case")
    parser.add_argument("--first-seed", type=int, default=5000, help="seed of the first")
    parser.add_argument("--cases", nargs="*", choices=tuple(CASES), default=tuple(CASES), help="default: all")
    parser.add_argument("--drives", type=int, default=8, help="drives of 3 minutes in ordinary traffic")
    parser.add_argument("--loops", type=int, default=5, help="stops of the whole graph under each law on each road")
    methods = tuple(method.value for method in Method)
    parser.add_argument("--method", choices=methods, default=methods[0])


def run(options: argparse.Namespace) -> list[Row]:
    """Make all stops; return two rows a case, and those of ordinary driving."""
    seeds = range(options.first_seed, options.first_seed + options.seeds)
    jobs = [(name, options.method, seed) for name in options.cases for seed in seeds]
    stops = results_of(make_stop, jobs, "stops")
    rows: list[Row] = []
    for k, name in enumerate(options.cases):
        rows += case_rows(CASES[name], stops[k * len(seeds) : (k + 1) * len(seeds)])
    for law, road in product(LAWS, ROADS) if options.loops else ():
        loops = [(law, road, options.first_seed + k) for k in range(options.loops)]
        closed = results_of(make_loop, loops, f"closed loop, {law}, {road}")
        for case, of_axle in zip(loop_cases(law, road), zip(*closed, strict=True), strict=True):
            rows += case_rows(case, of_axle)
    drives = [(options.method, seed) for seed in range(options.first_seed, options.first_seed + options.drives)]
    if drives:
        rows += driving_rows(results_of(make_drive, drives, "drives"))
    return rows


def case_rows(case: Case, stops: Sequence[Stop]) -> list[Row]:
    """Rows of the signs -1 and +1 of a case; where there is no sign, none is wrong."""
    delays = np.concatenate([passing_delays(stop) for stop in stops])
    rows: list[Row] = []
    for side, (sign, quantity) in enumerate(((-1, "beyond the peak"), (1, "stable"))):
        told = right = samples = 0
        for stop in stops:
            truth = (stop.beyond if sign < 0 else ~stop.beyond) & stop.judged[:, np.newaxis]
            given = (stop.sign == sign) & stop.judged[:, np.newaxis]
            samples, told, right = samples + truth.sum(), told + given.sum(), right + (given & truth).sum()
        of_samples = 100.0 * float(right) / max(float(samples), 1.0)
        row: Row = {
            "case": case.name,
            "stops": len(stops),
            "sign": quantity,
            "told [% of samples]": of_samples,
            "wanted": case.told[side] or None,
            "quantity": "of signs, right [%]",
            **at_least(100.0 * float(right) / float(told) if told else 100.0, case.right_signs[side]),
        }
        if sign < 0 and delays.size:
            row["delay, median [ms]"] = 1e3 * float(np.median(delays))
            row["90 % [ms]"] = 1e3 * float(np.quantile(delays, 0.9, method="higher"))
        rows.append(row)
    return rows


def passing_delays(stop: Stop) -> np.ndarray:
    """Times from each passing of the peak to the first sign -1 before the slip is back [s]; infinite where none."""
    delays = []
    for wheel in range(stop.beyond.shape[1]):
        beyond = stop.beyond[:, wheel] & stop.judged
        edges = np.flatnonzero(np.diff(np.concatenate([[False], beyond, [False]]).astype(int)))
        for up, down in zip(edges[::2], edges[1::2], strict=True):
            if stop.time[down - 1] - stop.time[up] < SHORTEST:
                continue
            told = np.flatnonzero(stop.told_at[up:down, wheel] < 0)
            delays.append(float(stop.time[up + told[0]] - stop.time[up]) if told.size else np.inf)
    return np.array(delays)
