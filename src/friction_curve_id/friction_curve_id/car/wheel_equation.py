"""Wheel equation at the nodes, in units of wheel acceleration, with its Jacobian and its variance.

    e = omega_dot + (kappa_i T_i(t + tau) + T_drag - r Fz mu(s)) / J

The difference of two means over neighbouring intervals weighs a torque by a triangle over both: signals at the nodes
are weighed 1/6, 2/3, 1/6. The variance of e J counts the torque noise, what these weights may miss (a sixth of the
second differences of T and F), the varying load of the wheel (delta r Fz mu)^2 and the slip's share of the noise of the
wheel speed. Nodes are tied by the noise of the wheel speed between them, and by a load that lasts. Where a wheel is
locked kappa T is no torque but its limit: the equation says nothing there.
"""

from dataclasses import dataclass
from math import exp

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpbtrf, dtbtrs

from friction_curve_id.car.car_constants import CarConstants
from friction_curve_id.car.car_model import SPEED_UNKNOWNS, Motion, brake_gains, gains_by_fading
from friction_curve_id.car.combined_slip import TyreSlips, across_gradient
from friction_curve_id.car.node_signals import Nodes, with_repeated_ends
from friction_curve_id.car.pitch import PITCH_UNKNOWNS
from friction_curve_id.car.unknowns import OF_CURVE, SHARED, Unknown

Array = NDArray[np.float64]

_UNKNOWN_DRIVE = 150.0
"""Standard deviation of the torque of a driven wheel while the car does not brake [N m]."""
_NOTHING = 1e8
"""Variance of what says nothing [rad^2/s^4]: its neighbours do not learn from it that the wheel speeds were right."""
LOAD_VARIATIONS = np.array([0.01, 0.015, 0.02, 0.03, 0.04, 0.055, 0.075, 0.11])
"""Values that the variation of the wheel load may take [-]; no model of road and tyre is better than the first."""
_LOAD_CORRELATION = 0.02
"""Time over which the load of a wheel varies [s]: below 15 Hz."""


@dataclass(frozen=True)
class WheelEquation:
    """Residuals at n nodes of W wheels, and what their covariance is made of."""

    error: Array
    """e [rad/s^2], shape (W, n)."""
    jacobian: Array
    """d e / d unknowns, shape (W, n, SHARED + W)."""
    fixed_variance: Array
    """Variance of e without that of the load and the wheel speeds, shape (W, n)."""
    load_variance: Array
    """Variance of e for a load that varies by 1, shape (W, n)."""
    torque: Array
    """Torque of the brake and the engine at the nodes, weighed [N m], shape (W, n)."""
    by_wheel_speed: Array
    """d e / d wheel speed at the node by the slip there [1/s], shape (W, n)."""
    across_gradient: Array | None
    """d s_y / d unknowns, shape (W, n, SHARED + W); None: the car goes straight."""


def weighed(values: Array, share: float) -> Array:
    """Add a share of the second difference along the second axis; the ends are extended straight."""
    result = values.copy()
    result[:, 1:-1] += (values[:, :-2] - 2.0 * values[:, 1:-1] + values[:, 2:]) * share
    return result


def second_difference(values: Array) -> Array:
    """Second difference along the second axis, the ends as their neighbours."""
    result = np.zeros_like(values)
    result[:, 1:-1] = values[:, :-2] - 2.0 * values[:, 1:-1] + values[:, 2:]
    result[:, 0], result[:, -1] = result[:, 1], result[:, -2]
    return result


