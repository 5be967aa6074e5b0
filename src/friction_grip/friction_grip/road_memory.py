"""Memory of a road: what it has proven, and what follows for the road that the car is on now.

The road may have changed anywhere behind the car, at a mean distance L between changes. Hypothesis j says that it last
changed in segment j; its probability is that of the distances alone. Under it, what was felt since then is of this
road: its friction is at least the largest one that was proven, and that of a curve that was valid. So the friction x of
the road has the density

    p(x) = sum_j w_j p_0(x) Phi((x - m_j) / s_j) F(0.8 x)^(-n_j) N(x; c_j, d_j)

with the prior p_0, the largest proof m_j +- s_j and the curve c_j +- d_j since segment j. A proof is not repeated
evidence: only the largest counts. That a driver has asked for little is evidence too, as far as it is unusual: what he
asks for in 25 m is drawn from the exponential distribution F of his habit, and never more than 80 % of what there is. A
curve that a proof contradicts, or the other way round, is of another road: the hypothesis loses what the two have not
in common.
"""

from collections import deque
from dataclasses import dataclass
from math import log1p
from typing import Final

import numpy as np
from scipy.special import ndtr

from friction_grip.friction_used import GripInUse
from friction_grip.road_prior import GRID, RoadPrior

_SEGMENT: Final = 2.0
"""Length of a segment [m]."""
_SEGMENTS: Final = 48
"""Hypotheses that are kept; the two neighbours that differ least are joined."""
PROOF_SIGMAS: Final = 2.58
"""Deviations by which a proof is below the friction in use: 99.5 % on one side."""
_NO_PROOF: Final = 0.02
"""Deviation of the friction 0 that stands where nothing is proven."""
_DRAW: Final = 25.0
"""Distance over which a driver asks for friction anew [m]."""
_DRAWS: Final = 12.0
"""Most of them that count: on a long way the traffic, and not the road, may be the reason."""
_ASKED: Final = 0.8
"""Share of the friction of a road that a driver asks for at most."""
_HABIT, _HABIT_BEGUN, _HABIT_DISTANCE = 0.12, 200.0, 2000.0
"""Mean friction in use before a driver is known, distance [m] that it counts for, and over which his mean is taken."""
_CURVE_FLOOR: Final = 0.05
"""Deviation of the friction of a road along which a curve was valid, relative."""


@dataclass(frozen=True)
class Proof:
    """A lower bound by measurement alone."""

    mu: float
    distance: float
    """At which it was given [m]."""
    stamp: int
    """[ns]"""


class Proofs:
    """The largest proof within a distance."""

    def __init__(self, kept: float) -> None:
        """Begin without one; `kept`: distance over which a proof counts [m]."""
        self._kept = kept
        self._falling: deque[Proof] = deque()
        """Proofs of which each is larger than all later ones."""

    def reset(self) -> None:
        """Forget all."""
        self._falling.clear()

    def add(self, mu: float, stddev: float, distance: float, stamp: int) -> float:
        """Take friction in use at a distance [m] and a stamp [ns]; return what it proves, 0 where that is nothing."""
        bound = mu - PROOF_SIGMAS * stddev
        if not bound > 0.0:
            return 0.0
        while self._falling and self._falling[-1].mu <= bound:
            self._falling.pop()
        self._falling.append(Proof(bound, distance, stamp))
        return bound

    def largest(self, distance: float) -> Proof | None:
        """Return the largest of those that count at a distance [m], not below those before; None: there is none."""
        while self._falling and distance - self._falling[0].distance > self._kept:
            self._falling.popleft()
        return self._falling[0] if self._falling else None


@dataclass(frozen=True)
class Bounds:
    """What the road is believed to have."""

    lower: float
    upper: float
    """NaN where no curve is known."""
    has_curve: bool
    """Whether a curve is probably of this road."""
    has_proof: bool
    """Whether a force that was felt is probably of this road."""


