"""Lateral slip of the rear axle by the motion of the car against that by its force, in means over blocks of 40 ms.

    s_y = (b yaw' - v_y) / v,    v_y = v_y0 + integral of (a_y - b_y - yaw' v)

The rear wheels are not steered. v_y0 and the biases of the sensors leave the slip itself unknown, its changes hardly;
a force alone gives s_y over lambda_max.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.car.car_balance import block_means
from friction_curve_id.car.car_constants import CarConstants
from friction_curve_id.car.car_model import Motion, relaxed_by
from friction_curve_id.car.combined_slip import TyreSlips
from friction_curve_id.car.node_signals import Nodes
from friction_curve_id.car.unknowns import Unknown

Array = NDArray[np.float64]

_STDDEV: Final = 0.004
"""Of a mean: the axle steers by compliance and roll [rad]."""


def rear_slip(
    car: CarConstants, nodes: Nodes, moved: Motion, tyres: TyreSlips, gradient: Array, unknowns: Array
) -> tuple[Array, Array]:
    """Return the errors of the blocks in standard deviations, shape (B,), and their Jacobian, (B, SHARED + W).

    Args:
        car: nominal values.
        nodes: measured signals.
        moved: their motion.
        tyres: their slips, with s_y.
        gradient: d s_y by the unknowns, shape (W, n, SHARED + W).
        unknowns: shape (SHARED + W,).
    """
    assert tyres.across is not None
    p, rear = unknowns, car.rear_wheel
    per_curve = nodes.start_speed / car.half_track
    bias = p[Unknown.CURVE] * per_curve
    sideways = p[Unknown.SIDEWAYS] + nodes.sideways - p[Unknown.LATERAL_OFFSET] * nodes.time
    turned = np.cumsum(moved.speed * nodes.interval)
    turned += nodes.time[0] * nodes.start_speed - turned[0]
    kinematic = (car.behind * (nodes.yaw_rate - bias) - sideways - bias * turned) / moved.speed
    left = 1.0 if float(nodes.leftward.mean()) > 0.0 else -1.0
    error = tyres.across[rear] - left * relaxed_by(moved, nodes, p, kinematic)
    jacobian = gradient[rear].copy()
    per_speed = left / moved.speed
    jacobian[:, Unknown.SIDEWAYS] += per_speed
    jacobian[:, Unknown.LATERAL_OFFSET] -= per_speed * nodes.time
    jacobian[:, Unknown.CURVE] += per_speed * per_curve * (car.behind + turned)
    stddev = np.hypot(_STDDEV, np.broadcast_to(tyres.across_stddev, moved.slip.shape)[rear])
    columns = np.column_stack([error, stddev, jacobian])
    means = block_means(columns, nodes, nodes.turning[rear] & nodes.turning[car.partner[rear]])
    return means[:, 0] / means[:, 1], means[:, 2:] / means[:, 1:2]
