"""The Burckhardt curve against closed forms, finite differences and the chapter's own numbers."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_models import burckhardt
from vehicle_models.surfaces import SURFACES, TABLE_8_1, surface

THETAS = st.tuples(st.floats(0.05, 2.0), st.floats(2.0, 120.0), st.floats(0.01, 1.0)).map(np.array)


@pytest.mark.parametrize(
    ("name", "lambda_max", "mu_max"),
    [
        ("dry", 0.1700, 1.1699),
        ("wet", 0.1307, 0.8039),
        # The chapter prints mu_max = 1.0014 for cobblestone; its own parameters give 0.9986, worked by hand.
        ("cobblestone", 0.3995, 0.9986),
        ("snow", 0.0605, 0.1857),
    ],
)
def test_peak_agrees_with_tables_8_2_and_8_3(name: str, lambda_max: float, mu_max: float) -> None:
    found = burckhardt.peak(surface(name))
    assert found[0] == pytest.approx(lambda_max, abs=1e-4)
    assert found[1] == pytest.approx(mu_max, abs=1.1e-4)


def test_test_roads_have_the_peaks_of_tables_8_4_and_8_5() -> None:
    assert burckhardt.peak(surface("high_grip"))[0] == pytest.approx(0.1, abs=5e-4)
    assert burckhardt.peak(surface("off_road"))[0] == pytest.approx(0.13, abs=5e-4)


@given(THETAS, st.floats(0.001, 0.99))
def test_slope_is_the_derivative_of_friction(theta: np.ndarray, slip: float) -> None:
    h = 1e-6
    difference = (burckhardt.friction(theta, slip + h) - burckhardt.friction(theta, slip - h)) / (2 * h)
    assert burckhardt.slope(theta, slip) == pytest.approx(difference, abs=1e-5)


@given(THETAS, st.floats(-0.99, 0.99))
def test_gradient_is_the_derivative_with_respect_to_theta(theta: np.ndarray, slip: float) -> None:
    for k in range(3):
        h = 1e-6 * theta[k]
        up, down = theta.copy(), theta.copy()
        up[k] += h
        down[k] -= h
        difference = (burckhardt.friction(up, slip) - burckhardt.friction(down, slip)) / (2 * h)
        assert burckhardt.gradient(theta, slip)[k] == pytest.approx(difference, abs=1e-6)


@given(THETAS)
def test_no_slip_has_more_friction_than_the_peak(theta: np.ndarray) -> None:
    lambda_max, mu_max = burckhardt.peak(theta)
    if np.isfinite(lambda_max):
        assert burckhardt.friction(theta, lambda_max) == pytest.approx(mu_max, rel=1e-9)
        assert np.all(burckhardt.friction(theta, np.linspace(0.0, 2.0, 401)) <= mu_max + 1e-12)


def test_curve_is_odd_so_that_traction_mirrors_braking() -> None:
    slip = np.linspace(-0.9, 0.9, 37)
    theta = SURFACES["dry"]
    np.testing.assert_allclose(burckhardt.friction(theta, -slip), -burckhardt.friction(theta, slip))
    np.testing.assert_allclose(burckhardt.gradient(theta, -slip), -burckhardt.gradient(theta, slip))


def test_curves_broadcast_over_roads_and_slips() -> None:
    theta = np.stack([SURFACES[name] for name in TABLE_8_1])
    slip = np.linspace(0.0, 0.5, 7)
    table = burckhardt.friction(theta[:, np.newaxis, :], slip)
    assert table.shape == (4, 7)
    assert table[2, 3] == burckhardt.friction(theta[2], slip[3])
    assert burckhardt.gradient(theta[:, np.newaxis, :], slip).shape == (4, 7, 3)


@pytest.mark.parametrize(
    "theta", [[1.0, 20.0, 0.0], [0.0, 20.0, 0.1], [0.5, 1.0, 0.6], [1.0, -3.0, 0.1], [np.nan, 1, 1]]
)
def test_curve_without_a_peak_has_nan_for_it(theta: list[float]) -> None:
    assert np.all(np.isnan(burckhardt.peak(theta)))


def test_bad_shape_and_unknown_road_are_refused_by_name() -> None:
    with pytest.raises(ValueError, match="theta has shape"):
        burckhardt.friction([1.0, 2.0], 0.1)
    with pytest.raises(ValueError, match="unknown surface 'ice'"):
        surface("ice")
