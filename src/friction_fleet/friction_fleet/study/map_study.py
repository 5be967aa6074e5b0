"""The map against the truth of a town, beside a weighted mean of fits and beside fits without bounds."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from friction_fleet.evidence import Evidence
from friction_fleet.fusion import BETWEEN_TYRES, SLIPPERY, WARNING, CellFriction, FrictionMap
from friction_fleet.study.town_truth import CellTruth

_INTERVAL_90 = 1.645
_EVERY = 3600.0
"""Time between two looks at the map [s]."""
_PASSES = 5
"""Passes within which a slippery cell is to be found."""


class RoadMap(Protocol):
    """A map that takes evidence in the order of time."""

    def update(self, evidence: Evidence) -> None:
        """Take what a car has learned."""

    def at(self, stamp: float) -> Mapping[int, CellFriction]:
        """Return the friction of every cell at a time."""

    def cell_at(self, number: int, stamp: float) -> CellFriction | None:
        """Return the friction of one cell at a time; None where nothing is known."""


class WeightedMean:
    """Mean of ln mu of the fits of a cell, weighted by their variances, and its interval: what a table would give."""

    def __init__(self) -> None:
        """Begin without fits."""
        self._fits: dict[int, list[tuple[float, float]]] = {}

    def update(self, evidence: Evidence) -> None:
        """Take a fit; friction in use is no value."""
        if evidence.is_fit:
            variance = (evidence.stddev / evidence.mu) ** 2 + BETWEEN_TYRES**2
            self._fits.setdefault(evidence.cell, []).append((float(np.log(evidence.mu)), 1.0 / variance))

    def at(self, stamp: float) -> Mapping[int, CellFriction]:
        """Return the mean of every cell with a fit."""
        found = ((number, self.cell_at(number, stamp)) for number in sorted(self._fits))
        return {number: cell for number, cell in found if cell is not None}

    def cell_at(self, number: int, stamp: float) -> CellFriction | None:
        """Return the mean of a cell."""
        fits = self._fits.get(number)
        if not fits:
            return None
        values, weights = np.array(fits).T
        mean, reach = np.average(values, weights=weights), _INTERVAL_90 / np.sqrt(weights.sum())
        lower, median, upper = np.exp([mean - reach, mean, mean + reach]).tolist()
        return CellFriction(number, lower, median, upper, float(median < SLIPPERY), 0.0, 0, len(fits), 1)


MAPS: Mapping[str, Callable[[], RoadMap]] = {
    "filter, fits and bounds": FrictionMap,
    "filter, fits alone": lambda: FrictionMap(use_bounds=False),
    "weighted mean of fits": WeightedMean,
}


@dataclass
class _Counts:
    """What one map got right."""

    covered: list[bool] = field(default_factory=list)
    widths: list[float] = field(default_factory=list)
    errors: list[float] = field(default_factory=list)
    alarms: list[bool] = field(default_factory=list)
    answers: int = 0
    looks: int = 0
    found: list[bool] = field(default_factory=list)
    found_with_fit: list[bool] = field(default_factory=list)


def judge(evidence: Sequence[Evidence], truth: Sequence[CellTruth]) -> list[dict[str, str | float]]:
    """Return a row for each map.

    Every hour each cell that has been driven through is looked at: its 90 % interval is judged where all of its road
    is alike, an alarm is false where none of it is slippery. A cell that is slippery throughout is found if the map
    has it so after one of the first five passes in that time; cells with fewer passes are not judged.
    """
    ordered = sorted(evidence, key=lambda each: each.stamp)
    return [_row(name, _count(make(), ordered, truth)) for name, make in MAPS.items()]


def _count(road: RoadMap, evidence: Sequence[Evidence], truth: Sequence[CellTruth]) -> _Counts:
    counts, passes = _Counts(), _Passes(truth)
    by_cell: dict[int, list[CellTruth]] = {}
    for true in truth:
        by_cell.setdefault(true.cell, []).append(true)
    driven: set[int] = set()
    look = evidence[0].stamp + _EVERY
    for each in evidence:
        while each.stamp > look:
            _look(counts, road.at(look), by_cell, driven, look)
            look += _EVERY
        road.update(each)
        driven.add(each.cell)
        passes.take(each, road)
    counts.found = [found for found, _ in passes.results()]
    counts.found_with_fit = [found for found, fit in passes.results() if fit]
    return counts


def _look(
    counts: _Counts,
    cells: Mapping[int, CellFriction],
    truth: Mapping[int, Sequence[CellTruth]],
    driven: set[int],
    stamp: float,
) -> None:
    for number in driven:
        true = next((each for each in truth.get(number, ()) if each.begin <= stamp < each.end), None)
        if true is None:  # a fix beside the road
            continue
        counts.looks += 1
        cell = cells.get(number)
        if true.lowest >= SLIPPERY:
            counts.alarms.append(cell is not None and cell.slippery > WARNING)
        if cell is None:
            continue
        counts.answers += 1
        if true.is_uniform:
            counts.covered.append(cell.lower <= true.mean <= cell.upper)
            counts.widths.append(cell.upper / cell.lower)
            counts.errors.append(abs(float(np.log(cell.median / true.mean))))


class _Passes:
    """Passes through cells while they are slippery."""

    def __init__(self, truth: Sequence[CellTruth]) -> None:
        self._times: dict[int, list[CellTruth]] = {}
        for each in truth:
            if each.is_slippery:
                self._times.setdefault(each.cell, []).append(each)
        self._number: dict[CellTruth, int] = {}
        self._found: dict[CellTruth, bool] = {}
        self._fit: dict[CellTruth, bool] = {}

    def take(self, evidence: Evidence, road: RoadMap) -> None:
        """Count a pass, and look whether the map knows of the cell."""
        time = next((t for t in self._times.get(evidence.cell, ()) if t.begin <= evidence.stamp < t.end), None)
        if time is None or self._number.get(time, 0) >= _PASSES:
            return
        self._number[time] = self._number.get(time, 0) + 1
        self._fit[time] = self._fit.get(time, False) or evidence.is_fit
        cell = road.cell_at(evidence.cell, evidence.stamp)
        self._found[time] = self._found.get(time, False) or (cell is not None and cell.slippery > WARNING)

    def results(self) -> list[tuple[bool, bool]]:
        """Return of each cell with enough passes whether it was found, and whether one of them had a fit."""
        return [(self._found[t], self._fit[t]) for t, number in self._number.items() if number >= _PASSES]


def _row(name: str, counts: _Counts) -> dict[str, str | float]:
    def mean(flags: Sequence[bool]) -> float:
        return 100.0 * float(np.mean(flags)) if flags else float("nan")

    return {
        "map": name,
        "answers [%]": 100.0 * counts.answers / max(counts.looks, 1),
        "90 % interval covers [%]": mean(counts.covered),
        "upper over lower": float(np.median(counts.widths)) if counts.widths else float("nan"),
        "median error [%]": 100.0 * float(np.median(counts.errors)) if counts.errors else float("nan"),
        "slippery found in 5 passes [%]": mean(counts.found),
        "with a fit [%]": mean(counts.found_with_fit),
        "slippery cells": float(len(counts.found)),
        "of them with a fit": float(len(counts.found_with_fit)),
        "false alarms [%]": mean(counts.alarms),
        "looks": float(counts.looks),
    }
