"""Causal derivative estimators: exact for polynomials, with the delay and the noise they document."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import savgol_coeffs

from friction_slope.derivatives import LocalPolynomial, polynomial_weights

DT = 0.005
STEP = 5_000_000

COEFFICIENTS = st.lists(st.floats(-10.0, 10.0), min_size=4, max_size=4)
INTERVALS = st.lists(st.integers(1_000_000, 9_000_000), min_size=5, max_size=12)


def fed(estimator: LocalPolynomial, stamps: np.ndarray, values: np.ndarray) -> LocalPolynomial:
    for stamp, value in zip(stamps, values, strict=True):
        estimator.update(int(stamp), value.tolist())
    return estimator


@given(COEFFICIENTS, INTERVALS, st.floats(-0.02, 0.05), st.integers(0, 3))
def test_every_cubic_is_read_exactly_at_any_delay_and_whatever_the_jitter(
    coefficients: list[float], intervals: list[int], delay: float, order: int
) -> None:
    cubic = np.polynomial.Polynomial(coefficients)
    stamps = np.cumsum(intervals)
    time = (stamps - stamps[-1]) * 1e-9
    estimator = fed(LocalPolynomial(len(intervals), 3), stamps, cubic(time * 100.0)[:, np.newaxis])
    exact = cubic.deriv(order)(-delay * 100.0) * 100.0**order if order else cubic(-delay * 100.0)
    size = np.abs(cubic(time * 100.0)).max() + 1.0
    assert estimator.derivative(order, delay) == pytest.approx(exact, abs=1e-6 * size * 1e3**order, rel=1e-6)


@pytest.mark.parametrize("window", [5, 9, 28])
@pytest.mark.parametrize("order", [0, 1, 2])
def test_on_a_uniform_grid_the_weights_are_those_of_savitzky_and_golay(window: int, order: int) -> None:
    delay = (window // 2) * DT
    expected = savgol_coeffs(window, 2, deriv=order, delta=DT, pos=window - 1 - window // 2, use="dot")
    weights = polynomial_weights(np.arange(1 - window, 1) * DT, 2, order, delay)
    np.testing.assert_allclose(weights, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


def test_second_derivative_of_three_samples_is_the_second_difference() -> None:
    np.testing.assert_allclose(polynomial_weights([-2 * DT, -DT, 0.0], 2, 2, DT), np.array([1.0, -2.0, 1.0]) / DT**2)


@pytest.mark.parametrize(("window", "degree"), [(10, 2), (28, 2), (9, 3)])
def test_delay_at_the_centre_is_the_documented_one(window: int, degree: int) -> None:
    """The second derivative of a slow sine is the true one half a window ago, to second order in the window."""
    centre = 0.5 * (window - 1) * DT
    omega = 2.0
    time = np.arange(1 - window, 1) * DT
    at_phase = np.linspace(0.0, 2.0 * np.pi, 50, endpoint=False)
    weights = polynomial_weights(time, degree, 2, centre)
    found = np.array([weights @ np.sin(omega * time + phase) for phase in at_phase])
    expected = -(omega**2) * np.sin(-omega * centre + at_phase)
    shift = np.angle(np.vdot(np.exp(1j * at_phase), expected) / np.vdot(np.exp(1j * at_phase), found))
    assert shift / omega == pytest.approx(0.0, abs=1e-9)


def test_noise_of_the_second_derivative_falls_with_the_fifth_power_of_the_window() -> None:
    """Variance 720 sigma^2 / (T^4 N^5) for long windows (closed form of the Savitzky-Golay parabola)."""
    for window in (30, 60):
        weights = polynomial_weights(np.arange(1 - window, 1) * DT, 2, 2, 0.0)
        assert weights @ weights == pytest.approx(720.0 / (DT**4 * window**5), rel=0.01)


def test_reading_nearer_to_the_newest_sample_costs_noise() -> None:
    offsets = np.arange(-9, 1) * DT
    noise = [np.linalg.norm(polynomial_weights(offsets, 3, 2, delay)) for delay in (0.0225, 0.01, 0.0, -0.01)]
    assert noise == sorted(noise)


def test_a_parabola_has_the_same_second_derivative_everywhere_in_the_window() -> None:
    offsets = np.arange(-9, 1) * DT
    np.testing.assert_allclose(polynomial_weights(offsets, 2, 2, 0.0), polynomial_weights(offsets, 2, 2, 0.0225))


def test_several_signals_share_one_window_and_do_not_mix() -> None:
    rng = np.random.default_rng(1)
    values = rng.normal(size=(20, 3))
    stamps = np.arange(1, 21) * STEP
    together = fed(LocalPolynomial(7, 2, 3), stamps, values)
    for k in range(3):
        alone = fed(LocalPolynomial(7, 2), stamps, values[:, k : k + 1]).derivative(1, 0.015)
        assert together.derivative(1, 0.015, k) == pytest.approx(alone, rel=1e-12)


def test_nan_of_one_signal_leaves_the_others_alone_and_goes_with_its_sample() -> None:
    values = np.ones((20, 2))
    values[10, 1] = np.nan
    estimator = LocalPolynomial(5, 2, 2)
    known = []
    for k in range(20):
        estimator.update((k + 1) * STEP, values[k].tolist())
        if estimator.ready:
            assert estimator.derivative(0, 0.01, 0) == pytest.approx(1.0)
            known.append((k, np.isfinite(estimator.derivative(0, 0.01, 1))))
    assert [k for k, finite in known if not finite] == [10, 11, 12, 13, 14]


def test_old_samples_leave_the_window() -> None:
    estimator = LocalPolynomial(4, 1)
    for k in range(50):
        estimator.update((k + 1) * STEP, [0.0 if k < 40 else 3.0 * k * DT])
    assert estimator.derivative(1, 0.0) == pytest.approx(3.0)
    assert estimator.span == pytest.approx(3 * DT)


def test_reset_forgets_the_samples() -> None:
    estimator = LocalPolynomial(3, 1)
    fed(estimator, np.array([1, 2, 3]) * STEP, np.array([[5.0], [6.0], [9.0]]))
    estimator.reset()
    assert not estimator.ready
    assert estimator.span == 0.0
    with pytest.raises(ValueError, match="window is not full"):
        estimator.derivative(0, 0.0)


def test_what_cannot_be_fitted_is_refused() -> None:
    with pytest.raises(ValueError, match="window"):
        LocalPolynomial(3, 3)
    with pytest.raises(ValueError, match="order"):
        polynomial_weights([-1.0, 0.0], 1, 2, 0.0)
    with pytest.raises(ValueError, match="ascend"):
        polynomial_weights([-1.0, -1.0, 0.0], 1, 1, 0.0)


def test_scatter_is_that_of_the_noise_about_the_polynomial() -> None:
    rng = np.random.default_rng(5)
    stamps = STEP * np.arange(1, 401)
    values = np.column_stack(
        [3.0 + 40.0 * (stamps * 1e-9) ** 2 + noise * rng.standard_normal(400) for noise in (0, 0.2)]
    )
    estimator = fed(LocalPolynomial(400, 2, signals=2), stamps, values)
    assert estimator.scatter(0) == pytest.approx(0.0, abs=1e-9)
    assert estimator.scatter(1) == pytest.approx(0.2, rel=0.1)


def test_samples_that_the_polynomial_goes_through_show_no_scatter_and_an_unknown_one_makes_it_unknown() -> None:
    values = np.array([[1.0, 1.0], [5.0, np.nan], [2.0, 2.0]])
    stamps = STEP * np.arange(1, 4)
    assert fed(LocalPolynomial(3, 2, signals=2), stamps, values).scatter(0) == 0.0
    assert np.isnan(fed(LocalPolynomial(3, 1, signals=2), stamps, values).scatter(1))


@given(COEFFICIENTS, INTERVALS, st.integers(0, 2))
def test_older_half_is_read_at_its_centre_and_by_its_own_samples(
    coefficients: list[float], intervals: list[int], order: int
) -> None:
    parabola = np.polynomial.Polynomial(coefficients[:3])
    stamps = np.cumsum(intervals)
    time = (stamps - stamps[-1]) * 1e-7
    half = max(len(intervals) // 2, 3)
    values = np.where(np.arange(len(time)) < half, parabola(time), 1e9)
    estimator = fed(LocalPolynomial(len(intervals), 2), stamps, values[:, np.newaxis])
    exact = parabola.deriv(order)(0.5 * (time[0] + time[half - 1])) * 100.0**order
    size = np.abs(parabola(time)).max() + 1.0
    assert estimator.earlier(order) == pytest.approx(exact, abs=1e-6 * size * 1e3**order, rel=1e-6)
