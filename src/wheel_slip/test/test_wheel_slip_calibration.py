"""Radius calibration: the algorithm, and online."""

import numpy as np
import pytest

from vehicle_models.vehicle_file import load_vehicle
from wheel_slip.estimator import EstimatorParameters, SlipEstimator
from wheel_slip.radius_calibration import CalibrationParameters, Radii, RadiusCalibration
from wheel_slip.speed_sample import SpeedSample

STEP = 5_000_000
TRUE = np.array([0.301, 0.299, 0.304, 0.3035])


def coasting(seconds: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Stamps [ns], speed [m/s], noisy wheel speeds [rad/s]: from 20 m/s at -0.5 m/s^2."""
    t = np.arange(round(seconds / 0.005)) * 0.005
    speed = 20.0 - 0.5 * t
    omega = speed[:, np.newaxis] / TRUE + 0.07 * np.random.default_rng(2).normal(size=(t.size, 4))
    return np.arange(1, t.size + 1) * STEP, speed, omega


def calibrated(seconds: float) -> Radii | str:
    calibration = RadiusCalibration([0.3] * 4, CalibrationParameters())
    for stamp, speed, omega in zip(*coasting(seconds), strict=True):
        calibration.update(int(stamp), omega.tolist(), float(speed))
    return calibration.result()


def test_coasting_against_the_sensor_gives_the_radii() -> None:
    found = calibrated(8.0)
    assert isinstance(found, Radii)
    assert np.all(np.abs(np.array(found.radii) - TRUE) < 5.0 * np.array(found.stddevs) + 1e-6)
    assert max(found.stddevs) < 1e-4


def test_too_little_coasting_is_said() -> None:
    assert "coasting" in str(calibrated(1.0))


def test_braking_spin_curves_gaps_and_garbage_do_not_count() -> None:
    calibration = RadiusCalibration([0.3] * 4, CalibrationParameters())
    for k in range(1, 400):
        braked = (25.0 - 6.0 * k * 0.005) / TRUE
        assert not calibration.update(k * STEP, braked.tolist(), 25.0)
    calibration.reset()
    for k in range(1, 400):
        one_spins = 20.0 / TRUE * np.array([1.0, 1.0, 1.1, 1.0])
        assert not calibration.update(k * STEP, one_spins.tolist(), 20.0)
    calibration.reset()
    for k in range(1, 20):
        assert not calibration.update(k * 100 * STEP, (20.0 / TRUE).tolist(), 20.0)
        assert not calibration.update(k * 100 * STEP + STEP, [float("nan")] * 4, 20.0)


def test_online_radii_are_used_once_they_are_certain() -> None:
    estimator = SlipEstimator(load_vehicle("chapter_car"), EstimatorParameters(learn_radii=True))
    before = estimator.radii
    assert before == (0.3,) * 4
    for k, (stamp, speed, omega) in enumerate(zip(*coasting(24.0), strict=True)):
        measured = [SpeedSample(int(stamp), float(speed), 0.01)] if k % 10 == 0 else []
        row = estimator.update(int(stamp), omega.tolist(), -0.5, measured)
        if k == 3000:
            assert np.mean(estimator.radii) == pytest.approx(0.3, abs=2e-4)
    assert estimator.radii == pytest.approx(tuple(TRUE), abs=2e-4)
    assert [each.slip for each in row] == pytest.approx([0.0] * 4, abs=0.02)
    assert max(estimator.radius_variances) < 0.001**2


def test_a_wheel_that_was_named_is_not_once_its_radius_is_calibrated() -> None:
    estimator = SlipEstimator(load_vehicle("compact_car"), EstimatorParameters(learn_radii=True))
    rng = np.random.default_rng(3)
    texts = []
    for k in range(1, 4300):
        omega = 28.0 / (0.3 * np.array([1.0, 1.0, 0.96, 1.0])) + 0.07 * rng.normal(size=4)
        measured = [SpeedSample(k * STEP, 28.0 + 0.05 * rng.normal(), 0.01)] if k % 10 == 0 else []
        estimator.update(k * STEP, omega.tolist(), 0.1 * rng.normal(), measured)
        texts.append(estimator.radius_text)
    assert any(text.startswith("rear_left") for text in texts)
    assert texts[-1] == ""
    assert estimator.radii[2] == pytest.approx(0.288, rel=1e-3)
