"""Cramer-Rao bound of lambda_max from the raw measurements of one braking, by the sensitivities of the dynamics.

Unknown are theta, the initial wheel and vehicle speed, and the brake torque at every sample (linear between them),
which is measured with noise like the two speeds: a nuisance, eliminated here. The sensitivities of (2.15) to all of
these are integrated together with the motion (Runge-Kutta 4, five sub-steps a sample; the wheel pole of the protocol
is below 400/s).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from benchmarks.protocol import CORNER
from corner_sim.sensors import CHAPTER_NOISE, SensorNoise
from vehicle_models import burckhardt
from vehicle_models.vehicle import CornerParameters

Array = NDArray[np.float64]

_SUB_STEPS = 5
_INITIAL = 5
"""Unknowns before the torques: theta, omega_0, v_0."""


@dataclass(frozen=True)
class Sensitivities:
    """Derivatives of the motion with respect to (theta, omega_0, v_0, T_0 ... T_{N-1}), shapes (n, N, 5 + N)."""

    wheel_speed: Array
    speed: Array


def sensitivities(
    theta: ArrayLike, torque: Array, interval: float, speed: float, corner: CornerParameters = CORNER
) -> Sensitivities:
    """Integrate the motion and its derivatives, from free rolling.

    Args:
        theta: roads, shape (n, 3).
        torque: brake torque at the samples [N m], shape (n, N).
        interval: sample time [s].
        speed: initial vehicle speed [m/s].
        corner: wheel and load.
    """
    roads = np.atleast_2d(np.asarray(theta, dtype=np.float64))
    count, samples = torque.shape
    state = np.tile([speed / corner.radius, speed], (count, 1))
    derivative: Array = np.zeros((count, 2, _INITIAL + samples))
    derivative[:, 0, 3] = derivative[:, 1, 4] = 1.0
    history = np.zeros((count, samples, 2, _INITIAL + samples))
    step = interval / _SUB_STEPS

    def rates(x: Array, s: Array, k: int, share: float) -> tuple[Array, Array]:
        return _rates(roads, corner, x, s, torque, k, share)

    for k in range(samples):
        history[:, k] = derivative
        if k == samples - 1:
            break
        for i in range(_SUB_STEPS):
            begin, middle, end = i / _SUB_STEPS, (i + 0.5) / _SUB_STEPS, (i + 1) / _SUB_STEPS
            x1, s1 = rates(state, derivative, k, begin)
            x2, s2 = rates(state + 0.5 * step * x1, derivative + 0.5 * step * s1, k, middle)
            x3, s3 = rates(state + 0.5 * step * x2, derivative + 0.5 * step * s2, k, middle)
            x4, s4 = rates(state + step * x3, derivative + step * s3, k, end)
            state = state + step / 6.0 * (x1 + 2.0 * x2 + 2.0 * x3 + x4)
            derivative = derivative + step / 6.0 * (s1 + 2.0 * s2 + 2.0 * s3 + s4)
    return Sensitivities(history[:, :, 0], history[:, :, 1])


def _rates(
    theta: Array, corner: CornerParameters, state: Array, derivative: Array, torque: Array, k: int, share: float
) -> tuple[Array, Array]:
    """Rates of (omega, v) and of their derivatives at `share` of the interval after sample k."""
    omega, speed = state[:, 0], state[:, 1]
    slip = 1.0 - omega * corner.radius / speed
    slope = burckhardt.slope(theta, slip)
    of_mu = slope[:, np.newaxis] * (
        (-corner.radius / speed)[:, np.newaxis] * derivative[:, 0]
        + (omega * corner.radius / speed**2)[:, np.newaxis] * derivative[:, 1]
    )
    of_mu[:, :3] += burckhardt.gradient(theta, slip)
    force = corner.vertical_load * burckhardt.friction(theta, slip)
    brake = (1.0 - share) * torque[:, k] + share * torque[:, k + 1]
    lever = corner.radius * corner.vertical_load / corner.inertia
    of_omega = lever * of_mu
    of_omega[:, _INITIAL + k] -= (1.0 - share) / corner.inertia
    of_omega[:, _INITIAL + k + 1] -= share / corner.inertia
    of_speed = -corner.vertical_load / corner.mass * of_mu
    motion = np.stack([(corner.radius * force - brake) / corner.inertia, -force / corner.mass], axis=-1)
    return motion, np.stack([of_omega, of_speed], axis=1)


def information(found: Sensitivities, samples: int, noise: SensorNoise = CHAPTER_NOISE) -> Array:
    """Fisher information of theta from the first `samples` samples, shape (n, 3, 3): all other unknowns eliminated."""
    used = _INITIAL + samples
    omega, speed = found.wheel_speed[:, :samples, :used], found.speed[:, :samples, :used]
    full = np.einsum("nki,nkj->nij", omega, omega) / noise.wheel_speed_variance
    full += np.einsum("nki,nkj->nij", speed, speed) / noise.speed_variance
    torques = np.arange(_INITIAL, used)
    full[:, torques, torques] += 1.0 / noise.torque_variance
    coupling = full[:, :3, 3:]
    return np.asarray(full[:, :3, :3] - coupling @ np.linalg.solve(full[:, 3:, 3:], np.swapaxes(coupling, 1, 2)))


def relative_bound(theta: ArrayLike, of_theta: Array) -> Array:
    """Smallest standard deviation of lambda_max relative to it, shape (n,).

    Args:
        theta: roads, shape (n, 3).
        of_theta: information of theta, shape (n, 3, 3).
    """
    roads = np.atleast_2d(np.asarray(theta, dtype=np.float64))
    exponent = burckhardt.peak_exponent(roads)
    # lambda_max = ln(th1 th2 / th3) / th2; logarithms: equal steps are equal shares of each parameter
    gradient = np.stack([1.0 / exponent, 1.0 / exponent - 1.0, -1.0 / exponent], axis=-1)
    of_log = roads[:, :, np.newaxis] * of_theta * roads[:, np.newaxis, :]
    return np.asarray(np.sqrt(np.einsum("ni,nij,nj->n", gradient, np.linalg.inv(of_log), gradient)))
