"""Prediction of the next wheel speed by the wheel equation (2.15), with its standard deviation."""

from dataclasses import dataclass
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.exact_vehicle.braking_window import BrakingWindow
from friction_curve_id.measurement_noise import MeasurementNoise
from vehicle_models import burckhardt_log
from vehicle_models.vehicle import CornerParameters

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Prediction:
    """Prediction of the next sample."""

    wheel_speed: float
    """[rad/s]"""
    stddev: float
    """Standard deviation of the next measured wheel speed about the predicted one [rad/s]."""
    speed: float
    """Vehicle speed [m/s]."""


def predict(
    window: BrakingWindow,
    q: Array,
    momentum_speed: float,
    covariance: Array,
    wheel: CornerParameters,
    noise: MeasurementNoise,
    time: float,
    torque: float,
    equation_trust: float,
) -> Prediction:
    """Predict the sample at `time` [s] under `torque` [N m] from the newest of the window.

    One linearly implicit trapezoidal step, stable however steep the curve. `covariance` is that of (q, u, newest
    omega), shape (5, 5); `equation_trust` the weight of the wheel equation in the window.
    """
    last = window.count - 1
    omega = float(window.wheel_speed[last])
    interval = time - float(window.time[last])
    impulse = window.impulse_after(time, torque)
    newest = window.newest_slip(momentum_speed)
    mu_row = np.empty(5)
    mu, slope = map(float, burckhardt_log.friction_into(q, newest.slip, mu_row[:3]))
    mu_row[3], mu_row[4] = slope * newest.per_u, slope * newest.per_omega

    gain = interval * wheel.radius * wheel.vertical_load / wheel.inertia
    impulse_effect = -slope * newest.per_u * (impulse - float(window.impulse[last]))
    mean_torque = 0.5 * (float(window.torque[last]) + torque)
    change = gain * (mu + 0.5 * impulse_effect) - interval / wheel.inertia * mean_torque
    implicit = 1.0 / max(1.0 - 0.5 * gain * slope * newest.per_omega, 0.1)
    predicted = omega + implicit * change

    row = implicit * gain * mu_row
    row[4] += 1.0
    process = noise.torque * interval / wheel.inertia
    variance = float(row @ covariance @ row) + process**2 / equation_trust + noise.wheel_speed**2
    return Prediction(predicted, sqrt(variance), momentum_speed - window.speed_per_wheel_speed * predicted - impulse)
