"""Evidence of samples that have left the window, and how it fades.

A quadratic in the unknowns x = (q, u, omega of the oldest sample), shape (5,), about the point at which the samples
were folded together:  cost = 0.5 d^T information d + gradient^T d,  d = x - reference.
"""

from dataclasses import dataclass
from math import exp

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MOMENTUM = 3
"""Index of u in x."""
WHEEL_SPEED = 4
"""Index of omega in x."""
_FORGOTTEN = 1e-3
"""Evidence that has faded to this share is dropped."""


@dataclass(frozen=True)
class PastEvidence:
    """The quadratic above: information, gradient and reference, shapes (5, 5), (5,), (5,)."""

    information: Array
    gradient: Array
    reference: Array

    def gradient_at(self, x: Array) -> Array:
        """d cost / d x at `x`, shape (5,)."""
        return np.asarray(self.gradient + self.information @ (x - self.reference))

    def cost_at(self, x: Array) -> float:
        """Cost at `x`, shape (5,)."""
        d = x - self.reference
        return float(d @ (0.5 * (self.information @ d) + self.gradient))

    def loosened(self, index: int, variance: float) -> "PastEvidence":
        """Return the evidence after unknown `index` has moved by a random step of this variance."""
        column = self.information[:, index]
        gain = column * (variance / (1.0 + variance * column[index]))
        information = self.information - np.outer(gain, column)
        gradient = self.gradient - gain * self.gradient[index]
        return PastEvidence(information, gradient, self.reference)

    def aged(self, duration: float, memory: float) -> "PastEvidence":
        """Return the evidence `duration` [s] later, weighted by exp(-duration / memory); dropped once that is tiny."""
        share = exp(-duration / memory)
        if share < _FORGOTTEN:
            return no_evidence()
        return PastEvidence(share * self.information, share * self.gradient, self.reference)

    def without(self, index: int) -> "PastEvidence":
        """Return the evidence after unknown `index` has moved by an unknown amount: it is eliminated."""
        column = self.information[:, index]
        if not column[index] > 0.0:
            return self
        gain = column / column[index]
        information = self.information - np.outer(gain, column)
        information[index] = information[:, index] = 0.0
        gradient = self.gradient - gain * self.gradient[index]
        return PastEvidence(information, gradient, self.reference)


def no_evidence() -> PastEvidence:
    """Return evidence that holds no information."""
    return PastEvidence(np.zeros((5, 5)), np.zeros(5), np.zeros(5))


def momentum_evidence(speed: float, variance: float) -> PastEvidence:
    """Return evidence on u alone: `speed` [m/s] with this variance."""
    evidence = no_evidence()
    evidence.information[MOMENTUM, MOMENTUM] = 1.0 / variance
    evidence.reference[MOMENTUM] = speed
    return evidence
