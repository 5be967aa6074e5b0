"""Both curve models against finite differences, and the uncertainty of a fitted curve against its definition."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from friction_curve_id.chapter.exponential_curve import EXPONENTS, ExponentialCurve, regressor
from friction_curve_id.chapter.least_squares import solve, triangle
from friction_curve_id.curve.burckhardt_curve import BurckhardtCurve
from friction_curve_id.curve.fitted_curve import CurveModel, FittedCurve, fit_covariance, samples_per_information
from vehicle_models import burckhardt
from vehicle_models.reason import Reason
from vehicle_models.surfaces import TABLE_8_1, surface

Array = NDArray[np.float64]


def exponential_fit(name: str) -> Array:
    slips = np.linspace(0.0, 0.6, 200, dtype=np.float64)
    return solve(triangle(slips, burckhardt.friction(surface(name), slips)), 200, 0.6).parameters


CURVES = [(BurckhardtCurve(), surface(name)) for name in TABLE_8_1] + [
    (ExponentialCurve(0.6), exponential_fit(name)) for name in TABLE_8_1
]


@pytest.mark.parametrize(("model", "parameters"), CURVES)
@pytest.mark.parametrize("slip", [0.004, 0.05, 0.3])
def test_derivatives_agree_with_finite_differences(model: CurveModel, parameters: Array, slip: float) -> None:
    h = 1e-6
    slope = (model.friction(parameters, slip + h) - model.friction(parameters, slip - h)) / (2 * h)
    curvature = (model.slope(parameters, slip + h) - model.slope(parameters, slip - h)) / (2 * h)
    assert model.slope(parameters, slip) == pytest.approx(slope, abs=1e-5)
    assert model.curvature(parameters, slip) == pytest.approx(curvature, rel=1e-4, abs=1e-4)
    for k, step in enumerate(1e-6 * np.maximum(np.abs(parameters), 1.0)):
        moved = step * np.eye(len(parameters))[k]
        change = model.friction(parameters + moved, slip) - model.friction(parameters - moved, slip)
        assert model.gradient(parameters, slip)[k] == pytest.approx(change / (2 * step), abs=1e-6)
        change = model.slope(parameters + moved, slip) - model.slope(parameters - moved, slip)
        assert model.slope_gradient(parameters, slip)[k] == pytest.approx(change / (2 * step), abs=1e-5)


@given(arrays(np.float64, 3, elements=st.floats(-1.0, 300.0)), st.floats(-1.0, 1.0))
def test_one_point_of_one_curve_is_that_of_many(theta: Array, slip: float) -> None:
    model = BurckhardtCurve()
    assert model.friction(theta, slip) == pytest.approx(float(burckhardt.friction(theta, slip)), rel=1e-12, abs=1e-12)
    assert model.slope(theta, slip) == pytest.approx(float(burckhardt.slope(theta, slip)), rel=1e-12, abs=1e-12)
    assert model.gradient(theta, slip) == pytest.approx(burckhardt.gradient(theta, slip), rel=1e-12, abs=1e-12)
    peak = float(burckhardt.peak(theta)[0])
    expected = peak if 0.0 < peak < 1.0 else math.nan
    assert model.peak(theta) == pytest.approx(expected, rel=1e-12, nan_ok=True)


@given(arrays(np.float64, 6, elements=st.floats(-30.0, 30.0)))
def test_peak_of_8_12_is_a_maximum_or_there_is_none(parameters: Array) -> None:
    model = ExponentialCurve(0.4)
    peak = model.peak(parameters)
    slips = np.linspace(0.0, 1.0, 5001, dtype=np.float64)
    frictions = regressor(slips) @ parameters
    if math.isnan(peak):
        # Nothing rises and then clearly falls between the ends of the search.
        rises, falls = np.diff(frictions) > 1e-9, np.diff(frictions) < -1e-9
        inside = (slips[1:-1] > 0.004) & (slips[1:-1] < 0.996)
        sharp = rises[:-1] & falls[1:] & inside
        assert not sharp.any()
    else:
        assert 0.0 < peak < 1.0
        near = regressor(np.array([peak - 1e-3, peak, peak + 1e-3])) @ parameters
        assert near[1] >= max(near[0], near[2]) - 1e-9


@given(arrays(np.float64, 6, elements=st.floats(-1e4, 1e4)))
def test_the_slope_of_8_12_vanishes_at_the_peak_to_rounding(parameters: Array) -> None:
    model = ExponentialCurve(0.4)
    peak = model.peak(parameters)
    if not math.isnan(peak):
        terms = np.abs(model.slope_gradient(parameters, peak) * parameters).sum()
        curvature = abs(model.curvature(parameters, peak))
        underflow = np.finfo(np.float64).tiny  # below it floats have no digits left to be relative to
        assert abs(model.slope(parameters, peak)) <= 1e-14 * terms + 2e-12 * curvature + underflow


def test_peak_of_8_12_among_the_data_goes_before_an_extrapolated_one() -> None:
    parameters = np.array([0.0, 0.0, 0.0, 0.0, 1.0, 0.0])
    assert math.isnan(ExponentialCurve(0.2).peak(parameters))
    slips = np.linspace(0.0, 1.0, 300, dtype=np.float64)
    two_peaks = solve(triangle(slips, np.sin(slips * 9.0)), 300, 1.0).parameters
    near, far = ExponentialCurve(0.5).peak(two_peaks), ExponentialCurve(1.0).peak(two_peaks)
    assert near <= 0.5
    assert model_friction(two_peaks, far) >= model_friction(two_peaks, near) - 1e-12


def model_friction(parameters: Array, slip: float) -> float:
    return ExponentialCurve(1.0).friction(parameters, slip)


@pytest.mark.parametrize(("model", "parameters"), CURVES)
def test_standard_deviations_are_those_of_perturbed_peaks(model: CurveModel, parameters: Array) -> None:
    generator = np.random.default_rng(5)
    root = 1e-5 * np.diag(np.maximum(np.abs(parameters), 0.1)) @ generator.normal(size=(len(parameters),) * 2)
    estimate = FittedCurve(model, parameters, root @ root.T).estimate(0.05, 100, 0.9)
    drawn = parameters + generator.normal(size=(4000, len(parameters))) @ root.T
    peaks = np.array([model.peak(each) for each in drawn])
    heights = np.array([model.friction(each, peak) for each, peak in zip(drawn, peaks, strict=True)])
    assert estimate.lambda_max_stddev == pytest.approx(np.std(peaks), rel=0.06)
    assert estimate.mu_max_stddev == pytest.approx(np.std(heights), rel=0.06)
    assert estimate.slope_stddev == pytest.approx(np.std([model.slope(each, 0.05) for each in drawn]), rel=0.06)


@pytest.mark.parametrize(("slip", "least", "most"), [(0.05, 0.0, 0.01), (0.17, 0.4, 0.6), (0.3, 0.99, 1.0)])
def test_probability_beyond_the_peak_is_a_half_at_the_peak(slip: float, least: float, most: float) -> None:
    curve = FittedCurve(BurckhardtCurve(), surface("dry"), np.diag([0.01, 1.0, 0.05]) ** 2)
    assert least <= curve.estimate(slip, 100, 0.4).probability_beyond_peak <= most


def test_an_estimate_says_why_its_peak_is_not_to_be_used() -> None:
    theta, tight = surface("dry"), 1e-6 * np.eye(3)
    model = BurckhardtCurve()
    assert FittedCurve(model, theta, tight).estimate(0.1, 50, 0.3).valid
    assert FittedCurve(model, theta, tight).estimate(0.1, 50, 0.1).reason is Reason.PEAK_NOT_PASSED
    assert FittedCurve(model, theta, 100.0 * np.eye(3)).estimate(0.1, 50, 0.3).reason is Reason.UNCERTAIN
    unknown = FittedCurve(model, theta, np.full((3, 3), np.nan)).estimate(0.1, 50, 0.3)
    assert unknown.reason is Reason.UNCERTAIN
    assert math.isnan(unknown.probability_beyond_peak)
    rising = FittedCurve(model, theta * [1.0, 1.0, -1.0], tight).estimate(0.1, 50, 0.3)
    assert rising.reason is Reason.NO_PEAK
    assert math.isnan(rising.lambda_max)


@pytest.mark.parametrize("kind", ["white", "differenced", "smoothed"])
def test_fit_covariance_is_that_of_repeated_fits(kind: str) -> None:
    generator = np.random.default_rng(8)
    rows = np.column_stack([np.ones(120), np.linspace(-1.0, 1.0, 120)])
    fits, claimed = [], []
    for _ in range(400):
        noise = generator.normal(size=124)
        colours = {
            "white": noise[:120],
            "differenced": np.diff(noise)[:120] + 0.3 * generator.normal(size=120),
            "smoothed": np.convolve(noise, np.ones(5) / 5, "valid"),
        }
        errors = colours[kind]
        found = np.linalg.lstsq(rows, errors, rcond=None)[0]
        fits.append(found)
        claimed.append(np.diag(fit_covariance(rows, errors - rows @ found)))
    ratio = np.sqrt(np.mean(claimed, axis=0)) / np.std(fits, axis=0)
    assert np.all(ratio > 0.85)
    assert np.all(ratio < 1.3)


def test_alike_residuals_carry_less_information() -> None:
    noise = np.random.default_rng(2).normal(size=4000)
    assert samples_per_information(np.repeat(noise[:400], 10)) == pytest.approx(10.0, rel=0.25)
    assert samples_per_information(noise) < 1.2
    assert samples_per_information(np.zeros(10)) == 1.0


def test_exponents_are_those_of_the_chapter() -> None:
    assert EXPONENTS.tolist() == [4.0, 36.0, 68.0, 100.0]
