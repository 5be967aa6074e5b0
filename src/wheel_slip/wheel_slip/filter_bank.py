"""Bank of Kalman filters of one state, one for each hypothesis (interacting multiple models).

Blom and Bar-Shalom, The interacting multiple model algorithm, IEEE Trans. Automatic Control 33 (1988). A state that is
only considered (Schmidt) is not estimated: what it may do to the others is in their covariance.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class FilterBank:
    """Means x, shape (hypotheses, states), and covariances p, shape (hypotheses, states, states)."""

    def __init__(self, mean: Array, covariance: Array, probabilities: Array, considered: int) -> None:
        """Start all at the same mean (states,) and covariance (states, states).

        Args:
            mean: see x.
            covariance: see p.
            probabilities: of the hypotheses.
            considered: the state that is not estimated.
        """
        self.x: Array = np.stack([mean] * len(probabilities))
        self.p: Array = np.stack([covariance] * len(probabilities))
        self.probabilities = probabilities.copy()
        self._considered = considered
        self.collapse()

    def collapse(self) -> None:
        """Take all hypotheses together."""
        weight = self.probabilities[:, None]
        self.mean: Array = self.probabilities @ self.x
        """Mean of the states, shape (states,)."""
        apart = self.x - self.mean
        self.covariance: Array = (weight[:, None] * self.p).sum(axis=0) + (weight * apart).T @ apart
        """Of them, shape (states, states)."""

    def mix(self, change: Array, source: int, state: int, mean: float, variance: float) -> None:
        """Let the hypotheses change into each other.

        Args:
            change: probabilities [from, to]; the last row is of `source` once more, with a state of its own.
            source: hypothesis.
            state: the state that begins again.
            mean: of that state.
            variance: of that state.
        """
        begun, spread = self.x[source].copy(), self.p[source].copy()
        begun[state], spread[state], spread[:, state] = mean, 0.0, 0.0
        spread[state, state] = variance
        x, p = np.concatenate([self.x, begun[None]]), np.concatenate([self.p, spread[None]])
        joint = change * np.append(self.probabilities, self.probabilities[source])[:, None]
        self.probabilities = joint.sum(axis=0)
        share = (joint / np.maximum(self.probabilities, 1e-300)).T
        self.x = share @ x
        apart = x - self.x[:, None]
        between = (share[:, :, None] * apart).transpose(0, 2, 1) @ apart
        self.p = (share @ p.reshape(x.shape[0], -1)).reshape(self.p.shape) + between

    def hold(self, hypothesis: int, probability: float) -> None:
        """Give a hypothesis a probability that is known otherwise; the rest keep their odds."""
        self.probabilities[hypothesis] = 0.0
        self.probabilities *= (1.0 - probability) / max(float(self.probabilities.sum()), 1e-12)
        self.probabilities[hypothesis] = probability

    def forget(self, state: int, kept: float, towards: float, variance: float) -> None:
        """Let a state go to kept x + (1 - kept) towards; `variance` is what it has when nothing is left of it."""
        self.x[:, state] += (1.0 - kept) * (towards - self.x[:, state])
        self.p[:, state] *= kept
        self.p[:, :, state] *= kept
        self.p[:, state, state] += (1.0 - kept**2) * variance

    def relax(self, states: slice, kept: Array, towards: Array, by: Array, variance: Array, common: int) -> None:
        """Let states x go to kept x + (1 - kept)(towards + by x[common]) with a variance each.

        Shapes (hypotheses, states).
        """
        share = (1.0 - kept) * by
        self.x[:, states] = kept * self.x[:, states] + (1.0 - kept) * towards + share * self.x[:, common, None]
        self.p[:, states] = kept[:, :, None] * self.p[:, states] + share[:, :, None] * self.p[:, None, common]
        self.p[:, :, states] = kept[:, None] * self.p[:, :, states] + share[:, None] * self.p[:, :, common, None]
        self.add(states, variance)

    def add(self, states: slice, variance: Array | float) -> None:
        """Add a variance to each of some states."""
        each = np.arange(self.x.shape[1])[states]
        self.p[:, each, each] += variance

    def doubt(self, h: Array, innovation: Array, sound: Array, before: Array, most: float, lasts: float) -> Array:
        """Return what to add to variances, so that a measurement counts the less, the more it is off from the others.

        Args:
            h: see `correct`.
            innovation: see `correct`.
            sound: variance of each where nothing is wrong with it, shape (hypotheses, measurements).
            before: what was to be added to that before, shape (measurements,).
            most: deviations beyond which something is.
            lasts: for how many measurements that is one error.
        """
        likely = int(self.probabilities.argmax())
        spread = h[likely] @ self.p[likely] @ h[likely].T
        sound = sound[likely]
        variance = sound + before
        for _ in variance:
            inverse = np.linalg.inv(spread + np.diag(variance))
            alone = 1.0 / np.diagonal(inverse)
            expected = alone - variance + sound
            off = np.square(inverse @ innovation[likely] * alone) / (expected * most**2)
            lacking = np.where(off > 1.0, lasts * expected * (off**2 - 1.0) + sound - variance, 0.0)
            worst = int(np.where(lacking > 1e-9 * variance, off, 0.0).argmax())
            if lacking[worst] <= 1e-9 * variance[worst]:
                break
            variance[worst] += lacking[worst]
        return variance - sound

    def correct(self, h: Array, innovation: Array, variance: Array, quiet: float) -> Array:
        """Correct by several measurements, weigh the hypotheses by them, and return their misfits.

        A misfit is the sum of squares of what was off over its deviation, shape (hypotheses,).

        Were the wider hypothesis charged in full for what it allows, where both state more noise than there is, quiet
        alone would speak for the narrower one.

        Args:
            h: derivatives by the states, shape (hypotheses, measurements, states).
            innovation: measured less expected, shape (hypotheses, measurements).
            variance: of the measurements, shape (hypotheses, measurements).
            quiet: their variance where nothing happens, as a share of that.
        """
        ph = self.p @ h.transpose(0, 2, 1)
        spread = h @ ph + variance[:, None] * np.eye(variance.shape[1])
        inverse = np.linalg.inv(spread)
        gain = ph @ inverse
        considered = self._considered
        gain[:, considered] = 0.0
        self.x = self.x + (gain @ innovation[:, :, None])[:, :, 0]
        p = self.p - gain @ ph.transpose(0, 2, 1)
        p[:, considered] = p[:, :, considered]
        self.p = 0.5 * (p + p.transpose(0, 2, 1))
        off = (innovation * (inverse @ innovation[:, :, None])[:, :, 0]).sum(axis=1)
        self.weigh(-0.5 * (off + quiet * np.linalg.slogdet(spread)[1]))
        return off

    def correct_one(self, h: Array, innovation: Array, variance: float) -> None:
        """Correct by one measurement and weigh the hypotheses by it.

        Args:
            h: derivatives by the states, shape (hypotheses, states).
            innovation: measured less expected, shape (hypotheses,).
            variance: of the measurement.
        """
        ph = (self.p @ h[:, :, None])[:, :, 0]
        spread = (h * ph).sum(axis=1) + variance
        gain = ph / spread[:, None]
        gain[:, self._considered] = 0.0
        self.x = self.x + gain * innovation[:, None]
        self.p = self.p - gain[:, :, None] * ph[:, None, :]
        self.p[:, self._considered] = self.p[:, :, self._considered]
        self.weigh(-0.5 * (innovation**2 / spread + np.log(spread)))

    def weigh(self, log_likelihoods: Array) -> None:
        """Weigh the hypotheses by what a measurement says of them."""
        weights = self.probabilities * np.exp(log_likelihoods - log_likelihoods.max())
        self.probabilities = np.maximum(weights / weights.sum(), 1e-12)
