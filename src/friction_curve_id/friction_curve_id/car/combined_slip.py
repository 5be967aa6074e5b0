"""Slips of the tyres along and across: the force of a tyre points along its slip sigma = hypot(s_x, s_y).

    F_x = Fz mu(sigma) s_x / sigma,    k sum over the axle of Fz mu(sigma) s_y / sigma = F_y + F_x steering

Both wheels of an axle share one s_y, solved from its lateral force F_y by Newton's method; k is the friction across
over that along. Close to the lateral limit a force determines no slip: there s_y has a large deviation.
"""

from dataclasses import dataclass
from math import exp
from typing import Final

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.car.car_constants import CarConstants
from friction_curve_id.car.car_model import SPEED_UNKNOWNS, Motion, brake_gains, steering
from friction_curve_id.car.curve_family import CurveValues, Family, curve_values
from friction_curve_id.car.node_signals import Nodes, turning_beside_brakes
from friction_curve_id.car.pitch import PITCH_UNKNOWNS
from friction_curve_id.car.unknowns import OF_CURVE, SHARED, Unknown
from vehicle_models.constants import GRAVITY
from vehicle_models.lateral_forces import ACROSS, FORCE_STDDEV

Array = NDArray[np.float64]

_STRAIGHT: Final = 0.15
"""Share of its friction that the car uses across below which that along is less by a percent."""
_NEWTON_STEPS: Final = 6
_CLOSE: Final = 2e-3
"""Change of s_y over lambda_max in the last Newton step."""
_LEAST_SLOPE: Final = 0.15
"""Least slope of the lateral force over its secant: what is flatter determines no slip."""
_LASTING: Final = 0.05
"""Time for which the error of a lateral force lasts [s]: by the motion of the body and of the loads."""
_BIAS: Final = 0.1
"""Deviation of a lateral acceleration by the road's crossfall and the roll of the body [m/s^2]."""
_MOST_UNKNOWN: Final = 0.05
"""Relative deviation of a force along by s_y up to which it shows the friction of the road."""
_WIDEST: Final = 2.0
"""Largest s_y over lambda_max."""


@dataclass(frozen=True)
class TyreSlips:
    """Slips of the tyres at n nodes, and the curve there; shapes (W, n)."""

    size: Array
    """sigma [-], with the sign of s_x."""
    curve: CurveValues
    """At sigma / lambda_max."""
    along: Array | float
    """s_x over sigma [-]; 1 on a straight road."""
    across: Array | None
    """s_y [-], >= 0; None: the car goes straight."""
    force: Array | float
    """Lateral force of the axle over k [N]."""
    force_by_offset: Array | float
    """Its derivative by LATERAL_OFFSET [kg]."""
    force_by_share: Array | float
    """Its derivative by FRONT_LOAD_SHARE [N]."""
    across_stddev: Array | float
    """[-]"""
    by_force: Array | float
    """d s_y / d (lateral force of the axle over k) [1/N]."""
    pulled: Array | float
    """d F_x / d s_y over Fz, which is d F_y / d s_x over Fz and k, too [-]."""
    slope_along: Array
    """d F_x / d s_x over Fz at constant s_y [-]."""


def tyre_slips(
    car: CarConstants,
    nodes: Nodes,
    moved: Motion,
    torque: Array,
    family: Family,
    unknowns: Array,
    begin: Array | None,
) -> TyreSlips:
    """Return the slips of the tyres.

    Args:
        car: nominal values.
        nodes: measured signals.
        moved: their motion.
        torque: T at nominal gain [N m], shape (W, n).
        family: formula of the curve.
        unknowns: shape (SHARED + W,).
        begin: s_y to begin with [-], shape (W, n); None: zero.
    """
    p = unknowns
    log_peak = float(p[Unknown.LOG_LAMBDA_MAX])
    peak, mu_max = exp(log_peak), exp(float(p[Unknown.LOG_MU_MAX]))
    shape = (float(p[Unknown.SHAPE_1]), float(p[Unknown.SHAPE_2]))
    s_x = moved.relaxed
    if not turns(car, nodes, mu_max):
        curve = curve_values(family, log_peak, shape, s_x / peak)
        return TyreSlips(s_x, curve, 1.0, None, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, mu_max / peak * curve.slope)
    ratio = exp(float(p[Unknown.LOG_MASS]) - float(p[Unknown.LOG_ACROSS]))
    share = (car.share_fixed + car.share_sign * p[Unknown.FRONT_LOAD_SHARE]) / car.share
    spinning = car.inertia * exp(float(p[Unknown.LOG_INERTIA])) * nodes.wheel_acceleration
    brakes = (brake_gains(car, nodes, p) * torque + p[Unknown.ENGINE_DRAG] * car.driven + spinning) / car.radius
    moment = car.axles.lever @ brakes * exp(-float(p[Unknown.LOG_MASS])) / car.axles.inertia
    force = car.axles.at(nodes.leftward - p[Unknown.LATERAL_OFFSET], turning_beside_brakes(nodes, moment), 0.0)
    of_car = ratio * share * np.abs(force)
    # The brakes of steered wheels push the car out of the curve.
    steered = exp(-float(p[Unknown.LOG_ACROSS])) * car.front * (brakes + brakes[car.partner])
    by_offset = -2.0 * car.share * car.mass * ratio * share * np.sign(force)
    # Errors that last are no noise of each node: so many of them in a row count as one.
    lasting = np.sqrt(1.0 + 2.0 * _LASTING / nodes.interval)
    s_y = np.zeros_like(s_x) if begin is None else begin
    partner = car.partner
    for step in range(_NEWTON_STEPS):
        sigma = np.maximum(np.hypot(s_x, s_y), 1e-3 * peak)
        curve = curve_values(family, log_peak, shape, sigma / peak)
        level, rise = mu_max * curve.value, mu_max / peak * curve.slope
        along, sideways = s_x / sigma, s_y / sigma
        secant = level / sigma
        slope = moved.load * (rise * sideways**2 + secant * along**2)
        slope += slope[partner]
        stiffness = moved.load * secant
        stiffness += stiffness[partner]
        asked = of_car + steered * steering(car, nodes, moved.speed, s_y)
        by_force = 1.0 / np.maximum(slope - steered, _LEAST_SLOPE * stiffness)
        wanted = np.clip(s_y + (asked - stiffness * s_y) * by_force, 0.0, _WIDEST * peak)
        moves = float(np.abs(wanted - s_y).max())
        if moves < _CLOSE * peak or step + 1 == _NEWTON_STEPS:
            break
        s_y = wanted
    return TyreSlips(
        np.copysign(sigma, s_x),
        curve,
        along,
        s_y,
        asked,
        by_offset,
        of_car * car.share_sign / (share * car.share),
        np.hypot(FORCE_STDDEV * asked * lasting, _BIAS * by_offset) * by_force,
        by_force,
        along * sideways * (rise - secant),
        rise * along**2 + secant * sideways**2,
    )


