"""Scatter of the fronts of the contact patch, beside the limits set by the noise.

Noise over slope is the limit of a level crossing. The Cramer-Rao bound is that of the whole passage (50
degrees to either side of the patch centre) with the waveform known up to amplitude and offset, and the coloured noise
known exactly.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, signal

from benchmarks.smart_tyre.runs import NOISY, QUIET, RING, TRACKER, Sensors, passages, simulate
from smart_tyre_forces.front_template import FrontRefiner
from smart_tyre_forces.fronts import LEVEL
from smart_tyre_forces.reasons import PatchReason
from smart_tyre_forces.tooth_table import ToothTable
from vehicle_models.force_history import steady_drive
from vehicle_models.tyre_signal import AccelerometerParameters

Array = NDArray[np.float64]

_WITHOUT_JITTER = replace(NOISY, accelerometer=replace(NOISY.accelerometer, edge_jitter=0.0))
_HALF_WINDOW = np.radians(50.0)
_SETTLED = 100
"""Samples after which the sensor's filter has settled."""
_SMALL = 3e-3
"""Step of the numerical slope [rad]."""


def scatter(
    speed: float, axle: str, seeds: range, table: ToothTable, refiners: list[FrontRefiner | None], duration: float
) -> Array:
    """RMS of alpha_1 and alpha_2 [rad] about their mean in each run at constant speed, without edge jitter.

    Returns:
        Shape (2,), pooled over the runs; one refiner (or None) for each seed.
    """
    squares, count = np.zeros(2), 0
    drive = steady_drive(speed, duration, road_seed=0)
    for seed, refiner in zip(seeds, refiners, strict=True):
        block = simulate(drive, axle, seed, _WITHOUT_JITTER)
        found = [p for p in passages(block, table, refiner) if p.reason is PatchReason.OK]
        fronts = np.array([(p.alpha_1, p.alpha_2) for p in found])
        squares += np.sum((fronts - fronts.mean(axis=0)) ** 2, axis=0)
        count += len(fronts) - 1
    return np.asarray(np.sqrt(squares / count))


class Waveform:
    """The noise-free signal of one passage over the wheel angle, and the noise on it."""

    def __init__(self, speed: float, sensors: Sensors = _WITHOUT_JITTER) -> None:
        """Fold many noise-free revolutions at `speed` [m/s] into one."""
        self._step = speed / RING.radius / TRACKER.sample_rate
        block = simulate(steady_drive(speed, 20.0, road_seed=0), "front", 0, QUIET)
        angle = np.mod(block.wheel_angle[_SETTLED:], 2.0 * np.pi)
        order = np.argsort(angle)
        grid = np.linspace(0.0, 2.0 * np.pi, 7200, endpoint=False)
        wave = np.interp(grid, angle[order], block.radial_acceleration[_SETTLED:][order], period=2.0 * np.pi)
        width = 480
        mean = np.convolve(np.concatenate((wave, wave)), np.ones(width), "valid")[: len(wave)]
        self._angle = grid - np.pi
        self._wave = np.roll(wave, len(wave) // 2 - int(np.argmin(mean)) - width // 2)
        self._covariance = noise_covariance(sensors.accelerometer, speed, round(2.0 * _HALF_WINDOW / self._step) + 2)
        level = LEVEL * (speed / RING.radius) ** 2 * RING.radius
        above = self._wave > level
        self._fronts = (
            float(self._angle[np.flatnonzero(above[:-1] & ~above[1:])[0]]),
            float(self._angle[np.flatnonzero(~above[:-1] & above[1:])[-1]]),
        )

    def _at(self, angle: Array) -> Array:
        return np.asarray(np.interp(angle, self._angle, self._wave))

    def _slope(self, angle: Array) -> Array:
        return (self._at(angle + _SMALL) - self._at(angle - _SMALL)) / (2.0 * _SMALL)

    def noise_over_slope(self) -> Array:
        """Deviation of both fronts at the crossing of a level [rad], shape (2,)."""
        return np.asarray(np.sqrt(self._covariance[0]) / np.abs(self._slope(np.array(self._fronts))))

    def cramer_rao(self) -> Array:
        """Bound of the deviation of both fronts [rad], shape (2,); amplitude and offset unknown."""
        angle = np.arange(-_HALF_WINDOW, _HALF_WINDOW, self._step)
        slope = self._slope(angle)
        before = angle < 0.5 * sum(self._fronts)
        design = np.stack(
            [np.where(before, slope, 0.0), np.where(before, 0.0, slope), self._at(angle), np.ones(len(angle))], axis=1
        )
        information = design.T @ linalg.solve_toeplitz(self._covariance[: len(angle)], design)
        return np.asarray(np.sqrt(np.diag(np.linalg.inv(information))[:2]))


def noise_covariance(p: AccelerometerParameters, speed: float, lags: int) -> Array:
    """Autocovariance [m^2/s^4] of the accelerometer's noise at `speed` [m/s], shape (lags,)."""
    impulse = np.zeros(8192)
    impulse[0] = 1.0
    band = signal.butter(2, p.texture_band, "bandpass", fs=TRACKER.sample_rate, output="sos")
    sensor = signal.butter(2, p.bandwidth, fs=TRACKER.sample_rate, output="sos")
    shaking = signal.sosfilt(band, impulse)
    shaking *= p.texture_noise * (speed / 20.0) ** 1.5 / np.sqrt(np.sum(shaking**2))
    felt = signal.sosfilt(sensor, shaking)
    covariance = np.asarray(signal.correlate(felt, felt, "full")[len(felt) - 1 :][:lags]).copy()
    covariance[0] += p.electronic_noise**2 + p.resolution**2 / 12.0
    return covariance
