"""Gauss-Newton fit of one family of curves to the samples of a braking, with all nuisances.

The cost is that of the wheel equations, whitened, of the car's balance, and of the prior in z = (unknown - mean) /
stddev, with what older samples said as a quadratic in z.
"""

from dataclasses import dataclass, replace
from math import exp, inf, log, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpotrf, dpotri, dpotrs

from friction_curve_id.car.braking_samples import BrakingSamples
from friction_curve_id.car.car_balance import OF_TORQUE, car_balance
from friction_curve_id.car.car_constants import CarConstants
from friction_curve_id.car.car_model import Carried, Motion, carried_over, motion
from friction_curve_id.car.combined_slip import TyreSlips, share_across, tyre_slips
from friction_curve_id.car.curve_family import Family
from friction_curve_id.car.memory import Quadratic, drifted, forgotten
from friction_curve_id.car.node_signals import Nodes, Start, delayed
from friction_curve_id.car.prior import Prior
from friction_curve_id.car.rear_slip import rear_slip
from friction_curve_id.car.unknowns import OF_CURVE, OF_CURVES, Unknown
from friction_curve_id.car.wheel_equation import EquationNoise, wheel_equation

Array = NDArray[np.float64]

_OF_START = [Unknown.START_SPEED]
"""Unknowns whose prior is that of the start of a braking: what drifts since takes them along."""
_LONGEST_OF_CURVE, _LONGEST = 0.4, 1.0
"""Longest step in ln mu_max and ln lambda_max, and of any other unknown, in deviations of its prior."""
_LEAST_SCATTER = 1e-9
"""Of the sum of the squared unknowns, where nothing is found."""
_OF_FRICTION = 0.5
"""Standard deviation of a car's lateral acceleration while it brakes, over what the friction across allows [-]."""
_KEPT_OF_CAR = 0.25
"""Share of what is known of the car that is kept on another road: what the formula of the first left out is in it."""


@dataclass(frozen=True)
class Linearised:
    """The cost about the present unknowns."""

    information: Array
    """Matrix in z, shape (P, P)."""
    gradient: Array
    """Shape (P,)."""
    cost: float
    """- ln likelihood, without constants."""
    moved: Motion
    tyres: TyreSlips
    noise: EquationNoise
    factor: Array
    """Of the covariance of the errors."""
    white: Array
    """Jacobian in z by the unknowns that act and, last, the error, whitened, shape (W n, A + 1)."""
    acting: NDArray[np.int64]
    """Unknowns that move the wheel equations, shape (A,)."""
    of_node: Array
    """What each node adds to the cost of those before it, of all wheels, shape (n,)."""


