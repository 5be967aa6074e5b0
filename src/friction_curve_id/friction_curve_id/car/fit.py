"""Gauss-Newton fit of one family of curves to the samples of a braking, with all nuisances.

The cost is that of the wheel equations, whitened by their tridiagonal covariance, of the car's balance, and of the
prior in z = (unknown - mean) / stddev, with what older samples said as a quadratic in z.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpotrf, dpotri, dpotrs, dpttrf, dpttrs

from friction_curve_id.car.braking_samples import BrakingSamples
from friction_curve_id.car.car_balance import car_balance
from friction_curve_id.car.car_model import CarConstants, Carried, Motion, Nodes, carried_over, motion, recursion
from friction_curve_id.car.curve_family import Family
from friction_curve_id.car.node_signals import Start, delayed
from friction_curve_id.car.prior import Prior
from friction_curve_id.car.unknowns import Unknown
from friction_curve_id.car.wheel_equation import WheelEquation, wheel_equation

Array = NDArray[np.float64]

LOAD_VARIATIONS = np.array([0.002, 0.005, 0.01, 0.015, 0.02, 0.03, 0.04, 0.055, 0.075, 0.11])
"""Values that the variation of the wheel load may take [-]."""
_LOAD_CORRELATION = 0.02
_DRIFTS = {Unknown.SLOPE: 0.1, Unknown.START_SPEED: 0.05}
"""Standard deviation by which the road's slope [m/s^2] and the speed [m/s] leave the model within a second."""


@dataclass(frozen=True)
class Quadratic:
    """0.5 d^T information d + gradient^T d, d = z - reference."""

    information: Array
    gradient: Array
    reference: Array
    spread: Array
    """What the information has to grow by, as variance of its gradient: load noise is coloured, shape (P, P)."""
    log_likelihood: float = 0.0


@dataclass(frozen=True)
class Linearised:
    """The cost about the present unknowns."""

    information: Array
    """Matrix in z, shape (P, P)."""
    gradient: Array
    """Shape (P,)."""
    spread: Array
    """Variance of the gradient by the colour of the load noise, shape (P, P)."""
    cost: float
    """- ln likelihood, without constants."""
    moved: Motion


class CurveFit:
    """One family of curves."""

    def __init__(self, car: CarConstants, prior: Prior, family: Family, torque_stddev: float, balanced: bool) -> None:
        """Begin at the prior."""
        self.family = family
        self._car, self._prior = car, prior
        self._torque_stddev, self._balanced = torque_stddev, balanced
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        n = self._prior.mean.size
        self.z = np.zeros(n)
        self.load_variation = 4
        self.past = Quadratic(np.zeros((n, n)), np.zeros(n), np.zeros(n), np.zeros((n, n)))
        self.covariance = np.diag(self._prior.stddev**2)
        self.log_evidence = 0.0
        self.steps = 0
        self.carried = Carried()
        self._damping = 0.0
        self._last_move = np.zeros(n)

    @property
    def unknowns(self) -> Array:
        """Present estimate, shape (P,)."""
        return self._prior.mean + self._prior.stddev * self.z

    @property
    def known_to(self) -> Array:
        """Deviations of the prior, shape (P,)."""
        return self._prior.stddev

    @property
    def surprise(self) -> float:
        """Sum of the squares of the unknowns, each in deviations of its prior."""
        return float(self.z @ self.z)

    def linearise(self, samples: BrakingSamples, nodes: Nodes, start: Start, adapt: bool = True) -> Linearised:
        """Linearise about the present estimate; `adapt`: move the load variation towards its likelihood's maximum."""
        p, sd = self.unknowns, self._prior.stddev
        moved = motion(self._car, nodes, p, self.carried)
        torque, rate = delayed(samples, nodes, start, float(p[Unknown.PRESSURE_DELAY]))
        equation = wheel_equation(self._car, nodes, moved, torque, rate, self.family, p, self._torque_stddev)
        if adapt:
            self._adapt(equation, nodes)
        pivots, factors, log_determinant = _factorised(equation, nodes, LOAD_VARIATIONS[self.load_variation])
        size = p.size
        columns = np.empty((equation.error.size, size + 1), order="F")
        columns[:, :size] = equation.jacobian.reshape(-1, size)
        columns[:, :size] *= sd
        columns[:, size] = equation.error.ravel()
        white, _ = dpttrs(pivots, factors, columns)
        full = columns.T @ white
        cost = 0.5 * float(full[size, size]) + 0.5 * log_determinant
        variation = LOAD_VARIATIONS[self.load_variation]
        spread = _spread(white[:, :size], variation * np.sqrt(equation.load_variance), nodes.interval)
        if self._balanced:
            inertia = self._car.inertia * np.exp(p[Unknown.LOG_INERTIA])
            names = [Unknown.LOG_GAIN_FRONT, Unknown.LOG_GAIN_REAR, Unknown.PRESSURE_DELAY, Unknown.ENGINE_DRAG]
            of_torque = equation.jacobian[:, :, names] * inertia[:, :, np.newaxis]
            errors, rows = car_balance(self._car, nodes, moved, equation.torque, of_torque, p)
            rows = rows * sd
            full[:size, :size] += rows.T @ rows
            full[:size, size] += rows.T @ errors
            cost += 0.5 * float(errors @ errors)
        return Linearised(full[:size, :size], full[:size, size], spread, cost, moved)

    def step(self, samples: BrakingSamples, nodes: Nodes, start: Start) -> float:
        """Make a Gauss-Newton step; return its length in ln lambda_max and ln mu_max."""
        at = self.linearise(samples, nodes, start)
        size = self.z.size
        past = self.past
        offset = self.z - past.reference
        information = at.information + past.information
        information[np.diag_indices(size)] += 1.0
        gradient = at.gradient + past.gradient + past.information @ offset + self.z
        lower, info = dpotrf(information, lower=1)
        if info != 0:
            raise np.linalg.LinAlgError("the fit is not determined")
        damped = lower
        if self._damping > 0.0:
            stiff = information.copy()
            stiff[np.diag_indices(size)] += self._damping
            damped, _ = dpotrf(stiff, lower=1)
        move, _ = dpotrs(damped, -gradient, lower=1)
        inverse, _ = dpotri(lower, lower=1)
        inverse = np.tril(inverse) + np.tril(inverse, -1).T
        sd = self._prior.stddev
        inverse += inverse @ (at.spread + past.spread) @ inverse
        self.covariance = inverse * np.outer(sd, sd)
        before = float(offset @ (0.5 * past.information @ offset + past.gradient)) + 0.5 * float(self.z @ self.z)
        self.cost = at.cost + before - past.log_likelihood
        self.log_evidence = -self.cost - float(np.log(np.diag(lower)).sum())
        curve = float(np.abs(move[:2] * sd[:2]).max())
        longest = max(curve / 0.4, float(np.abs(move[2:]).max()) / 1.5, 1.0)
        move /= longest
        # Steps that turn back overshoot: damp them.
        last = self._last_move
        lengths = float(np.sqrt((move @ move) * (last @ last)))
        turned = lengths > 0.0 and float(move @ last) < -0.3 * lengths
        self._damping = max(3.0 * self._damping, 3.0) if turned else 0.3 * self._damping
        if self._damping < 0.1:
            self._damping = 0.0
        self._last_move = move
        self.z = self.z + move
        self.steps += 1
        self.moved = at.moved
        return curve

    def fold(self, samples: BrakingSamples, nodes: Nodes, start: Start, number: int, memory: float) -> None:
        """Keep what the oldest `number` nodes say as a quadratic; `memory`: share kept of what was said before."""
        at = self.linearise(samples, nodes.subset(slice(0, number)), start, adapt=False)
        past, offset = self.past, self.z - self.past.reference
        gradient = memory * (past.gradient + past.information @ offset) + at.gradient
        said = float(offset @ (0.5 * past.information @ offset + past.gradient))
        likelihood = memory * (past.log_likelihood - said) - at.cost
        duration = float(nodes.interval[:number].sum())
        information = memory * past.information + at.information
        for unknown, rate in _DRIFTS.items():
            if self._prior.stddev[unknown] > 0.0:
                information, gradient = _loosened(
                    information, gradient, unknown, (rate / float(self._prior.stddev[unknown])) ** 2 * duration
                )
        self.past = Quadratic(
            information,
            gradient,
            self.z.copy(),
            memory * past.spread + at.spread,
            likelihood,
        )
        moved = motion(self._car, nodes.subset(slice(0, number + 1)), self.unknowns, self.carried)
        self.carried = carried_over(nodes, moved, self.carried, number)

    def _adapt(self, equation: WheelEquation, nodes: Nodes) -> None:
        """Move the load variation by at most a step towards the maximum of its likelihood."""
        here = self.load_variation
        candidates = [each for each in (here - 1, here, here + 1) if 0 <= each < LOAD_VARIATIONS.size]
        costs = []
        error = equation.error.ravel()
        for each in candidates:
            pivots, factors, log_determinant = _factorised(equation, nodes, LOAD_VARIATIONS[each])
            white, _ = dpttrs(pivots, factors, error)
            costs.append(float(error @ white) + log_determinant)
        self.load_variation = candidates[int(np.argmin(costs))]


