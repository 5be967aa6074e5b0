"""Motion of the car and of its wheels between the samples, as functions of the unknowns, with their derivatives.

At the nodes between neighbouring wheel speeds (node_signals.py):

    v = r omega_0 + v_0 + (integral of (a - b + G p) + tau_a (a - a_0)) / (1 + c) - g theta t,    p: see pitch
    lambda_i = 1 - r_i omega_i / v + offset_i +- (curve + curve_rate t)     left, right
    s_i' = (lambda_i - s_i) v / sigma                 relaxation, solved exactly for lambda linear between nodes
    Fz_i = m (g share_i + transfer_i q),  q: see pitch
"""

from dataclasses import dataclass
from math import exp

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dtbtrs

from friction_curve_id.car.car_constants import CarConstants
from friction_curve_id.car.node_signals import Nodes
from friction_curve_id.car.pitch import Pitch, PitchState, pitch_of_body
from friction_curve_id.car.unknowns import FADING_WORK, SHARED, Unknown
from vehicle_models.constants import GRAVITY

Array = NDArray[np.float64]

_LEAST_SPEED = 0.5
_LEAST_GAIN = 0.1
_FIRST = 8
"""Nodes whose mean specific force the body is at rest under at the start."""
LEAST_RELAXATION = 5e-3
SPEED_UNKNOWNS = (
    Unknown.START_SPEED,
    Unknown.ACCELEROMETER_OFFSET,
    Unknown.SLOPE,
    Unknown.ACCELEROMETER_SCALE,
    Unknown.ACCELEROMETER_DELAY,
    Unknown.PITCH_READING,
)


@dataclass(frozen=True)
class Carried:
    """State of the motion that older, forgotten nodes leave to the first."""

    slip: Array | None = None
    """Relaxed slip at the first node [-], shape (W,); None where it follows from the slip there."""
    pitch: PitchState | None = None
    """None: the body is at rest under the first specific force."""
    pitched: float = 0.0
    """Integral of the pitch before the first node [m/s]."""


@dataclass(frozen=True)
class Motion:
    """Speed, slip and load at the nodes with their derivatives."""

    speed: Array
    """[m/s], shape (n,)."""
    speed_gradient: Array
    """d v / d SPEED_UNKNOWNS, shape (6, n)."""
    slip: Array
    """Slip lambda [-], shape (W, n)."""
    relaxed: Array
    """Slip s that the tyre's force follows [-], shape (W, n)."""
    relaxed_by_speed: Array
    """d s / d SPEED_UNKNOWNS, shape (6, W, n)."""
    relaxed_by_offset: Array
    """d s / d offset of the slip of the wheel [-], shape (n,)."""
    relaxed_by_growth: Array
    """d s / d growth of the offset of the slip since time 0 [s], shape (n,)."""
    relaxed_by_length: Array
    """d s / d relaxation length [1/m], shape (W, n)."""
    load: Array
    """[N], shape (W, n)."""
    load_by_height: Array
    """d load / d ln(h / L) [N], shape (W, n)."""
    load_by_scale: Array
    """d load / d scale of the accelerometer [N], shape (W, n)."""
    load_by_offset: Array
    """d load / d offset of the accelerometer [kg], shape (W, 1)."""
    load_by_share: Array
    """d load / d front load share [N], shape (W, 1)."""
    load_by_roll: Array
    """d load / d share of the roll moment at the front [N], shape (W, n)."""
    load_by_pitch: Array
    """d load / d (ln w, zeta, d) [N], shape (3, W, n)."""
    force: Array
    """Specific force, braking positive [m/s^2], shape (n,)."""
    pitch: Pitch
    """Pitch, in units of the specific force, braking positive."""
    immediate: Array
    """d s / d slip at the same node [-], shape (n,)."""


