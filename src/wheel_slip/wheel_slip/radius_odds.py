"""Probability that wheels have another tyre than that of the vehicle file.

Radii differ from the file by an error that all have in common, and each by its own: a small one, or the large one of
another tyre. The filter takes every radius for that of another tyre, so that none is ever denied. For each set S of
wheels that may have one, its estimate of the radius errors e, with covariance P, is corrected by what the file says
more than that, and S is weighed by it (Bayes):

    L_S = inv(R_S) - inv(R),    M_S = inv(1 + L_S P) L_S,    e_S = e - P M_S e,    P_S = P - P M_S P
    log p(S) = log prior(S) + (log|R| - log|R_S| - log|1 + L_S P| - e' M_S e) / 2

in which R_S is the covariance of the errors that the file states and R that of the filter.
"""

from itertools import product

import numpy as np
from numpy.typing import NDArray

from wheel_slip.motion_noise import MotionNoise

Array = NDArray[np.float64]


class RadiusOdds:
    """Of one car."""

    def __init__(self, common: float, apart: Array, noise: MotionNoise) -> None:
        """Take what the file states, as shares.

        Args:
            common: deviation of the error that all radii have alike.
            apart: that of each alone, shape (wheels,).
            noise: how often and how far off another tyre is.
        """
        count, apart = len(apart), np.hypot(apart, noise.radius_walk)
        other = np.array(list(product([False, True], repeat=count)))
        own = np.where(other, np.hypot(apart, noise.another_radius), apart)
        stated = common**2 + np.square(own)[:, :, None] * np.eye(count)
        self.prior: Array = stated[-1]
        """Covariance of the errors with which the filter begins, shape (wheels, wheels)."""
        self._other = other
        self._more = np.linalg.inv(stated) - np.linalg.inv(stated[-1])
        share = np.where(other, noise.another_tyre, 1.0 - noise.another_tyre)
        self._before = np.log(share).sum(axis=1) - 0.5 * np.linalg.slogdet(stated)[1]

    def tell(self, mean: Array, covariance: Array) -> tuple[Array, Array, Array]:
        """Return an estimate with what the file says: mean, covariance, and probability of another tyre per wheel.

        Args:
            mean: of states that end with the radius errors, shape (states,).
            covariance: of them, shape (states, states).
        """
        count = self._other.shape[1]
        p, error = covariance[-count:, -count:], mean[-count:]
        grown = np.eye(count) + self._more @ p
        m = np.linalg.solve(grown, self._more)
        moved = m @ error
        log = self._before - 0.5 * (np.linalg.slogdet(grown)[1] + moved @ error)
        weight = np.exp(log - log.max())
        weight /= weight.sum()
        expected = weight @ moved
        apart = moved - expected
        by = covariance[:, -count:]
        middle = (weight @ m.reshape(weight.size, -1)).reshape(count, count) - (weight * apart.T) @ apart
        return mean - by @ expected, covariance - by @ middle @ by.T, weight @ self._other