def wheel_equation(
    car: CarConstants,
    nodes: Nodes,
    moved: Motion,
    torque: Array,
    torque_rate: Array,
    tyres: TyreSlips,
    unknowns: Array,
    torque_stddev: float,
) -> WheelEquation:
    """Linearise the wheel equation about the present unknowns.

    Args:
        car: nominal values.
        nodes: measured signals.
        moved: their motion at the unknowns.
        torque: T at nominal gain, weighed, later by the pressure's delay [N m], shape (W, n).
        torque_rate: its derivative by time [N m/s], shape (W, n).
        tyres: their slips and frictions.
        unknowns: shape (SHARED + W,).
        torque_stddev: what the wheel equation leaves out [N m].
    """
    p = unknowns
    peak, mu_max = exp(float(p[Unknown.LOG_LAMBDA_MAX])), exp(float(p[Unknown.LOG_MU_MAX]))
    curve, x = tyres.curve, (tyres.size if tyres.across is None else np.abs(tyres.size)) / peak
    lever = car.radius * moved.load
    tyre = (mu_max * lever * tyres.along) * curve.value
    tyre_by_slip = lever * tyres.slope_along
    gain = brake_gains(car, nodes, p)
    inertia = car.inertia * exp(float(p[Unknown.LOG_INERTIA]))
    per_inertia = 1.0 / inertia
    brake = gain * torque

    wheels, n = x.shape
    of_peak = curve.by_log_peak - curve.slope * x
    by_curve = np.stack([curve.value, of_peak, *curve.by_shape], axis=2) * mu_max
    # First the Jacobian of the tyre's torque, to be weighed; in units of torque.
    tyre_jacobian = np.zeros((wheels, n, SHARED + wheels))
    tyre_jacobian[:, :, OF_CURVE] = (lever * tyres.along)[:, :, np.newaxis] * by_curve
    per_load = tyre / moved.load
    tyre_jacobian[:, :, Unknown.LOG_MASS] = tyre
    tyre_jacobian[:, :, Unknown.LOG_HEIGHT_RATIO] = per_load * moved.load_by_height
    tyre_jacobian[:, :, Unknown.FRONT_LOAD_SHARE] = per_load * moved.load_by_share
    tyre_jacobian[:, :, Unknown.FRONT_ROLL_SHARE] = per_load * moved.load_by_roll
    for row, unknown in enumerate(PITCH_UNKNOWNS):
        tyre_jacobian[:, :, unknown] = per_load * moved.load_by_pitch[row]
    for row, unknown in enumerate(SPEED_UNKNOWNS):
        tyre_jacobian[:, :, unknown] = tyre_by_slip * moved.relaxed_by_speed[row]
    tyre_jacobian[:, :, Unknown.ACCELEROMETER_OFFSET] += per_load * moved.load_by_offset
    tyre_jacobian[:, :, Unknown.ACCELEROMETER_SCALE] += per_load * moved.load_by_scale
    tyre_jacobian[:, :, Unknown.RELAXATION_LENGTH] = tyre_by_slip * moved.relaxed_by_length
    tyre_jacobian[:, :, Unknown.CURVE] = tyre_by_slip * car.left * moved.relaxed_by_offset
    tyre_jacobian[:, :, Unknown.CURVE_RATE] = tyre_by_slip * car.left * moved.relaxed_by_growth
    for wheel in range(wheels):
        tyre_jacobian[wheel, :, SHARED + wheel] = tyre_by_slip[wheel] * moved.relaxed_by_offset
    of_across = None
    if tyres.across is not None:
        of_across = across_gradient(car, moved, tyres, by_curve)
        tyre_jacobian += (lever * tyres.pulled)[:, :, np.newaxis] * of_across
    jacobian = weighed(tyre_jacobian, nodes.spread)
    jacobian *= -per_inertia[:, :, np.newaxis]
    # The noise of a torque is part of e: a Jacobian that held it would draw inertia and gain to where noise is least.
    smooth = _mean_of_five(brake)
    acting = brake + p[Unknown.ENGINE_DRAG] * car.driven
    passed = weighed(tyre, nodes.spread)
    balance = acting - passed
    smoothed = smooth * per_inertia
    jacobian[:, :, Unknown.LOG_GAIN_FRONT] = car.front * smoothed
    jacobian[:, :, Unknown.LOG_GAIN_REAR] = (1.0 - car.front) * smoothed
    jacobian[:, :, Unknown.FADING] = gains_by_fading(nodes, p) * smoothed
    jacobian[:, :, Unknown.PRESSURE_DELAY] = gain * torque_rate * per_inertia
    jacobian[:, :, Unknown.ENGINE_DRAG] = car.driven * per_inertia
    jacobian[:, :, Unknown.LOG_INERTIA] = -(smooth + p[Unknown.ENGINE_DRAG] * car.driven - passed) * per_inertia

    missed = (second_difference(brake) ** 2 + second_difference(tyre) ** 2) * nodes.spread**2
    by_wheel_speed = tyre_by_slip * car.radius / moved.speed
    slip_noise = by_wheel_speed * (1.0 - moved.immediate) * nodes.wheel_noise[:, 1:]
    drive = np.where(nodes.closed > 0.0, 0.0, _UNKNOWN_DRIVE**2) * car.driven
    by_across = (lever * tyres.pulled * tyres.across_stddev) ** 2
    fixed = (torque_stddev**2 + missed + 0.5 * slip_noise**2 + drive + by_across) / inertia**2
    load_variance = (tyre / inertia) ** 2
    error = nodes.wheel_acceleration + balance / inertia
    immediate = by_wheel_speed * moved.immediate / inertia
    locked = ~nodes.turning
    if locked.any():
        jacobian[locked] = 0.0
        error[locked] = load_variance[locked] = immediate[locked] = 0.0
        fixed[locked] = _NOTHING
    return WheelEquation(error, jacobian, fixed, load_variance, acting, immediate, of_across)


def _mean_of_five(values: Array) -> Array:
    """Means over a value and its two neighbours on either side, along the second axis; the ends are repeated."""
    padded = with_repeated_ends(values)
    n = values.shape[1]
    return np.asarray(
        (padded[:, :n] + padded[:, 1 : n + 1] + padded[:, 2 : n + 2] + padded[:, 3 : n + 3] + padded[:, 4:]) * 0.2
    )