def _factorised(equation: WheelEquation, nodes: Nodes, load_variation: float) -> tuple[Array, Array, float]:
    """Factorise the covariance of the errors; wheel after wheel."""
    noise = nodes.wheel_noise**2
    per = 1.0 / nodes.interval
    diagonal = (
        equation.fixed_variance
        + load_variation**2 * equation.load_variance
        + (noise[:, 1:] + noise[:, :-1]) * (per * per)
    )
    off = np.zeros_like(diagonal)
    off[:, :-1] = -noise[:, 1:-1] * (per[1:] * per[:-1])
    pivots, factors, info = dpttrf(diagonal.ravel(), off.ravel()[:-1])
    if info != 0:
        raise np.linalg.LinAlgError("the covariance is not positive definite")
    return pivots, factors, float(np.log(pivots).sum())


def _loosened(information: Array, gradient: Array, index: int, variance: float) -> tuple[Array, Array]:
    """Return the quadratic after unknown `index` has moved by a random step of this variance in z."""
    column = information[:, index]
    gain = column * (variance / (1.0 + variance * column[index]))
    return information - np.outer(gain, column), gradient - gain * gradient[index]


def _spread(white: Array, load_stddev: Array, interval: Array) -> Array:
    """Variance of the gradient that is due to the correlation of the load noise, shape (P, P).

    The load of a wheel varies below 15 Hz; noise with the correlation exp(-|t| / 0.02 s) has the covariance D R D.

    Args:
        white: C^-1 J, shape (W n, P).
        load_stddev: D, standard deviation of e by the load [rad/s^2], shape (W, n).
        interval: of the nodes [s], shape (n,).
    """
    wheels, n = load_stddev.shape
    scaled = white.reshape(wheels, n, -1) * load_stddev[:, :, np.newaxis]
    by_node = np.asfortranarray(scaled.transpose(1, 0, 2).reshape(n, -1))
    keep = np.exp(-interval[1:] / _LOAD_CORRELATION)
    earlier = recursion(keep, by_node) - by_node  # what correlates with each node before it
    cross = by_node.reshape(n * wheels, -1).T @ earlier.reshape(n * wheels, -1)
    return np.asarray(cross + cross.T)
