"""The accelerometer as the sum of the forces of the wheels, in means over blocks of 40 ms.

    (a - b) / (1 + c) + sum of (J omega_dot + kappa T + T_drag) / (r m) + f_r g + drag v^2 / m + F_y steering / m = 0

Sample by sample the noise of the wheel speeds would drag the mass along with it.
"""

from math import exp

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.car.car_constants import CarConstants
from friction_curve_id.car.car_model import Motion, steering
from friction_curve_id.car.combined_slip import TyreSlips
from friction_curve_id.car.node_signals import Nodes
from friction_curve_id.car.unknowns import Unknown
from vehicle_models.constants import GRAVITY

Array = NDArray[np.float64]

_BLOCK = 0.04
_STDDEV = 0.05
"""Of a mean [m/s^2]."""
_OF_CORNERING = 0.3
"""Relative deviation of the drag of steered wheels: by what is not known of their slip angles [-]."""
OF_TORQUE = (
    Unknown.LOG_GAIN_FRONT,
    Unknown.LOG_GAIN_REAR,
    Unknown.FADING,
    Unknown.PRESSURE_DELAY,
    Unknown.ENGINE_DRAG,
)
"""Unknowns of the torque of brake and engine."""


def car_balance(
    car: CarConstants,
    nodes: Nodes,
    moved: Motion,
    tyres: TyreSlips,
    acting: Array,
    acting_jacobian: Array,
    unknowns: Array,
) -> tuple[Array, Array]:
    """Return the errors of the blocks in standard deviations, shape (B,), and their Jacobian, (B, SHARED + W).

    Only blocks in which the throttle is closed and all wheels turn throughout: at other times the engine drives, or a
    brake holds with less than its torque.

    Args:
        car: nominal values.
        nodes: measured signals.
        moved: their motion.
        tyres: their slips.
        acting: torque of brake and engine [N m], shape (W, n).
        acting_jacobian: its derivatives by OF_TORQUE, shape (W, n, 5).
        unknowns: shape (SHARED + W,).
    """
    p, n = unknowns, nodes.time.size
    told = (nodes.closed > 0.0) & nodes.turning.all(axis=0)
    if not told.any():
        return np.zeros(0), np.zeros((0, p.size))
    scale = 1.0 + p[Unknown.ACCELEROMETER_SCALE]
    mass = car.mass * exp(float(p[Unknown.LOG_MASS]))
    inertia = car.inertia * exp(float(p[Unknown.LOG_INERTIA]))
    per_wheel = 1.0 / (car.radius * mass)
    spinning = (inertia * per_wheel * nodes.wheel_acceleration).sum(axis=0)
    torques = (per_wheel * acting).sum(axis=0)
    rate = np.gradient(nodes.acceleration, nodes.time)
    corrected = nodes.acceleration + p[Unknown.ACCELEROMETER_DELAY] * rate
    corrected = (corrected - p[Unknown.ACCELEROMETER_OFFSET] + p[Unknown.PITCH_READING] * moved.pitch.pitch) / scale
    error = corrected + spinning + torques + car.rolling * GRAVITY + car.drag / mass * moved.speed**2
    stddev = np.full(n, _STDDEV)
    if tyres.across is not None:
        cornering = _cornering(car, nodes, moved, tyres.across)
        error += cornering
        stddev = np.hypot(_STDDEV, _OF_CORNERING * cornering)
    jacobian = np.zeros((n, p.size))
    jacobian[:, Unknown.ACCELEROMETER_OFFSET] = -1.0 / scale
    jacobian[:, Unknown.ACCELEROMETER_SCALE] = -corrected / scale
    jacobian[:, Unknown.ACCELEROMETER_DELAY] = rate / scale
    jacobian[:, Unknown.PITCH_READING] = moved.pitch.pitch / scale
    jacobian[:, Unknown.LOG_INERTIA] = spinning
    jacobian[:, Unknown.LOG_MASS] = -(spinning + torques)
    of_torque = np.einsum("wi,wnk->nk", per_wheel, acting_jacobian)
    for column, unknown in enumerate(OF_TORQUE):
        jacobian[:, unknown] = of_torque[:, column]
    means = block_means(np.column_stack([error, stddev, jacobian]), nodes, told)
    return means[:, 0] / means[:, 1], means[:, 2:] / means[:, 1:2]


def block_means(columns: Array, nodes: Nodes, told: NDArray[np.bool_]) -> Array:
    """Return the means of columns over the blocks of which all nodes are `told`, (n, m) to (B, m)."""
    n, m = columns.shape
    size = max(round(_BLOCK / nodes.sampling), 1)
    blocks = n // size
    first = n - blocks * size
    complete = told[first:].reshape(blocks, size).all(axis=1)
    return np.asarray(columns[first:].reshape(blocks, size, m).mean(axis=1)[complete])


def _cornering(car: CarConstants, nodes: Nodes, moved: Motion, across: Array) -> Array:
    """Deceleration by the lateral force of the front wheels, which are steered [m/s^2], shape (n,)."""
    share = car.share[car.front_wheel] + car.share[car.partner[car.front_wheel]]
    return np.asarray(share * np.abs(nodes.leftward) * steering(car, nodes, moved.speed, across))