class EquationNoise:
    """Covariance of e at the nodes by the noise of the wheel speeds, that of the torques and the variation of the load.

    The noise of n + 1 wheel speeds about n nodes reaches e by their difference and by the slip. Of the variation of
    the load one half lasts and one does not. e_k - keep_k e_(k-1) is free of what lasts, and its covariance has two
    bands beside the diagonal.
    """

    def __init__(self, nodes: Nodes, equation: WheelEquation, continued: bool) -> None:
        """`continued`: nodes before the first one have had their say, and with them what lasts of the load there."""
        self._variance = nodes.wheel_noise**2
        per, half = 1.0 / nodes.interval, 0.5 * equation.by_wheel_speed
        before, after = half - per, half + per
        self._by_before, self._by_after = before, after
        white = equation.fixed_variance + self._variance[:, 1:] * after**2 + self._variance[:, :-1] * before**2
        off = self._variance[:, 1:-1] * after[:, :-1] * before[:, 1:]
        keep = np.zeros_like(white)
        keep[:, 1:] = np.exp(-nodes.interval[1:] / _LOAD_CORRELATION)
        self._keep = keep.ravel()
        self._bands, self._of_load = _bands(white, off, keep), _bands(equation.load_variance, np.zeros_like(off), keep)
        self._of_load[0] += (1.0 - keep**2) * equation.load_variance
        if continued:
            self._bands[0, :, 0] += _NOTHING

    def adapted(self, error: Array, here: int) -> tuple[int, Array]:
        """Move the load variation towards its maximum of likelihood, up by one step at most; return it with its factor.

        What a bad step of the fit makes it rise by would else make this family the less likely one for ten steps more.

        Args:
            error: e, shape (W, n).
            here: present load variation, an index of LOAD_VARIATIONS.
        """

        def tried(variation: int) -> tuple[float, Array]:
            factor = self.factor(variation)
            white = self.whitened(factor, error.reshape(-1, 1).copy())
            return 0.5 * float((white * white).sum()) + float(np.log(factor[0]).sum()), factor

        least, best = tried(here)
        if here + 1 < LOAD_VARIATIONS.size:
            cost, factor = tried(here + 1)
            if cost < least:
                return here + 1, factor
        while here > 0:
            cost, factor = tried(here - 1)
            if not cost < least:
                break
            here, least, best = here - 1, cost, factor
        return here, best

    def factor(self, load_variation: int) -> Array:
        """Lower factor of the covariance of what does not last, by its bands, (3, W n); see LOAD_VARIATIONS."""
        bands = self._bands + LOAD_VARIATIONS[load_variation] ** 2 * self._of_load
        lower, info = dpbtrf(bands.reshape(3, -1), lower=1)
        if info != 0:
            raise np.linalg.LinAlgError("the covariance is not positive definite")
        return np.asarray(lower)

    def whitened(self, factor: Array, columns: Array) -> Array:
        """Return columns at the nodes, shape (W n, m), as if the noise were independent and of variance 1.

        `columns` are overwritten.
        """
        columns[1:] -= self._keep[1:, np.newaxis] * columns[:-1]
        white, _ = dtbtrs(factor, columns, uplo="L", overwrite_b=1)
        return np.asarray(white)

    def correction(self, factor: Array, white: Array) -> Array:
        """Most likely corrections of the wheel speeds [rad/s], shape (W, n + 1); `white`: e, whitened, (W n,)."""
        solved, _ = dtbtrs(factor, white[:, np.newaxis], uplo="L", trans="T")
        by_node = solved[:, 0]
        by_node[:-1] -= self._keep[1:] * by_node[1:]
        by_node = by_node.reshape(self._by_before.shape)
        gradient = np.zeros_like(self._variance)
        gradient[:, :-1] = self._by_before * by_node
        gradient[:, 1:] += self._by_after * by_node
        return np.asarray(-self._variance * gradient)


def _bands(variance: Array, off: Array, keep: Array) -> Array:
    """Bands of the covariance of x_k - keep_k x_(k-1), shape (3, W, n), by that of x.

    `variance` and `keep` have the shape (W, n); `off`, of neighbours, (W, n - 1).
    """
    bands = np.zeros((3, *variance.shape))
    bands[0] = variance
    bands[0, :, 1:] += keep[:, 1:] * (keep[:, 1:] * variance[:, :-1] - 2.0 * off)
    bands[1, :, :-1] = off - keep[:, 1:] * variance[:, :-1]
    bands[1, :, 1:-1] += keep[:, 1:-1] * keep[:, 2:] * off[:, :-1]
    bands[2, :, :-2] = -keep[:, 2:] * off[:, :-1]
    return bands
