"""One curve from the fits of several families: their mixture, weighed by evidence.

The weights follow the evidence of each family in Laplace's approximation, plus a share that each keeps: the true tyre
is of neither family, and without it the evidence would be sure of the wrong one.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import erf, exp, expm1, hypot, sqrt

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.car.unknowns import Unknown

Array = NDArray[np.float64]

_KEPT, _UNSEEN_KEPT = 0.1, 0.15
"""Share that each family keeps; while the peak has not been seen, no family alone makes a probability of 0.9."""
LAMBDA_FLOOR = 0.04
SEEN_FACTOR = 1.1
"""Factor of the deviations of lambda_max: on random cars of a plant of its own the fit is that much too sure."""
_MU_FLOOR = 0.005
UNSEEN_FACTOR = 2.0
"""Factor of all deviations while the peak has not been seen: it is an extrapolation by a formula.

Of that of mu_max also where the fits have gone astray, as little is left of the time before.
"""
UNSEEN_FLOOR = 0.1
_UNRESOLVED = 2.0
"""Relative deviation of lambda_max over the square of the mean step of slip over lambda_max near the peak."""
UNRESOLVED_HEIGHT = 0.1
"""Relative deviation of mu_max over that of lambda_max by the same."""
_NEAR_PEAK = (0.6, 1.4)
"""Slip over lambda_max near the peak."""
_INTERVAL = 1.96
"""Deviations of a 95 % interval."""
_NOTHING_KNOWN = 20.0
"""Exponent at which an interval has no end that means anything."""
_STILL_TO_GO = 2.0
"""What a fit still has to go over its last step: steps that halve."""


@dataclass(frozen=True)
class Peak:
    """Peak of the mixture."""

    log_lambda_max: float
    log_mu_max: float
    log_lambda_stddev: float
    log_mu_stddev: float
    weights: tuple[float, ...]
    """Of the families, sum 1."""

    @property
    def likeliest(self) -> int:
        """Number of the family with the largest weight."""
        return self.weights.index(max(self.weights))


def doubt(seen: bool, formula_known: bool) -> tuple[float, float]:
    """Factor and floor of the relative deviation of lambda_max, for what a formula leaves out."""
    if formula_known:
        return 1.0, 0.0
    return (SEEN_FACTOR, LAMBDA_FLOOR) if seen else (UNSEEN_FACTOR, UNSEEN_FLOOR)


def mixture(
    unknowns: list[Array],
    covariances: list[Array],
    log_evidence: list[float],
    mu_floor: float,
    seen: bool,
    unsettled: Sequence[float] = (),
    gone_astray: bool = False,
) -> Peak:
    """Mix the peaks of the families.

    Args:
        unknowns: estimates of the families, shape (P,) each.
        covariances: their covariances, shape (P, P) each.
        log_evidence: ln of their evidence.
        mu_floor: least relative deviation of mu_max that the car leaves besides.
        seen: whether the slips have been beyond the peak.
        unsettled: last step of each family in ln mu_max: a fit that moves is not known to better than that.
        gone_astray: whether the fits have been: their evidence is not believed, and any of them may be right.
    """
    best = max(log_evidence)
    raw = [exp(max(each - best, -50.0)) for each in log_evidence]
    total = sum(raw)
    count = len(raw)
    kept = _KEPT if seen else _UNSEEN_KEPT
    weights = [(each / total + kept) / (1.0 + count * kept) for each in raw] if count > 1 else [1.0]
    found = []
    of_lambda = doubt(seen, count == 1)
    of_mu = (1.0, mu_floor)
    if count > 1:
        of_mu = (1.0 if seen and not gone_astray else UNSEEN_FACTOR, hypot(_MU_FLOOR, mu_floor))
    for index, (factor, floor) in ((Unknown.LOG_LAMBDA_MAX, of_lambda), (Unknown.LOG_MU_MAX, of_mu)):
        values = [float(each[index]) for each in unknowns]
        mean = sum(w * value for w, value in zip(weights, values, strict=True))
        variance = sum(
            w * (float(c[index, index]) + (value - mean) ** 2)
            for w, value, c in zip(weights, values, covariances, strict=True)
        )
        apart = max(values) - min(values) if gone_astray else 0.0
        found.append((mean, hypot(factor * sqrt(variance), floor, apart)))
    moving = sqrt(sum(w * step**2 for w, step in zip(weights, unsettled or [0.0] * count, strict=True)))
    return Peak(found[0][0], found[1][0], found[0][1], hypot(found[1][1], _STILL_TO_GO * moving), tuple(weights))


def unresolved(slip: Array, lambda_max: float) -> float:
    """Relative deviation of lambda_max by what the curve does between two samples, where slip goes fast over the peak.

    Args:
        slip: of the tyres at the samples [-], shape (W, n).
        lambda_max: peak [-].
    """
    x = slip / lambda_max
    step, middle = np.diff(x, axis=1), 0.5 * (x[:, 1:] + x[:, :-1])
    rising = step[(middle > _NEAR_PEAK[0]) & (middle < _NEAR_PEAK[1]) & (step > 0.0)]
    return _UNRESOLVED * float((rising**2).mean()) if rising.size else 0.0


def reaching_up(log_stddev: float) -> float:
    """Relative standard deviation whose 95 % interval reaches as far up as that of a deviation in ln; always finite."""
    return expm1(min(_INTERVAL * log_stddev, _NOTHING_KNOWN)) / _INTERVAL


def normal_probability(deviations: float) -> float:
    """Probability that a standard normal number is below `deviations`."""
    return 0.5 * (1.0 + erf(deviations / sqrt(2.0)))