def turns(car: CarConstants, nodes: Nodes, mu_max: float) -> bool:
    """Whether the tyres use so much of their friction across that it matters along."""
    return bool(car.partner) and float(np.abs(nodes.rolled).max()) > _STRAIGHT * mu_max * GRAVITY


def share_across(curve: float, speed: float, car: CarConstants, mu_max: float) -> float:
    """Return the lateral acceleration in a curve over what the friction across allows [-].

    Args:
        curve: half the track over the radius of the path [-].
        speed: of the car [m/s].
        car: nominal values.
        mu_max: friction along.
    """
    return curve * speed**2 / car.half_track / (ACROSS * GRAVITY * mu_max)


def shows_friction(tyres: TyreSlips, mu_max: float) -> NDArray[np.bool_] | bool:
    """Return whether forces along the wheels are known well enough to tell one road from another, shape (W, n)."""
    if tyres.across is None:
        return True
    deviation = np.abs(tyres.pulled) * tyres.across_stddev
    return np.asarray(deviation < _MOST_UNKNOWN * mu_max * tyres.curve.value * np.abs(tyres.along))


def across_gradient(car: CarConstants, moved: Motion, tyres: TyreSlips, by_curve: Array) -> Array:
    """Return d s_y by the unknowns, which it follows at constant force, shape (W, n, SHARED + W).

    Args:
        car: nominal values.
        moved: motion at the nodes.
        tyres: their slips, with s_y.
        by_curve: d mu(sigma) by OF_CURVE, shape (W, n, 4).
    """
    assert tyres.across is not None
    sideways = tyres.across / np.abs(tyres.size)
    by_slip = moved.load * tyres.pulled
    own = np.zeros((*tyres.size.shape, SHARED + car.wheels))
    own[:, :, OF_CURVE] = (moved.load * sideways)[:, :, np.newaxis] * by_curve
    for row, unknown in enumerate(SPEED_UNKNOWNS):
        own[:, :, unknown] = by_slip * moved.relaxed_by_speed[row]
    own[:, :, Unknown.RELAXATION_LENGTH] = by_slip * moved.relaxed_by_length
    own[:, :, Unknown.CURVE] = by_slip * car.left * moved.relaxed_by_offset
    own[:, :, Unknown.CURVE_RATE] = by_slip * car.left * moved.relaxed_by_growth
    for wheel in range(car.wheels):
        own[wheel, :, SHARED + wheel] = by_slip[wheel] * moved.relaxed_by_offset
    per_load = sideways * by_curve[:, :, Unknown.LOG_MU_MAX]
    own[:, :, Unknown.LOG_HEIGHT_RATIO] = per_load * moved.load_by_height
    own[:, :, Unknown.FRONT_LOAD_SHARE] = per_load * moved.load_by_share
    own[:, :, Unknown.ACCELEROMETER_OFFSET] += per_load * moved.load_by_offset
    own[:, :, Unknown.ACCELEROMETER_SCALE] += per_load * moved.load_by_scale
    own[:, :, Unknown.FRONT_ROLL_SHARE] = per_load * moved.load_by_roll
    for row, unknown in enumerate(PITCH_UNKNOWNS):
        own[:, :, unknown] += per_load * moved.load_by_pitch[row]
    own += own[car.partner]
    own[:, :, Unknown.LOG_ACROSS] = tyres.force
    own[:, :, Unknown.FRONT_LOAD_SHARE] -= tyres.force_by_share
    own[:, :, Unknown.LATERAL_OFFSET] = -tyres.force_by_offset
    own *= np.asarray(-tyres.by_force)[:, :, np.newaxis]
    return own
