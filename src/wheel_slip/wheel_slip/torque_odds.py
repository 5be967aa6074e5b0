"""Probability that the brakes' torques are not those that brake the car.

What the accelerometer feels beside the drag and the torques is the engine's force E and a share w of the braking that
torques miss, as pads are not those of the vehicle file, or as a pressure is not read at all:

    pull - braked = E + w pull + n

A Kalman filter takes w for that of a wrong torque, so that none is ever denied. With its estimate w and variance P, and
s as the deviation of w, positive only where a torque is wrong, the odds that all are right are (Savage and Dickey)

    exp(X) N(m; 0, q + s_pads^2) p_right / (2 Phi(w / P^1/2) N(m; 0, q + s_wrong^2) p_wrong)
    1/q = 1/P - 1/s_wrong^2,    m = w q/P

in which X is by how much wheels contradict an accelerometer that is right where torques are wrong.
"""

from math import erf, exp, isfinite, log, nan, sqrt

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
        self._braked, self._contradicted, self._before = nan, 0.0, self._prior
        self.judges = False
        """Whether brakes are on."""

    @property
    def wrong(self) -> float:
        """Probability that they are wrong."""
        return self._more_likely(self._told - self._contradicted)

    @property
    def known(self) -> bool:
        """Whether there are torques."""
        return isfinite(self._braked)

    def contradict(self, excess: float) -> None:
        """Take by how much squares of what is off without torques exceed their number."""
        if self.judges:
            self._contradicted += max(0.5 * excess, 0.0)

    def update(self, dt: float, pull: float, braked: float) -> None:
        """Take a step of some length [s]: braking by all tyres as felt, and by the torques, NaN if unknown [m/s^2]."""
        p = self._noise
        self._contradicted *= exp(-dt / p.fault_time)
        variance = p.acceleration**2 + (p.pressure_delay * (braked - self._braked) / dt) ** 2
        self._braked = braked
        self.judges = isfinite(variance) and (braked > p.engine or pull > 3.0 * p.engine)
        if not self.judges:  # the pedals change, and with them the engine's force
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
        gain = by / (h @ by + variance * max(p.correlation / dt, 1.0))
        self._x += gain * (pull - braked - h @ self._x)
        self._p -= np.outer(gain, by)
        missed, known = float(self._x[1]), float(self._p[1, 1])
        told = max(1.0 - known / p.missed**2, 1e-9)
        q, m = known / told, missed / told
        right, wrong = q + p.brakes**2, q + p.missed**2
        self._told = 0.5 * (m**2 / right - m**2 / wrong + log(right / wrong))
        self._told += log(1.0 + erf(missed / sqrt(2.0 * known)) + 1e-12)

    def _more_likely(self, odds: float) -> float:
        odds += log(self._before / (1.0 - self._before))
        return 1.0 / (1.0 + exp(-min(max(odds, -20.0), 20.0)))

    def _begin(self, engine: float, variance: float) -> None:
        """Begin a braking with a force of the engine [m/s^2] of some variance, and any share missed."""
        self._x, self._p = np.array([engine, 0.0]), np.diag([variance, self._noise.missed**2])
        self._told = 0.0