class RoadMemory:
    """Memory of the road under a car."""

    def __init__(self, prior: RoadPrior, change_distance: float, proof_distance: float, tail: float) -> None:
        """Begin on an unknown road.

        Args:
            prior: shares of roads.
            change_distance: mean distance between changes of the road [m].
            proof_distance: distance over which a proof is kept [m].
            tail: probability that the lower bound leaves out.
        """
        self._prior = prior.density()
        self._change, self._tail = change_distance, tail
        self._proofs = Proofs(proof_distance)
        self._log_grid = np.log(GRID)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.distance = 0.0
        self._gone = 0.0
        self._begun = 0.0
        self._habit = _HABIT
        self._since = np.zeros(1)
        self._weight = np.array([1.0])
        self._proven = np.zeros(1)
        self._stddev = np.full(1, _NO_PROOF)
        self._curve = np.full(1, np.nan)
        self._curve_stddev = np.full(1, np.nan)
        self._proofs.reset()

    def drive(self, distance: float) -> None:
        """Go on by a distance [m]."""
        self.distance += distance
        self._gone += distance
        length = self.distance - self._begun
        if length < _SEGMENT:
            return
        self._begun = self.distance
        self._since = np.append(self._since, self.distance)
        changed = -np.expm1(-length / self._change)
        self._weight = np.append(self._weight * np.exp(log1p(-changed)), changed)
        self._proven, self._stddev = np.append(self._proven, 0.0), np.append(self._stddev, _NO_PROOF)
        self._curve, self._curve_stddev = np.append(self._curve, np.nan), np.append(self._curve_stddev, np.nan)
        if self._weight.size > _SEGMENTS:
            self._join()

    def feel(self, used: GripInUse, stamp: int) -> None:
        """Take the friction in use at a stamp [ns]: the habit of the driver, and proofs of the car and of its axles."""
        self.use(used.vehicle.mu_used)
        for part in (used.vehicle, used.front, used.rear):
            self.prove(part.mu_used, part.stddev, stamp)

    def use(self, mu: float) -> None:
        """Take the friction that the car uses, since the last time: the habit of its driver."""
        share = min(self._gone / min(self.distance + _HABIT_BEGUN, _HABIT_DISTANCE), 1.0)
        self._habit += share * (max(mu, GRID[0]) - self._habit)
        self._gone = 0.0

    def prove(self, mu: float, stddev: float, stamp: int) -> None:
        """Take friction in use, with its deviation, at a stamp [ns]."""
        bound = self._proofs.add(mu, stddev, self.distance, stamp)
        if bound == 0.0:
            return
        more = bound > self._proven - PROOF_SIGMAS * self._stddev
        self._proven[more], self._stddev[more] = mu, stddev

    def take_curve(self, mu_max: float, stddev: float) -> None:
        """Take the friction of a valid curve, with its deviation."""
        self._curve[:] = mu_max
        self._curve_stddev[:] = np.hypot(stddev, _CURVE_FLOOR * mu_max)

    def proof(self) -> Proof | None:
        """Return the largest proof within the distance that is kept, None where there is none."""
        return self._proofs.largest(self.distance)

    def bounds(self) -> Bounds:
        """Return what the road is believed to have."""
        density = self._prior * ndtr((GRID - self._proven[:, None]) / self._stddev[:, None])
        size = density.sum(axis=1)
        draws = np.minimum((self.distance - self._since) / _DRAW, _DRAWS)
        density *= np.exp(-np.outer(draws, np.log(-np.expm1(-_ASKED * GRID / self._habit))))
        known = np.isfinite(self._curve)
        if known.any():
            of_curve = np.exp(-0.5 * ((GRID - self._curve[known, None]) / self._curve_stddev[known, None]) ** 2)
            density[known] *= of_curve
            size[known] = (self._prior * of_curve).sum(axis=1)
        density *= (self._weight / np.maximum(size, 1e-300))[:, None]
        weight = density.sum(axis=1)
        mixed = np.cumsum(density.sum(axis=0))
        lower, upper = np.exp(np.interp([self._tail, 1.0 - self._tail], mixed / mixed[-1], self._log_grid))
        has_curve = bool(weight[known].sum() > 0.5 * weight.sum())
        has_proof = bool(weight[self._proven > GRID[0]].sum() > 0.5 * weight.sum())
        return Bounds(float(lower), float(upper) if has_curve else np.nan, has_curve, has_proof)

    def _join(self) -> None:
        """Join the neighbours whose evidence differs least; what only the older one has is given up."""
        differs = np.isfinite(self._curve[:-1]) != np.isfinite(self._curve[1:])
        at = int(np.argmin(np.where(differs, np.inf, self._proven[:-1] - self._proven[1:])))
        self._weight[at + 1] += self._weight[at]
        for name in ("_since", "_weight", "_proven", "_stddev", "_curve", "_curve_stddev"):
            setattr(self, name, np.delete(getattr(self, name), at))
