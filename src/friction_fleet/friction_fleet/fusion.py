"""Friction of a cell over time by a histogram filter: fits are likelihoods, friction in use is a censored observation.

Between observations the road may change, at a mean time T, and once more with probability 1/2 at each of n changes of
the weather that are known; then it is one of the prior's. With x the friction of the road for a median tyre, and s the
deviation of ln x by measurement and tyre:

    p(x) <- a p(x) + (1 - a) p_0(x),    a = e^(-dt/T) 2^(-n)   time
    p(x) <- p(x) ((1 - e) N(ln m; ln x, s) + e / R)          a fit m; R is the range of ln x
    p(x) <- p(x) ((1 - e) Phi((ln x - ln u) / s) + e)        friction u that was proven: the road has at least this

u is the friction in use less 2.58 standard deviations. Proofs of one car are not repeated evidence, as its tyres are
the same: a smaller one counts once a < 1/e since the last. That a pass uses little is no evidence either: a place where
nobody brakes looks like ice to everybody who drives there.

A road goes on into the next cell. So the prior of a cell is that of its neighbours, as far as no border lies between:

    p_i(x) ~ (p_i(x) / p_0(x)) (c mean_j p_j(x) + (1 - c) p_0(x)),    c = exp(-spacing / L)
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from friction_fleet.cells import SPACING, neighbours
from friction_fleet.evidence import Evidence
from friction_grip.road_memory import PROOF_SIGMAS
from friction_grip.road_prior import GRID, RoadPrior

Array = NDArray[np.float64]

CHANGE_TIME = 6.0
"""Mean time between changes of a road [h]: rain and drying, frost and thaw, winter service."""
CHANGE_DISTANCE = 300.0
"""Mean distance between changes of the road [m], as of friction_grip."""
_FORGOTTEN = float(np.exp(-1.0))
"""Probability of an unchanged road below which a car's proof does not stand against a smaller one."""
_WEATHER = 0.5
"""Share of the roads that a change of the weather changes."""
BETWEEN_TYRES = 0.08
"""Deviation of the friction of tyres on one road, relative."""
_WRONG = 0.02
"""Share of evidence that is wrong or of another place."""
SLIPPERY = 0.4
"""Friction of a road below which it is slippery: snow and ice."""
WARNING = 0.5
"""Probability of a slippery road from which a cell is one."""
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
class _Cell:
    density: Array
    stamp: float
    proofs: dict[str, tuple[float, float]] = field(default_factory=dict)
    """Largest proof of each car, and its time [s]."""
    passes: int = 0
    fits: int = 0
    vehicles: set[str] = field(default_factory=set)


class FrictionMap:
    """The friction of all cells; evidence comes in the order of time."""

    def __init__(
        self,
        prior: RoadPrior | None = None,
        change_time: float = CHANGE_TIME,
        use_bounds: bool = True,
        weather: Sequence[float] = (),
    ) -> None:
        """Begin without evidence.

        Args:
            prior: shares of roads; None for those of a year.
            change_time: mean time between changes of a road [h].
            weather: times at which rain or frost begins or ends [s since 1970].
            use_bounds: whether friction in use counts, or fits alone.
        """
        self._prior = (RoadPrior() if prior is None else prior).density()
        self._prior = self._prior / self._prior.sum()
        self._change = 3600.0 * change_time
        self._use_bounds = use_bounds
        self._weather = np.sort(np.array(weather))
        self._cells: dict[int, _Cell] = {}

    def update(self, evidence: Evidence) -> None:
        """Take what a car has learned."""
        cell = self._cells.setdefault(evidence.cell, _Cell(self._prior, evidence.stamp))
        density = self._at(cell, evidence.stamp)
        if evidence.is_fit:
            cell.fits += 1
            density = density * _of_fit(evidence)
        else:
            cell.passes += 1
            proven = evidence.mu - PROOF_SIGMAS * evidence.stddev
            before, at = cell.proofs.get(evidence.vehicle, (0.0, evidence.stamp))
            is_news = proven > before or self._unchanged(at, evidence.stamp) < _FORGOTTEN
            if self._use_bounds and is_news and proven > GRID[0]:
                cell.proofs[evidence.vehicle] = proven, evidence.stamp
                density = density * _of_proof(proven)
        cell.density, cell.stamp = density / density.sum(), max(evidence.stamp, cell.stamp)
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
        density = self._at(self._cells[number], stamp)
        around = [self._at(self._cells[each], stamp) for each in neighbours(number) if each in self._cells]
        if around:
            same = float(np.exp(-SPACING / CHANGE_DISTANCE))
            density = density / self._prior * (same * np.mean(around, axis=0) + (1.0 - same) * self._prior)
        return self._summary(number, density / density.sum(), stamp)

    def _at(self, cell: _Cell, stamp: float) -> Array:
        same = self._unchanged(cell.stamp, stamp)
        return same * cell.density + (1.0 - same) * self._prior

    def _unchanged(self, since: float, stamp: float) -> float:
        """Return the probability that a road has not changed between two times."""
        later = max(stamp, since)
        begun, ended = np.searchsorted(self._weather, (since, later), side="right").tolist()
        return float(np.exp(-(later - since) / self._change)) * (1.0 - _WEATHER) ** (ended - begun)

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
