"""Friction of a cell over time by a histogram filter: fits are likelihoods, friction in use is a censored observation.

Each cell has a density of x, the friction of the road for a median tyre, and of w, the weather of its region; the
region has its own of w, which all its cells share. Between observations the road is drawn anew, at a mean time T, and
the weather likewise (roads_later). With s the deviation of ln x by measurement and tyre:

    p(x,w) <- p(x,w) P(w) / sum_x p(x,w)               what the other cells of the region have told of the weather
    p(x,w) <- p(x,w) ((1 - e) N(ln m; ln x, s) + e / R)          a fit m; R is the range of ln x
    p(x,w) <- p(x,w) ((1 - e) Phi((ln x - ln u) / s) + e)        friction u that was proven: the road has at least this
    P(w)   <- sum_x p(x,w), normalised

u is the friction in use less 2.58 standard deviations. Proofs of one car are not repeated evidence, as its tyres are
the same: a smaller one counts at a time T after the last. That a pass uses little is no evidence either: a place where
nobody brakes looks like ice to everybody who drives there.

A road goes on into the next cell, at least its kind k, bare or under snow and ice, where no border lies between:

    p_i(x) <- p_i(x) sum_k P(k|x) prod_j (c P_j(k) / P_0(k) + 1 - c),    c = exp(-spacing / L)

Friction itself is not taken from the neighbours: the same tyres have driven there, so their errors are the same.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from friction_fleet.cells import SPACING, neighbours, region_of
from friction_fleet.evidence import Evidence
from friction_fleet.weather import KINDS, ROADS, WEATHERS, roads_later, weather_later
from friction_grip.road_memory import PROOF_SIGMAS
from friction_grip.road_prior import GRID

Array = NDArray[np.float64]

CHANGE_TIME = 6.0
"""Mean time between changes of a road, and of the weather [h]: rain and drying, frost and thaw, winter service."""
CHANGE_DISTANCE = 300.0
"""Mean distance between changes of the road [m], as of friction_grip."""
BETWEEN_TYRES = 0.08
"""Deviation of the friction of tyres on one road, relative."""
_WRONG = 0.02
"""Share of evidence that is wrong or of another place."""
SLIPPERY = 0.4
"""Friction of a road below which it is slippery: snow and ice."""
WARNING = 0.5
"""Probability of a slippery road from which a cell is one."""
_GOES_ON = float(np.exp(-SPACING / CHANGE_DISTANCE))
"""Probability that a road is of one kind in two neighbouring cells."""
_KINDS_BEFORE = KINDS @ (WEATHERS @ ROADS)
"""Probability of bare roads, and of snow and ice, before anything is known, (2,)."""
_LOG_GRID = np.log(GRID)
_ROOT = float(np.sqrt(2.0 * np.pi))
_RANGE = float(_LOG_GRID[-1] - _LOG_GRID[0])


@dataclass(frozen=True)
class CellFriction:
    """Friction of a cell at a time."""

    cell: int
    lower: float
    median: float
    upper: float
    """Quantiles of 5, 50 and 95 %."""
    slippery: float
    """Probability that it is below SLIPPERY."""
    age: float
    """Time since the last evidence [s]."""
    passes: int
    """Lower bounds."""
    fits: int
    vehicles: int


@dataclass
class _Weather:
    """What is known of the weather of a region."""

    chances: Array
    """Probability of dry and of wet weather, (2,)."""
    stamp: float


@dataclass
class _Cell:
    densities: Array
    """Probability of weather and friction, (2, 90)."""
    stamp: float
    weather: _Weather
    proofs: dict[str, tuple[float, float]] = field(default_factory=dict)
    """Largest proof of each car, and its time [s]."""
    passes: int = 0
    fits: int = 0
    vehicles: set[str] = field(default_factory=set)


class FrictionMap:
    """The friction of all cells; evidence comes in the order of time."""

    def __init__(self, change_time: float = CHANGE_TIME, use_bounds: bool = True) -> None:
        """Begin without evidence.

        Args:
            change_time: mean time between changes of a road, and of the weather [h].
            use_bounds: whether friction in use counts, or fits alone.
        """
        self._change = 3600.0 * change_time
        self._use_bounds = use_bounds
        self._cells: dict[int, _Cell] = {}
        self._weathers: dict[int, _Weather] = {}

    def update(self, evidence: Evidence) -> None:
        """Take what a car has learned."""
        cell = self._cells.get(evidence.cell) or self._new_cell(evidence)
        densities = self._at(cell, evidence.stamp)
        if evidence.is_fit:
            cell.fits += 1
            densities = densities * _of_fit(evidence)
        else:
            cell.passes += 1
            proven = evidence.mu - PROOF_SIGMAS * evidence.stddev
            before, at = cell.proofs.get(evidence.vehicle, (0.0, evidence.stamp))
            is_news = proven > before or evidence.stamp - at > self._change
            if self._use_bounds and is_news and proven > GRID[0]:
                cell.proofs[evidence.vehicle] = proven, evidence.stamp
                densities = densities * _of_proof(proven)
        cell.densities, cell.stamp = densities / densities.sum(), max(evidence.stamp, cell.stamp)
        cell.weather.chances, cell.weather.stamp = cell.densities.sum(axis=1), cell.stamp
        cell.vehicles.add(evidence.vehicle)

    def update_all(self, evidence: Iterable[Evidence]) -> None:
        """Take much of it, in the order of time."""
        for each in evidence:
            self.update(each)

    def at(self, stamp: float) -> Mapping[int, CellFriction]:
        """Return the friction of every cell that has evidence, at a time not before the last of it [s since 1970]."""
        found = ((number, self.cell_at(number, stamp)) for number in sorted(self._cells))
        return {number: cell for number, cell in found if cell is not None}

    def cell_at(self, number: int, stamp: float) -> CellFriction | None:
        """Return the friction of a cell at a time, as `at`; None where it has no evidence."""
        if number not in self._cells:
            return None
        density = self._at(self._cells[number], stamp).sum(axis=0)
        for each in neighbours(number):
            if each in self._cells:
                kinds = KINDS @ self._at(self._cells[each], stamp).sum(axis=0)
                density = density * ((_GOES_ON * kinds / _KINDS_BEFORE + 1.0 - _GOES_ON) @ KINDS)
        return self._summary(number, density / density.sum(), stamp)

    def _new_cell(self, evidence: Evidence) -> _Cell:
        weather = self._weathers.setdefault(region_of(evidence.cell), _Weather(WEATHERS, evidence.stamp))
        return self._cells.setdefault(evidence.cell, _Cell(WEATHERS[:, None] * ROADS, evidence.stamp, weather))

    def _at(self, cell: _Cell, stamp: float) -> Array:
        """Return the probability of weather and friction of a cell at a time, (2, 90)."""
        densities = roads_later(cell.densities, self._unchanged(cell.stamp, stamp))
        chances = weather_later(cell.weather.chances, self._unchanged(cell.weather.stamp, stamp))
        return np.asarray(densities * (chances / densities.sum(axis=1))[:, None])

    def _unchanged(self, since: float, stamp: float) -> float:
        """Return the probability that nothing was drawn anew between two times."""
        return float(np.exp(-max(stamp - since, 0.0) / self._change))

    def _summary(self, number: int, density: Array, stamp: float) -> CellFriction:
        cumulated = np.cumsum(density)
        # the mass of a bin is around its point: half of it is below
        lower, median, upper = np.exp(np.interp([0.05, 0.5, 0.95], cumulated - 0.5 * density, _LOG_GRID)).tolist()
        cell = self._cells[number]
        slippery = float(np.interp(np.log(SLIPPERY), _LOG_GRID, cumulated - 0.5 * density))
        age = stamp - cell.stamp
        return CellFriction(number, lower, median, upper, slippery, age, cell.passes, cell.fits, len(cell.vehicles))


def _of_fit(evidence: Evidence) -> Array:
    """Return the likelihood of a fit for each friction of GRID, (90,)."""
    stddev = float(np.hypot(evidence.stddev / evidence.mu, BETWEEN_TYRES))
    distance = (_LOG_GRID - np.log(evidence.mu)) / stddev
    bell = np.exp(-0.5 * distance**2) / (stddev * _ROOT)
    return np.asarray((1.0 - _WRONG) * bell + _WRONG / _RANGE)


def _of_proof(mu: float) -> Array:
    """Return the likelihood of friction that was proven for each friction of GRID, (90,)."""
    return np.asarray((1.0 - _WRONG) * ndtr((_LOG_GRID - np.log(mu)) / BETWEEN_TYRES) + _WRONG)
