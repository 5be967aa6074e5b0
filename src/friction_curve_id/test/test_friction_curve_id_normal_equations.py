"""The normal equations of method exact_vehicle against independent residuals and their finite differences."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from friction_curve_id.exact_vehicle.banded_normal_equations import (
    NormalEquations,
    OutlierThresholds,
    assemble,
    fold,
    solve,
)
from friction_curve_id.exact_vehicle.braking_window import BrakingWindow
from friction_curve_id.exact_vehicle.curve_prior import CurvePrior
from friction_curve_id.exact_vehicle.past_evidence import PastEvidence, momentum_evidence, no_evidence
from friction_curve_id.exact_vehicle.robust_weights import robust_cost, robust_weights
from friction_curve_id.measurement_noise import MeasurementNoise
from vehicle_models import burckhardt, burckhardt_log
from vehicle_models.surfaces import SURFACES
from vehicle_models.vehicle import CornerParameters

Array = NDArray[np.float64]

WHEEL = CornerParameters(radius=0.31, inertia=1.2, mass=260.0, vertical_load=2700.0)
NOISE = MeasurementNoise(0.08**2, 0.4**2, 4.0**2)
FAR = OutlierThresholds(1e9, 1e9, 1e9)
Q = np.log(SURFACES["wet"] / [1.0, 1.0, SURFACES["wet"][0]])


@pytest.fixture
def window() -> BrakingWindow:
    """Twelve samples of a braking at uneven intervals, one without a measured speed."""
    filled, generator = BrakingWindow(WHEEL, 30), np.random.default_rng(4)
    time = 0.0
    for k in range(12):
        time += 0.005 + 0.001 * (k % 3)
        omega = 80.0 - 0.4 * k - 0.05 * k**2
        speed = None if k == 3 else 25.5 + generator.normal(0.0, 0.3)
        filled.append(time, omega + generator.normal(0.0, 0.05), speed, 300.0 + 25.0 * k, omega)
    return filled


MOMENTUM_SPEED = 26.9


def residuals(window: BrakingWindow, unknowns: Array) -> Array:
    """All residuals of (omega, q, u), in standard deviations, from the equations of the documentation."""
    n = window.count
    omega, theta, u = unknowns[:n], burckhardt_log.to_theta(unknowns[n : n + 3]), unknowns[n + 3]
    speed = u - WHEEL.inertia / (WHEEL.mass * WHEEL.radius) * omega - window.impulse[:n]
    mu = burckhardt.friction(theta, 1.0 - WHEEL.radius * omega / speed)
    h, torque = np.diff(window.time[:n]), window.torque[:n]
    moment = WHEEL.radius * WHEEL.vertical_load * 0.5 * (mu[1:] + mu[:-1]) - 0.5 * (torque[1:] + torque[:-1])
    wheel = (np.diff(omega) - h / WHEEL.inertia * moment) / (NOISE.torque * h / WHEEL.inertia)
    measured = window.has_speed[:n] > 0.0
    return np.concatenate(
        [
            wheel,
            (omega - window.measured_wheel_speed[:n]) / NOISE.wheel_speed,
            ((speed - window.measured_speed[:n]) / NOISE.speed)[measured],
        ]
    )


def unknowns_of(window: BrakingWindow) -> Array:
    return np.array([*window.wheel_speed[: window.count], *Q, MOMENTUM_SPEED])


def jacobian(window: BrakingWindow) -> Array:
    x = unknowns_of(window)
    columns = []
    for index in range(len(x)):
        step = np.zeros(len(x))
        step[index] = 1e-6 * max(abs(x[index]), 1.0)
        columns.append((residuals(window, x + step) - residuals(window, x - step)) / (2.0 * step[index]))
    return np.asarray(np.array(columns).T)


def equations(window: BrakingWindow, past: PastEvidence, thresholds: OutlierThresholds = FAR) -> NormalEquations:
    return assemble(window, Q, MOMENTUM_SPEED, WHEEL, NOISE, thresholds, past)


def dense(found: NormalEquations) -> tuple[Array, Array]:
    n = len(found.diagonal)
    matrix = np.zeros((n + 4, n + 4))
    matrix[:n, :n] = np.diag(found.diagonal) + np.diag(found.off_diagonal, 1) + np.diag(found.off_diagonal, -1)
    matrix[:n, n:] = found.border[:, :4]
    matrix[n:, :n] = found.border[:, :4].T
    matrix[n:, n:] = found.corner[:4, :4]
    return matrix, np.concatenate([found.border[:, 4], found.corner[:4, 4]])


def test_matrix_and_gradient_are_those_of_the_finite_differences(window: BrakingWindow) -> None:
    rows, errors = jacobian(window), residuals(window, unknowns_of(window))
    matrix, gradient = dense(equations(window, no_evidence()))
    scale = np.sqrt(np.outer(np.diag(matrix), np.diag(matrix)))
    assert_allclose(matrix / scale, rows.T @ rows / scale, atol=1e-6)
    assert_allclose(gradient, rows.T @ errors, rtol=1e-5, atol=1e-5 * np.abs(rows.T @ errors).max())
    assert equations(window, no_evidence()).cost == pytest.approx(0.5 * errors @ errors)


def test_solution_is_that_of_the_dense_matrix(window: BrakingWindow) -> None:
    found = equations(window, momentum_evidence(27.0, 0.3))
    found.corner[:3, :3] += CurvePrior().information
    matrix, gradient = dense(found)
    solution = solve(found)
    n = window.count
    expected = -np.linalg.solve(matrix, gradient)
    assert_allclose(solution.wheel_speed_step, expected[:n], rtol=1e-6, atol=1e-9)
    assert_allclose(solution.step, expected[n:], rtol=1e-6, atol=1e-9)
    kept = np.array([*range(n, n + 4), n - 1])
    assert_allclose(solution.covariance, np.linalg.inv(matrix)[np.ix_(kept, kept)], rtol=1e-6)


def test_what_is_not_determined_is_refused(window: BrakingWindow) -> None:
    found = equations(window, no_evidence())
    found.diagonal[5] = -1.0
    with pytest.raises(np.linalg.LinAlgError):
        solve(found)


def test_folding_the_oldest_samples_changes_nothing_about_the_rest(window: BrakingWindow) -> None:
    past = momentum_evidence(27.0, 0.3)
    whole = equations(window, past)
    whole.corner[:3, :3] += CurvePrior().information
    expected = solve(whole)
    oldest = assemble(window, Q, MOMENTUM_SPEED, WHEEL, NOISE, FAR, past, oldest=5)
    folded = fold(oldest, 5, np.array([*Q, MOMENTUM_SPEED, window.wheel_speed[5]]))
    window.drop_oldest(5)
    rest = equations(window, folded)
    rest.corner[:3, :3] += CurvePrior().information
    solution = solve(rest)
    assert_allclose(solution.step, expected.step, rtol=1e-7, atol=1e-10)
    assert_allclose(solution.wheel_speed_step, expected.wheel_speed_step[5:], rtol=1e-6, atol=1e-9)
    assert_allclose(solution.covariance, expected.covariance, rtol=1e-7)


def test_evidence_fades_and_never_sharpens(window: BrakingWindow) -> None:
    evidence = fold(
        assemble(window, Q, MOMENTUM_SPEED, WHEEL, NOISE, FAR, no_evidence(), oldest=11),
        11,
        np.array([*Q, MOMENTUM_SPEED, window.wheel_speed[11]]),
    )
    for weaker in (evidence.aged(1.0, 2.0), evidence.loosened(3, 0.01), evidence.without(4)):
        lost = evidence.information - weaker.information
        size = np.abs(evidence.information).max()
        assert np.linalg.eigvalsh(lost).min() > -1e-9 * size
        assert np.linalg.eigvalsh(weaker.information).min() > -1e-9 * size
    assert not evidence.aged(100.0, 2.0).information.any()
    assert_allclose(evidence.loosened(3, 1e12).information, evidence.without(3).information, rtol=1e-6, atol=1e-3)


def test_evidence_gradient_is_that_of_its_cost() -> None:
    generator = np.random.default_rng(1)
    root = generator.normal(size=(5, 5))
    evidence = PastEvidence(root.T @ root, generator.normal(size=5), generator.normal(size=5))
    x = generator.normal(size=5)
    for index, slope in enumerate(evidence.gradient_at(x)):
        step = np.eye(5)[index] * 1e-5
        assert (evidence.cost_at(x + step) - evidence.cost_at(x - step)) / 2e-5 == pytest.approx(slope, rel=1e-6)


def test_robust_weights_are_the_slope_of_the_robust_cost_and_leave_noise_alone() -> None:
    error = np.linspace(0.05, 20.0, 400, dtype=np.float64)
    cost = (robust_cost((error + 1e-6) ** 2, 3.5) - robust_cost((error - 1e-6) ** 2, 3.5)) / 2e-6
    assert_allclose(robust_weights(error**2, 3.5) * error, cost, rtol=1e-4)
    assert np.all(robust_weights(error[error < 3.5] ** 2, 3.5) == 1.0)
    assert robust_cost(np.array([1e12]), 3.5)[0] <= 3.5**2
