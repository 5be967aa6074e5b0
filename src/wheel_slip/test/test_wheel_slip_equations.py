"""Slip, slip rate and their variances against finite differences and sampling."""

import numpy as np
import pytest

from wheel_slip.estimate import slip, slip_rate, slip_rate_variance, slip_variance


def test_slip_is_zero_rolling_one_locked_and_negative_in_traction() -> None:
    assert slip(20.0, 20.0 / 0.3, 0.3) == pytest.approx(0.0)
    assert slip(20.0, 0.0, 0.3) == 1.0
    assert slip(20.0, 22.0 / 0.3, 0.3) == pytest.approx(-0.1)


def test_slip_rate_is_the_derivative_of_slip() -> None:
    v, a, omega, omega_dot, r, h = 17.0, -7.0, 48.0, -90.0, 0.31, 1e-6
    later = slip(v + h * a, omega + h * omega_dot, r)
    before = slip(v - h * a, omega - h * omega_dot, r)
    assert slip_rate(v, a, omega, omega_dot, r) == pytest.approx((later - before) / (2.0 * h), rel=1e-6)


def test_variances_are_those_of_a_sample_of_small_errors() -> None:
    rng = np.random.default_rng(1)
    v, a, omega, omega_dot, r = 12.0, -6.0, 33.0, -60.0, 0.3
    sigma = np.array([0.05, 0.1, 0.05, 1.0])
    e = rng.normal(size=(200_000, 4)) * sigma
    slips = 1.0 - (omega + e[:, 2]) * r / (v + e[:, 0])
    rates = r / (v + e[:, 0]) * ((omega + e[:, 2]) * (a + e[:, 1]) / (v + e[:, 0]) - omega_dot - e[:, 3])
    variances = [float(s**2) for s in sigma]
    exact = (r, 0.0)
    assert slip_variance((v, variances[0]), (omega, variances[2]), exact, 0.0) == pytest.approx(slips.var(), rel=0.02)
    assert slip_rate_variance(
        (v, variances[0]), (a, variances[1]), (omega, variances[2]), (omega_dot, variances[3]), r
    ) == pytest.approx(rates.var(), rel=0.02)


def test_an_error_of_the_radius_that_is_in_the_speed_too_is_not_in_the_slip() -> None:
    share = 1e-4
    speed = (20.0, 20.0**2 * share)
    alone = slip_variance((20.0, 0.0), (60.0, 0.0), (1.0 / 3.0, share), 0.0)
    assert alone == pytest.approx(share)
    assert slip_variance(speed, (60.0, 0.0), (1.0 / 3.0, share), 20.0 * share) == pytest.approx(0.0, abs=1e-12)