def speeds(nodes: Nodes, unknowns: Array, pitch: Array, pitched: float) -> tuple[Array, Array]:
    """Return the speed [m/s], shape (n,), and its gradient by SPEED_UNKNOWNS, shape (6, n).

    `pitch`: see Pitch, shape (n,); `pitched`: its integral before the first node [m/s].
    """
    p, t = unknowns, nodes.time
    scale = 1.0 + p[Unknown.ACCELEROMETER_SCALE]
    delay = p[Unknown.ACCELEROMETER_DELAY]
    turned = pitched + np.cumsum(pitch * nodes.interval)
    own = nodes.speed_change - p[Unknown.ACCELEROMETER_OFFSET] * t + delay * nodes.acceleration_change
    own = (own + p[Unknown.PITCH_READING] * turned) / scale
    speed = nodes.start_speed + p[Unknown.START_SPEED] + own - p[Unknown.SLOPE] * t
    gradient = np.empty((6, t.size))
    gradient[0] = 1.0
    gradient[1] = -t / scale
    gradient[2] = -t
    gradient[3] = -own / scale
    gradient[4] = nodes.acceleration_change / scale
    gradient[5] = turned / scale
    return np.maximum(speed, _LEAST_SPEED), gradient


def motion(car: CarConstants, nodes: Nodes, unknowns: Array, carried: Carried, across: Array | None = None) -> Motion:
    """Return the motion.

    Args:
        car: nominal values.
        nodes: measured signals.
        unknowns: shape (SHARED + W,).
        carried: state that older nodes left.
        across: lateral slips s_y of the tyres [-], shape (W, n); None: the car goes straight.
    """
    p, wheels, n = unknowns, car.wheels, nodes.time.size
    force = -(nodes.acceleration - p[Unknown.ACCELEROMETER_OFFSET]) / (1.0 + p[Unknown.ACCELEROMETER_SCALE])
    pitch = pitch_of_body(force, nodes.sampling, p, carried.pitch or _at_rest(force))
    speed, gradient = speeds(nodes, p, pitch.pitch, carried.pitched)
    ground = speed - car.left * car.half_track * nodes.yaw_rate
    if across is not None:
        ground += car.front * speed * _steered(car, nodes, speed, across)
    ground = np.maximum(ground, _LEAST_SPEED)
    rolling = car.radius * nodes.wheel_speed / ground
    slip = 1.0 - rolling + p[SHARED:, np.newaxis] + car.left * (p[Unknown.CURVE] + p[Unknown.CURVE_RATE] * nodes.time)

    interval = np.diff(nodes.time)
    length = max(float(p[Unknown.RELAXATION_LENGTH]), LEAST_RELAXATION)
    x = np.maximum(0.5 * (speed[1:] + speed[:-1]) * interval / length, 1e-6)
    keep = np.exp(-x)
    mean_decay = -np.expm1(-x) / x
    before, after = mean_decay - keep, 1.0 - mean_decay
    inputs = np.empty((7 * wheels + 2, n))
    slip_by_speed = rolling / ground
    inputs[:wheels] = slip
    inputs[wheels : 7 * wheels] = (gradient[:, np.newaxis, :] * slip_by_speed).reshape(6 * wheels, n)
    inputs[7 * wheels] = 1.0
    inputs[7 * wheels + 1] = nodes.time
    held = np.empty((n, 7 * wheels + 2), order="F")
    held.T[:, 1:] = before * inputs[:, :-1] + after * inputs[:, 1:]
    held.T[:, 0] = inputs[:, 0]
    if carried.slip is not None:
        held[0, :wheels] = carried.slip
    relaxed = recursion(keep, held).T
    immediate = np.ones(n)
    immediate[1:] = after
    s = relaxed[:wheels]
    by_x = -keep * s[:, :-1]
    decay_by_x = (keep - mean_decay) / x
    by_x += (decay_by_x + keep) * slip[:, :-1] - decay_by_x * slip[:, 1:]
    driving = np.zeros((n, wheels), order="F")
    driving.T[:, 1:] = by_x * (-x / length)
    by_length = recursion(keep, driving).T

    mass = car.mass * exp(float(p[Unknown.LOG_MASS]))
    height = car.transfer * exp(float(p[Unknown.LOG_HEIGHT_RATIO]))
    share = car.share_fixed + car.share_sign * p[Unknown.FRONT_LOAD_SHARE]
    rolled = mass * exp(float(p[Unknown.LOG_HEIGHT_RATIO])) * car.roll * nodes.rolled
    of_axle = np.where(car.front > 0.0, p[Unknown.FRONT_ROLL_SHARE], 1.0 - p[Unknown.FRONT_ROLL_SHARE])
    pitched = mass * height * pitch.load
    load_by_height = pitched + of_axle * rolled
    load = np.maximum(mass * GRAVITY * share + load_by_height, 1.0)
    return Motion(
        speed,
        gradient,
        slip,
        s,
        relaxed[wheels : 7 * wheels].reshape(6, wheels, n),
        relaxed[7 * wheels],
        relaxed[7 * wheels + 1],
        by_length,
        load,
        load_by_height,
        -pitched / (1.0 + p[Unknown.ACCELEROMETER_SCALE]),
        mass * height / (1.0 + p[Unknown.ACCELEROMETER_SCALE]),
        mass * GRAVITY * car.share_sign,
        np.where(car.front > 0.0, rolled, -rolled),
        mass * height * pitch.load_gradient[:, np.newaxis, :],
        force,
        pitch,
        immediate,
    )


