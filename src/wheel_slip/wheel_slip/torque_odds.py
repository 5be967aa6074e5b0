"""Probability that the brakes' torques are not those that brake the car.

What the accelerometer feels beside the drag and the torques is the engine's force E and a share w of the braking that
torques miss, as pads are not those of the vehicle file, or as a pressure is not read at all:

    pull - braked = E + w pull + n

A Kalman filter follows both, and what it finds of w alone is m, with variance q. Where all torques are right w is that
of the pads; where one is wrong it is anything from nothing to its wheel's share of the braking, at most s; where the
accelerometer is wrong, anything about 1. Were torques right, the wheels would have shown by now that the accelerometer
is wrong with probability a, which was A before:

    p(data | right) = ((1 - a) N(m; 0, q + s_pads^2) + a N(m; 0, q + 1)) A / max(a, A)
    p(data | wrong) = exp(-X) (Phi((s - m) / q^1/2) - Phi(-m / q^1/2)) / s

in which X is by how much wheels contradict an accelerometer that is right where torques are wrong, and jumps of it.
A / a is the price of an explanation that needs a fault of the accelerometer.
"""

from math import exp, isfinite, log, nan, sqrt
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from wheel_slip.motion_noise import MotionNoise

Array = NDArray[np.float64]


class TorqueOdds:
    """Of one car."""

    def __init__(self, noise: MotionNoise) -> None:
        """Start with what pads and engines are like."""
        self._noise = noise
        self._prior = noise.fault_time / noise.fault_every
        self._told = 0.0
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._begin(0.0, self._noise.engine**2)
        self._braked, self._trusted, self._contradicted, self._before = nan, 0.0, 0.0, self._prior
        self.judges = False
        """Whether brakes are on."""

    @property
    def wrong(self) -> float:
        """Probability that they are wrong."""
        return self._more_likely(self._told + self._trusted - self._contradicted)

    @property
    def known(self) -> bool:
        """Whether there are torques."""
        return isfinite(self._braked)

    def contradict(self, excess: float) -> None:
        """Take by how much squares of what is off without torques exceed their number."""
        if self.judges:
            self._contradicted += max(0.5 * excess, 0.0)

    def update(self, dt: float, pull: float, braked: float, misread: float) -> None:
        """Take a step.

        Args:
            dt: its length [s].
            pull: braking of the car by all its tyres, as it was felt [m/s^2].
            braked: the same by the torques [m/s^2], NaN where they are unknown.
            misread: probability that the accelerometer is wrong, by the wheels and if the torques are right.
        """
        p = self._noise
        self._contradicted *= exp(-dt / p.fault_time)
        variance = p.acceleration**2 + (p.pressure_delay * (braked - self._braked) / dt) ** 2
        self._braked = braked
        self.judges = isfinite(variance) and (braked > p.engine or pull > 3.0 * p.engine)
        if not self.judges:  # the pedals change, and with them the engine's force
            self._trusted = log(max(1.0 - misread, 1e-9))
            self._before = self._prior + exp(-dt / p.fault_time) * (self._more_likely(self._told) - self._prior)
            self._begin(*((pull - braked, variance) if isfinite(variance) else (0.0, p.engine**2)))
            return
        kept = exp(-dt / p.engine_time)
        self._x[0] *= kept
        self._p[0] *= kept
        self._p[:, 0] *= kept
        self._p[0, 0] += (1.0 - kept**2) * p.engine**2
        h = np.array([1.0, max(pull, 0.0)])
        by = self._p @ h
        expected = float(h @ by) + variance * max(p.correlation / dt, 1.0)
        off = pull - braked - float(h @ self._x)
        # A jump that neither engine nor pads explain is one of the accelerometer.
        self._contradicted += 0.5 * max(off**2 / expected - p.surprise**2, 0.0)
        self._x += by / expected * off
        self._p -= np.outer(by, by) / expected
        # What the samples show of w, without the prior of the filter.
        known = float(self._p[1, 1])
        shown = max(1.0 - known / p.missed**2, 1e-9)
        q, m = known / shown, float(self._x[1]) / shown
        of_share = NormalDist(m, sqrt(q))
        right, other = [NormalDist(0.0, sqrt(q + variance)).pdf(m) for variance in (p.brakes**2, 1.0)]
        wrong = (of_share.cdf(p.missed) - of_share.cdf(0.0)) / p.missed
        likely = max(misread / self._prior, 1.0)
        self._told = log(max(wrong, 1e-30)) - log(max(((1.0 - misread) * right + misread * other) / likely, 1e-30))

    def _more_likely(self, odds: float) -> float:
        """Return the probability from before with so many logarithmic odds more."""
        odds += log(self._before / (1.0 - self._before))
        return 1.0 / (1.0 + exp(-min(max(odds, -20.0), 20.0)))

    def _begin(self, engine: float, variance: float) -> None:
        """Begin a braking with a force of the engine [m/s^2] of some variance, and any share missed."""
        self._x, self._p = np.array([engine, 0.0]), np.diag([variance, self._noise.missed**2])
        self._told = 0.0
