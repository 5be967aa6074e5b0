"""The Burckhardt curve in logarithmic coordinates against the curve itself and finite differences."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from vehicle_models import burckhardt, burckhardt_log
from vehicle_models.surfaces import surface

Q = np.array([np.log(0.9), np.log(25.0), np.log(0.4)])


def test_gradients_of_the_logarithmic_curve_are_finite_differences() -> None:
    slip = np.array([-0.05, 0.0, 0.01, 0.1, 0.4, 0.9])
    gradient = np.empty((6, 3))
    mu, slope = burckhardt_log.friction_into(Q, slip, gradient)
    theta = burckhardt_log.to_theta(Q)
    assert_allclose(mu, burckhardt.friction(theta, slip))
    assert_allclose(slope, burckhardt.slope(theta, slip))
    peak = burckhardt_log.peak(Q)
    assert_allclose([peak.lambda_max, peak.mu_max], burckhardt.peak(theta))
    for index in range(3):
        step = 1e-6 * np.eye(3)[index]
        up, down = burckhardt_log.to_theta(Q + step), burckhardt_log.to_theta(Q - step)
        difference = (burckhardt.friction(up, slip) - burckhardt.friction(down, slip)) / 2e-6
        assert_allclose(gradient[:, index], difference, atol=1e-8)
        assert_allclose(burckhardt_log.theta_jacobian(theta)[:, index], (up - down) / 2e-6, rtol=1e-6, atol=1e-9)
        (high, top), (low, bottom) = burckhardt.peak(up), burckhardt.peak(down)
        assert peak.lambda_gradient[index] == pytest.approx((np.log(high) - np.log(low)) / 2e-6, abs=1e-7)
        assert peak.mu_gradient[index] == pytest.approx((top - bottom) / 2e-6, abs=1e-7)
    assert burckhardt_log.steepness(Q) == pytest.approx(theta[0] * theta[1])


def test_a_point_of_the_logarithmic_curve_agrees_with_finite_differences() -> None:
    slip, theta = 0.08, burckhardt_log.to_theta(Q)
    found = burckhardt_log.at(theta, slip)
    assert found.friction == pytest.approx(burckhardt.friction(theta, slip))
    assert burckhardt_log.at(theta, -slip).friction == pytest.approx(-found.friction)
    assert found.slope == pytest.approx(burckhardt.slope(theta, slip))
    difference = (burckhardt.slope(theta, slip + 1e-6) - burckhardt.slope(theta, slip - 1e-6)) / 2e-6
    assert found.curvature == pytest.approx(difference, rel=1e-6)
    for index in range(3):
        step = 1e-6 * np.eye(3)[index]
        up, down = burckhardt_log.to_theta(Q + step), burckhardt_log.to_theta(Q - step)
        difference = (burckhardt.slope(up, slip) - burckhardt.slope(down, slip)) / 2e-6
        assert found.slope_gradient[index] == pytest.approx(difference, rel=1e-6, abs=1e-8)


def test_many_peaks_are_as_one() -> None:
    roads = np.array([surface(name) for name in ("dry", "wet", "snow")])
    exponents = burckhardt.peak_exponent(roads)
    gradients = burckhardt_log.lambda_gradient(exponents)
    jacobians = burckhardt_log.theta_jacobian(roads)
    for index, road in enumerate(roads):
        assert_allclose(gradients[:, index], burckhardt_log.lambda_gradient(float(exponents[index])))
        assert_allclose(jacobians[index], burckhardt_log.theta_jacobian(road))


def test_a_curve_without_a_peak_below_slip_one_says_so() -> None:
    peak = burckhardt_log.peak(np.log(np.array([1.0, 2.0, 0.2])))
    assert np.isnan(peak.lambda_max) and np.isnan(peak.mu_max) and np.isnan(peak.lambda_gradient).all()