def relaxed_by(moved: Motion, nodes: Nodes, unknowns: Array, slip: Array) -> Array:
    """Return the slip of a tyre that follows a kinematic one [-], shape (n,), and begins with it."""
    length = max(float(unknowns[Unknown.RELAXATION_LENGTH]), LEAST_RELAXATION)
    keep = np.exp(-np.diff(nodes.time) * moved.speed[1:] / length)
    driving = np.empty((slip.size, 1), order="F")
    driving[0, 0] = slip[0]
    driving[1:, 0] = (1.0 - keep) * 0.5 * (slip[1:] + slip[:-1])
    return recursion(keep, driving)[:, 0]


def steering(car: CarConstants, nodes: Nodes, speed: Array, across: Array) -> Array:
    """Return the angle of the front wheels into the curve [rad], shape (n,).

    Args:
        car: nominal values.
        nodes: measured signals.
        speed: of the car [m/s], shape (n,).
        across: lateral slips s_y of the tyres [-], shape (W, n).
    """
    path = car.wheelbase * np.abs(nodes.yaw_rate) / speed
    return np.asarray(path + across[car.front_wheel] - across[car.rear_wheel])


def _steered(car: CarConstants, nodes: Nodes, speed: Array, across: Array) -> Array:
    """Speed of the front wheels along their planes over that of the car, less 1, shape (n,).

    Their axle moves ahead of the rear one by the path's curvature, and they roll under their slip angle to it.
    """
    heading = car.wheelbase * np.abs(nodes.yaw_rate) / speed - across[car.rear_wheel]
    return np.asarray(0.5 * (heading**2 - across[car.front_wheel] ** 2))


def brake_gains(car: CarConstants, nodes: Nodes, unknowns: Array) -> Array:
    """Return the gains of the brakes over their nominal ones at the nodes, shape (W, n)."""
    p = unknowns
    cold = np.exp(np.where(car.front > 0.0, p[Unknown.LOG_GAIN_FRONT], p[Unknown.LOG_GAIN_REAR]))
    return np.asarray(cold * _left_by_fading(nodes, p))


def gains_by_fading(nodes: Nodes, unknowns: Array) -> Array:
    """Return d ln of the gains / d FADING at the nodes, shape (W, n)."""
    return np.asarray(-nodes.work / FADING_WORK / _left_by_fading(nodes, unknowns))


def _left_by_fading(nodes: Nodes, unknowns: Array) -> Array:
    return np.maximum(1.0 - unknowns[Unknown.FADING] * nodes.work / FADING_WORK, _LEAST_GAIN)


def recursion(keep: Array, driving: Array) -> Array:
    """Solve y_k = keep_{k-1} y_{k-1} + driving_k for all columns of `driving`, shape (n, m)."""
    n = driving.shape[0]
    band = np.ones((2, n), order="F")
    band[1, : n - 1] = -keep
    solution, _ = dtbtrs(band, driving, uplo="L", diag="U")
    return np.asarray(solution)


def _at_rest(force: Array) -> PitchState:
    first = float(force[:_FIRST].mean())
    return PitchState((first, first), (first, first), (first, first))


def carried_over(nodes: Nodes, moved: Motion, carried: Carried, number: int) -> Carried:
    """Return what the oldest `number` >= 2 nodes leave to the next."""
    last, before = number - 1, number - 2
    state = PitchState(
        (float(moved.force[last]), float(moved.force[before])),
        (float(moved.pitch.pitch[last]), float(moved.pitch.pitch[before])),
        (float(moved.pitch.load[last]), float(moved.pitch.load[before])),
    )
    turned = carried.pitched + float(moved.pitch.pitch[:number] @ nodes.interval[:number])
    return Carried(moved.relaxed[:, number].copy(), state, turned)