class CurveFit:
    """One family of curves."""

    def __init__(self, car: CarConstants, prior: Prior, family: Family, torque_stddev: float, balanced: bool) -> None:
        """Begin at the prior."""
        self.family = family
        self._car, self._prior = car, prior
        self._torque_stddev, self._balanced = torque_stddev, balanced
        self._curving = np.flatnonzero(prior.stddev > 0.0)
        self._acting = self._curving[~np.isin(self._curving, OF_CURVES)]
        self._lasting = np.ones(prior.mean.size)
        self._lasting[_OF_START] = 0.0
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        n = self._prior.mean.size
        self.z = np.zeros(n)
        self.load_variation = 2
        self.past = self._of_start()
        self.covariance = np.diag(self._prior.stddev**2)
        self.log_evidence = 0.0
        self._node_time = self._of_node = np.zeros(0)
        self.steps = 0
        self.carried = Carried()
        self._correction = np.zeros((self._car.wheels, 0))
        self._across: Array | None = None
        self._damping = 0.0
        self._last_move = np.zeros(n)
        self._expected, self._scatter = 0.0, inf
        self.unsettled = 0.0
        """Length of the last full step in ln mu_max."""
        self.promise = 0.0
        """By how much the last step was to lower the cost: small where the fit has arrived."""

    @property
    def unknowns(self) -> Array:
        """Present estimate, shape (P,)."""
        return self._prior.mean + self._prior.stddev * self.z

    @property
    def surprise(self) -> float:
        """How far the sum of the squared unknowns is above what the prior lets expect, in its deviations.

        Each is in deviations of its prior; what is found of them has the covariance I - S, S: that of what is left.
        """
        return (self._squares() - self._expected) / self._scatter

    @property
    def newest(self) -> float:
        """Time of the newest node of the last step [s]."""
        return float(self._node_time[-1]) if self._node_time.size else 0.0

    def log_evidence_until(self, time: float) -> float:
        """Log evidence without the nodes later than `time` [s]: fits in turn have not seen the same nodes."""
        return self.log_evidence + float(self._of_node[self._node_time > time + 1e-6].sum())

    def linearise(self, samples: BrakingSamples, nodes: Nodes, start: Start, adapt: bool = True) -> Linearised:
        """Linearise about the present estimate; `adapt`: move the load variation towards its likelihood's maximum."""
        p, sd = self.unknowns, self._prior.stddev
        # Slips are taken at the wheel speeds that the last step found, not at the measured ones: the curve bends, and
        # their noise would be in the residual and in its derivatives alike.
        correction = self._at_nodes(nodes)
        across = self._across_at(nodes.time.size)
        moved = motion(self._car, replace(nodes, wheel_speed=nodes.wheel_speed + correction), p, self.carried, across)
        torque, rate = delayed(samples, nodes, start, float(p[Unknown.PRESSURE_DELAY]))
        tyres = tyre_slips(self._car, nodes, moved, torque, self.family, p, across)
        equation = wheel_equation(self._car, nodes, moved, torque, rate, tyres, p, self._torque_stddev)
        error = equation.error - equation.by_wheel_speed * correction
        noise = EquationNoise(nodes, equation, self.carried.slip is not None)
        if adapt:
            self.load_variation, factor = noise.adapted(error, self.load_variation)
        else:
            factor = noise.factor(self.load_variation)
        size, acting = p.size, self._curving if tyres.across is not None else self._acting
        columns = np.empty((error.size, acting.size + 1), order="F")
        jacobian = equation.jacobian.reshape(-1, size)
        for column, unknown in enumerate(acting):
            np.multiply(jacobian[:, unknown], sd[unknown], out=columns[:, column])
        columns[:, -1] = error.ravel()
        white = noise.whitened(factor, columns)
        products = white.T @ white
        full = np.zeros((size, size + 1))
        among = np.ix_(acting, acting)
        full[among], full[acting, size] = products[:-1, :-1], products[:-1, -1]
        each = 0.5 * white[:, -1] ** 2 + np.log(factor[0])
        cost = float(each.sum())
        of_node = each.reshape(error.shape).sum(axis=0)
        if self._balanced:
            inertia = self._car.inertia * np.exp(p[Unknown.LOG_INERTIA])
            of_torque = equation.jacobian[:, :, OF_TORQUE] * inertia[:, :, np.newaxis]
            errors, rows = car_balance(self._car, nodes, moved, tyres, equation.torque, of_torque, p)
            if equation.across_gradient is not None:
                found = rear_slip(self._car, nodes, moved, tyres, equation.across_gradient, p)
                errors, rows = np.concatenate([errors, found[0]]), np.concatenate([rows, found[1]])
            rows = rows * sd
            full[:, :size] += rows.T @ rows
            full[:, size] += rows.T @ errors
            cost += 0.5 * float(errors @ errors)
        return Linearised(full[:, :size], full[:, size], cost, moved, tyres, noise, factor, white, acting, of_node)

    def step(self, samples: BrakingSamples, nodes: Nodes, start: Start) -> float:
        """Make a Gauss-Newton step; return its length in ln lambda_max and ln mu_max."""
        at = self.linearise(samples, nodes, start)
        size = self.z.size
        past = self.past
        offset = self.z - past.reference
        information = at.information + past.information
        information[np.diag_indices(size)] += self._lasting
        gradient = at.gradient + past.gradient + past.information @ offset + self._lasting * self.z
        of_curve, curved = self._within_friction(nodes, at.moved)
        information += np.outer(of_curve, of_curve)
        gradient += curved * of_curve
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
        found = (np.eye(size) - inverse) * np.outer(self._lasting, self._lasting)
        self._expected = float(np.trace(found))
        # Where no node tells anything any more, unknowns that are still off are a surprise.
        self._scatter = max(sqrt(2.0 * float((found * found).sum())), _LEAST_SCATTER)
        self.covariance = inverse * np.outer(sd, sd)
        before = float(offset @ (0.5 * past.information @ offset + past.gradient)) + 0.5 * self._squares()
        self.cost = at.cost + before + 0.5 * curved**2 - past.log_likelihood
        self._node_time, self._of_node = nodes.time, at.of_node
        of_peak = np.abs(move[:2] * sd[:2])
        self.unsettled = float(of_peak[Unknown.LOG_MU_MAX])
        curve = float(of_peak.max())
        longest = max(curve / _LONGEST_OF_CURVE, float(np.abs(move[2:]).max()) / _LONGEST, 1.0)
        move /= longest
        self.promise = -float(gradient @ move + 0.5 * move @ information @ move)
        self.log_evidence = self.promise - self.cost - float(np.log(np.diag(lower)).sum())
        # Steps that turn back overshoot: damp them.
        last = self._last_move
        lengths = float(np.sqrt((move @ move) * (last @ last)))
        turned = lengths > 0.0 and float(move @ last) < -0.3 * lengths
        self._damping = max(3.0 * self._damping, 3.0) if turned else 0.3 * self._damping
        if self._damping < 0.1:
            self._damping = 0.0
        self._last_move = move
        self.z = self.z + move
        self._correction = at.noise.correction(at.factor, at.white[:, -1] + at.white[:, :-1] @ move[at.acting])
        self.steps += 1
        self.moved, self.tyres = at.moved, at.tyres
        self._across = at.tyres.across
        return curve

    def _within_friction(self, nodes: Nodes, moved: Motion) -> tuple[Array, float]:
        """Return a row in z and its residual: a lateral acceleration that nothing measures is within the friction.

        What the wheels show of it grows without bounds where they are all near the peak, for there no slip is known.
        """
        p, sd, row = self.unknowns, self._prior.stddev, np.zeros_like(self.z)
        if sd[Unknown.LOG_ACROSS] > 0.0 or not sd[Unknown.CURVE] > 0.0:
            return row, 0.0
        time, speed = float(nodes.time[-1]), float(moved.speed[-1])
        per_curve = share_across(1.0, speed, self._car, exp(float(p[Unknown.LOG_MU_MAX]))) / _OF_FRICTION
        row[Unknown.CURVE] = per_curve * sd[Unknown.CURVE]
        row[Unknown.CURVE_RATE] = per_curve * time * sd[Unknown.CURVE_RATE]
        return row, per_curve * float(p[Unknown.CURVE] + time * p[Unknown.CURVE_RATE])

    def begin_at(self, other: "CurveFit") -> None:
        """Go where the fit of another formula is, with a shape of the prior: this one has gone astray."""
        self.z = other.z.copy()
        self.z[[Unknown.SHAPE_1, Unknown.SHAPE_2]] = 0.0
        self.load_variation = other.load_variation
        self._correction, self._across = other._correction.copy(), other._across
        self._damping = 0.0
        self._last_move = np.zeros_like(self.z)

    def begin_anew(self, mu: float) -> None:
        """Forget the curve, and keep what is known of the car: another road, that gives about the friction `mu`.

        Comes after a `fold` of what lies before it.
        """
        past, prior = self.past, self._prior
        kept = _KEPT_OF_CAR
        gradient = kept * (past.gradient + past.information @ (self.z - past.reference))
        information = kept * past.information
        reference = self.z
        self.z = self.z.copy()
        for unknown in range(OF_CURVE.stop):
            information, gradient = forgotten(information, gradient, unknown)
            self.z[unknown] = 0.0
        # What the forgotten said of the families' odds was said of another road.
        self.past = Quadratic(information, gradient, reference)
        mean, stddev = float(prior.mean[Unknown.LOG_MU_MAX]), float(prior.stddev[Unknown.LOG_MU_MAX])
        self.z[Unknown.LOG_MU_MAX] = (log(mu) - mean) / stddev
        self._last_move = np.zeros_like(self.z)
        self._damping, self.steps = 0.0, 0

    def fold(self, samples: BrakingSamples, nodes: Nodes, start: Start, number: int, memory: float) -> None:
        """Keep what the oldest `number` nodes say as a quadratic; `memory`: share kept of what was said before."""
        at = self.linearise(samples, nodes.subset(slice(0, number)), start, adapt=False)
        past, offset = self.past, self.z - self.past.reference
        gradient = memory * (past.gradient + past.information @ offset) + at.gradient
        said = float(offset @ (0.5 * past.information @ offset + past.gradient))
        likelihood = memory * (past.log_likelihood - said) - at.cost
        duration = float(nodes.interval[:number].sum())
        information = memory * past.information + at.information
        sd = self._prior.stddev
        information, gradient = drifted(information, gradient, sd, float(nodes.time[number]), duration)
        self.past = Quadratic(information, gradient, self.z.copy(), likelihood)
        self._carry(nodes, number)

    def forget(self, nodes: Nodes, number: int) -> None:
        """Let the oldest `number` nodes leave, and forget what they and older ones said."""
        self.past = self._of_start()
        self._carry(nodes, number)

    def _squares(self) -> float:
        """Sum of the squared unknowns whose prior lasts."""
        return float(self.z @ (self._lasting * self.z))

    def _of_start(self) -> Quadratic:
        """What is known before a sample, of what does not stay as it was at the start."""
        return Quadratic(np.diag(1.0 - self._lasting), np.zeros_like(self._lasting), np.zeros_like(self._lasting))

    def _carry(self, nodes: Nodes, number: int) -> None:
        """Keep the state of the motion that the oldest `number` nodes leave."""
        leaving = nodes.subset(slice(0, number + 1))
        leaving = replace(leaving, wheel_speed=leaving.wheel_speed + self._at_nodes(leaving))
        across = self._across_at(number + 1)
        moved = motion(self._car, leaving, self.unknowns, self.carried, across)
        self.carried = carried_over(nodes, moved, self.carried, number)
        self._correction = self._correction[:, number:]
        if self._across is not None:
            self._across = self._across[:, number:]

    def _at_nodes(self, nodes: Nodes) -> Array:
        """Corrections of the wheel speeds at the nodes [rad/s], shape (W, n); zero at those that are new."""
        found = np.zeros((self._car.wheels, nodes.time.size))
        count = min(self._correction.shape[1] - 1, nodes.time.size)
        if count > 0:
            found[:, :count] = 0.5 * (self._correction[:, :count] + self._correction[:, 1 : count + 1])
        return found

    def _across_at(self, count: int) -> Array | None:
        """Lateral slips of the last step at the first `count` nodes, (W, count); the last one holds at new nodes."""
        known = self._across
        if known is None or known.shape[1] == 0:
            return None
        return np.asarray(known[:, np.minimum(np.arange(count), known.shape[1] - 1)])
