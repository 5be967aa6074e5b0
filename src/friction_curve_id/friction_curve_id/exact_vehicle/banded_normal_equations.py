"""Normal equations of the full-information fit over a window, and their solution in linear time.

Unknowns: omega at every sample, q (see `burckhardt_log`) and u (see `braking_window`). Residuals, each in its own
standard deviations:

    wheel equation (2.15), trapezoidal  (omega_{k+1} - omega_k - (h/J)(r Fz mean(mu) - mean(T))) / (sigma_T h / J)
    wheel speed                         (omega_k - measured) / sigma_omega
    vehicle speed, where measured       (v_k - measured) / sigma_v
    prior of q, past evidence           quadratic

A torque error e_k enters two neighbouring wheel equations by halves; to the shifted unknown omega_k - (h / 2J) e_k it
is white, and the shift (0.008 rad/s) is far below the noise of omega. The matrix is tridiagonal in the omegas with a
border of four columns: LAPACK's pttrf eliminates the omegas, a 4 x 4 system remains.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpttrf, dpttrs

from friction_curve_id.exact_vehicle.braking_window import BrakingWindow
from friction_curve_id.exact_vehicle.past_evidence import PastEvidence
from friction_curve_id.exact_vehicle.robust_weights import huber_cost, huber_weights, robust_cost, robust_weights
from friction_curve_id.measurement_noise import MeasurementNoise
from vehicle_models import burckhardt_log
from vehicle_models.vehicle import CornerParameters

Array = NDArray[np.float64]


@dataclass(frozen=True)
class OutlierThresholds:
    """Residuals beyond these, in standard deviations, get less weight."""

    wheel_speed: float = 3.5
    speed: float = 2.0
    wheel_equation: float = 3.5


@dataclass(frozen=True)
class NormalEquations:
    """Matrix and gradient of the cost at the present unknowns, n samples."""

    diagonal: Array
    """Diagonal of the block of the omegas, shape (n,)."""
    off_diagonal: Array
    """Off-diagonal of the block of the omegas, shape (n - 1,)."""
    border: Array
    """Rows omega_k; columns q, u, and last the gradient; shape (n, 5)."""
    corner: Array
    """Block of (q, u), bordered by the gradient in the last column, shape (5, 5)."""
    cost: float
    """Cost at the present unknowns."""


@dataclass(frozen=True)
class Solution:
    """Newton step, and the covariance of the unknowns that are published."""

    wheel_speed_step: Array
    """Step of the omegas [rad/s], shape (n,)."""
    step: Array
    """Step of (q, u), shape (4,)."""
    covariance: Array
    """Covariance of (q, u, omega of the newest sample), shape (5, 5)."""


def assemble(
    window: BrakingWindow,
    q: Array,
    momentum_speed: float,
    wheel: CornerParameters,
    noise: MeasurementNoise,
    thresholds: OutlierThresholds,
    past: PastEvidence,
    oldest: int | None = None,
) -> NormalEquations:
    """Linearise the residuals of a window of at least two samples about the present unknowns, without the prior of q.

    Args:
        window: the samples, and the present estimate of their wheel speeds.
        q: present curve, shape (3,).
        momentum_speed: present u [m/s].
        wheel: the wheel and its share of the car.
        noise: noise of the measurements.
        thresholds: residuals beyond these get less weight.
        past: evidence of the samples before the window.
        oldest: take only the residuals of this many oldest samples, up to the wheel equation that leads to the next.
    """
    n = window.count if oldest is None else oldest + 1
    omega = window.wheel_speed[:n]
    speed = window.speeds(momentum_speed)[:n]
    speed_per_omega = -window.speed_per_wheel_speed
    slip = 1.0 - wheel.radius * omega / speed
    slip_per_u = wheel.radius * omega / (speed * speed)
    slip_per_omega = slip_per_u * speed_per_omega - wheel.radius / speed

    mu_gradient = np.empty((n, 5))
    mu, slope = burckhardt_log.friction_into(q, slip, mu_gradient)
    mu_gradient[:, 3] = slope * slip_per_u
    mu_gradient[:, 4] = mu
    mu_per_omega = slope * slip_per_omega

    interval = window.time[1:n] - window.time[: n - 1]
    scale = wheel.inertia / (noise.torque * interval)
    half_gain = (0.5 / noise.torque) * wheel.radius * wheel.vertical_load
    equation = (mu_gradient[:-1] + mu_gradient[1:]) * -half_gain
    equation[:, 4] += scale * (omega[1:] - omega[:-1]) + (0.5 / noise.torque) * (
        window.torque[: n - 1] + window.torque[1:n]
    )
    before = -scale - half_gain * mu_per_omega[:-1]
    after = scale - half_gain * mu_per_omega[1:]
    squared, trust = equation[:, 4] ** 2, window.equation_trust[1:n]
    cost = robust_cost(squared, thresholds.wheel_equation) @ trust
    root = np.sqrt(robust_weights(squared, thresholds.wheel_equation) * trust)
    equation *= root[:, np.newaxis]
    before *= root
    after *= root

    omega_error = omega - window.measured_wheel_speed[:n]
    squared, trust = (omega_error / noise.wheel_speed) ** 2, window.wheel_speed_trust[:n]
    cost += robust_cost(squared, thresholds.wheel_speed) @ trust
    omega_weight = robust_weights(squared, thresholds.wheel_speed) * trust / noise.wheel_speed**2
    speed_error = speed - window.measured_speed[:n]
    squared, trust = (speed_error / noise.speed) ** 2, window.has_speed[:n]
    cost += huber_cost(squared, thresholds.speed) @ trust
    speed_weight = huber_weights(squared, thresholds.speed) * trust / noise.speed**2
    if oldest is not None:
        omega_weight[-1] = speed_weight[-1] = 0.0

    diagonal = omega_weight + speed_weight * speed_per_omega**2
    diagonal[:-1] += before * before
    diagonal[1:] += after * after
    border = np.zeros((n, 5))
    border[:-1] = before[:, np.newaxis] * equation
    border[1:] += after[:, np.newaxis] * equation
    border[:, 3] += speed_per_omega * speed_weight
    border[:, 4] += omega_weight * omega_error + speed_per_omega * speed_weight * speed_error
    corner = equation.T @ equation
    corner[3, 3] += speed_weight.sum()
    corner[3, 4] += speed_weight @ speed_error

    x = np.array([*q, momentum_speed, omega[0]])
    cost += past.cost_at(x)
    gradient = past.gradient_at(x)
    corner[:4, :4] += past.information[:4, :4]
    corner[:4, 4] += gradient[:4]
    border[0, :4] += past.information[4, :4]
    border[0, 4] += gradient[4]
    diagonal[0] += past.information[4, 4]
    return NormalEquations(diagonal, before * after, border, corner, float(cost))


def solve(equations: NormalEquations) -> Solution:
    """Return the Newton step and the covariance.

    Raises:
        np.linalg.LinAlgError: the matrix is not positive definite (or not finite).
    """
    pivots, factors, info = dpttrf(equations.diagonal, equations.off_diagonal)
    if info != 0:
        raise np.linalg.LinAlgError("the wheel speeds are not determined")
    eliminated, _ = dpttrs(pivots, factors, equations.border)
    reduced = equations.corner - equations.border.T @ eliminated
    inverse = np.linalg.inv(reduced[:4, :4])
    step = -inverse @ reduced[:4, 4]
    wheel_speed_step = -eliminated[:, 4] - eliminated[:, :4] @ step
    newest = eliminated[-1, :4]
    covariance = np.empty((5, 5))
    covariance[:4, :4] = inverse
    covariance[4, :4] = covariance[:4, 4] = -(inverse @ newest)
    covariance[4, 4] = 1.0 / pivots[-1] + newest @ inverse @ newest
    if not (np.isfinite(wheel_speed_step).all() and np.isfinite(covariance).all() and np.diag(covariance).min() > 0.0):
        raise np.linalg.LinAlgError("the fit is not finite")
    return Solution(wheel_speed_step, step, covariance)


def fold(equations: NormalEquations, number: int, x: Array) -> PastEvidence:
    """Eliminate the oldest `number` omegas; return their evidence on x = (q, u, omega of the next sample), shape (5,).

    `equations` must hold the residuals of these samples only: those of sample `number` itself excluded.
    """
    border = np.zeros((number, 6))
    border[:, :4] = equations.border[:number, :4]
    border[-1, 4] = equations.off_diagonal[number - 1]
    border[:, 5] = equations.border[:number, 4]
    corner = np.zeros((6, 6))
    corner[:4, :4] = equations.corner[:4, :4]
    corner[:4, 5] = corner[5, :4] = equations.corner[:4, 4]
    corner[4, :4] = corner[:4, 4] = equations.border[number, :4]
    corner[4, 4] = equations.diagonal[number]
    corner[4, 5] = corner[5, 4] = equations.border[number, 4]
    # LAPACK's wrapper needs one off-diagonal element even where there is none
    pivots, factors, info = dpttrf(equations.diagonal[:number], equations.off_diagonal[: max(number - 1, 1)])
    if info != 0:
        raise np.linalg.LinAlgError("the wheel speeds are not determined")
    eliminated, _ = dpttrs(pivots, factors, border)
    reduced = corner - border.T @ eliminated
    return PastEvidence(reduced[:5, :5], reduced[:5, 5], x.copy())
