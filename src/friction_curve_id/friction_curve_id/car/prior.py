"""Prior of the unknowns of a braking: the values of the vehicle file with their deviations.

What the file does not state has the deviations of STATED below; a deviation of zero means known exactly.
"""

from dataclasses import dataclass
from math import hypot, log, pi

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.car.curve_family import ShapePrior
from friction_curve_id.car.unknowns import SHARED, Unknown
from vehicle_models.constants import GRAVITY
from vehicle_models.lateral_forces import ACROSS
from vehicle_models.vehicle import (
    FRONT,
    STATED,
    Vehicle,
    absolute_deviation,
    deviation_of,
    mass_deviation,
    relative_deviation,
)

Array = NDArray[np.float64]

LOG_MU_MAX = (log(0.7), 0.8)
LOG_LAMBDA_MAX = (log(0.14), 0.7)
DAMPER_SHARE = (0.6, 0.35)
"""Of the dampers in the load transfer, mean and standard deviation [-]."""
_PITCH = {
    Unknown.LOG_PITCH_FREQUENCY: (log(2.0 * pi * 1.6), 0.18),
    Unknown.PITCH_DAMPING: (0.45, 0.12),
    Unknown.DAMPER_SHARE: DAMPER_SHARE,
}
"""Pitch of passenger cars; no keys of the vehicle file."""
_START_SPEED_STDDEV = 0.05
_CURVE_STDDEV = 0.006
"""Half the track over the radius of the curve: 125 m."""
_CURVE_RATE_STDDEV = 0.006
"""Of its growth [1/s]: a driver who begins to turn while he brakes."""
_YAW_RATE_STDDEV = 0.02
"""Of the bias of a measured yaw rate [rad/s]."""
_ACROSS_STDDEV = 0.06
"""Of ln of the friction of a tyre across over that along."""
_SIDEWAYS_STDDEV = 0.4
"""Of the sideways speed of a car that corners steadily [m/s]."""
_FADING_STDDEV = 0.08
_OTHER_WHEELS = 0.15
"""Relative deviation of the deceleration of the car from that of the wheels that are measured."""
SLIP_OFFSET_STDDEV = 5e-4
"""Of the slip of a rolling wheel, where its radius is not known exactly."""


@dataclass(frozen=True)
class Prior:
    """Normal prior of all unknowns, shape (SHARED + W,) each."""

    mean: Array
    stddev: Array
    """Zero where known exactly."""


def car_prior(
    vehicle: Vehicle,
    present: tuple[int, ...],
    shape: ShapePrior,
    slope_stddev: float,
    with_accelerometer: bool,
    lateral_at: float | None = None,
    sideways: float = 0.0,
) -> Prior:
    """Return the prior of a car.

    Args:
        vehicle: the car.
        present: the wheels that are measured, by index.
        shape: prior of the shape of the curve.
        slope_stddev: standard deviation of the slope of the road [-], >= 0.
        with_accelerometer: whether the speed comes from an accelerometer, or from the wheels at nominal values.
        lateral_at: speed at the begin [m/s], where yaw rate and lateral acceleration are measured, else None.
        sideways: speed to the left at the start of the window, about [m/s].
    """
    wheels, mounting = [vehicle.wheels[each] for each in present], vehicle.accelerometer
    mean, stddev = np.zeros(SHARED + len(wheels)), np.zeros(SHARED + len(wheels))

    def put(unknown: Unknown, value: float, deviation: float) -> None:
        mean[unknown], stddev[unknown] = value, deviation

    radius = max(relative_deviation(wheel, "radius") for wheel in wheels)
    gains = [
        max((relative_deviation(w, "brake_gain") for w in wheels if (w.axle == FRONT) is front), default=0.0)
        for front in (True, False)
    ]
    mass = mass_deviation(vehicle)
    put(Unknown.LOG_MU_MAX, *LOG_MU_MAX)
    put(Unknown.LOG_LAMBDA_MAX, *LOG_LAMBDA_MAX)
    put(Unknown.SHAPE_1, shape.mean[0], shape.stddev[0])
    put(Unknown.SHAPE_2, shape.mean[1], shape.stddev[1])
    # The lever arm of the tyre's force errs with the radius: force balance and wheel equation see it as gain.
    put(Unknown.LOG_GAIN_FRONT, 0.0, hypot(gains[0], radius) if gains[0] else 0.0)
    put(Unknown.LOG_GAIN_REAR, 0.0, hypot(gains[1], radius) if gains[1] else 0.0)
    put(Unknown.FADING, 0.0, _FADING_STDDEV if any(gains) else 0.0)
    put(Unknown.LOG_MASS, 0.0, mass)
    put(Unknown.LOG_INERTIA, 0.0, max(relative_deviation(wheel, "inertia") for wheel in wheels))
    put(
        Unknown.PRESSURE_DELAY,
        vehicle.brake_pressure_delay,
        absolute_deviation(vehicle.deviations, "brake_pressure_delay"),
    )
    relaxation = sum(wheel.relaxation_length for wheel in wheels) / len(wheels)
    put(
        Unknown.RELAXATION_LENGTH,
        relaxation,
        max(relative_deviation(wheel, "relaxation_length") for wheel in wheels) * relaxation,
    )
    put(Unknown.START_SPEED, 0.0, _START_SPEED_STDDEV)
    two_sides = len({wheel.side for wheel in wheels}) > 1
    if lateral_at is not None:
        bias = _YAW_RATE_STDDEV * 0.5 * vehicle.track / lateral_at
        put(Unknown.CURVE, 0.0, bias)
        put(Unknown.CURVE_RATE, 0.0, bias)
        put(Unknown.LOG_ACROSS, log(ACROSS), _ACROSS_STDDEV)
        roll = absolute_deviation(vehicle.deviations, "front_roll_share")
        put(Unknown.FRONT_ROLL_SHARE, vehicle.front_roll_share, roll)
        put(Unknown.SIDEWAYS, sideways, _SIDEWAYS_STDDEV)
        put(Unknown.LATERAL_OFFSET, 0.0, absolute_deviation(mounting.deviations, "bias"))
    elif two_sides:
        put(Unknown.CURVE, 0.0, _CURVE_STDDEV)
        put(Unknown.CURVE_RATE, 0.0, _CURVE_RATE_STDDEV)
    put(Unknown.SLOPE, 0.0, slope_stddev * GRAVITY)
    if with_accelerometer:
        put(Unknown.ACCELEROMETER_DELAY, mounting.delay, absolute_deviation(mounting.deviations, "delay"))
        put(Unknown.ACCELEROMETER_OFFSET, 0.0, absolute_deviation(mounting.deviations, "bias"))
        pitch = GRAVITY * absolute_deviation(mounting.deviations, "pitch_gain")
        put(Unknown.PITCH_READING, GRAVITY * mounting.pitch_gain, pitch)
        put(Unknown.ACCELEROMETER_SCALE, 0.0, hypot(absolute_deviation(mounting.deviations, "scale"), radius))
    else:
        others = _OTHER_WHEELS if len(wheels) < len(vehicle.wheels) else 0.0
        put(Unknown.ACCELEROMETER_SCALE, 0.0, hypot(hypot(*gains), mass, others))
        driven = sum(wheel.driven for wheel in wheels)
        drag = absolute_deviation(vehicle.deviations, "engine_drag_torque") * driven / (wheels[0].radius * vehicle.mass)
        put(Unknown.ACCELEROMETER_OFFSET, 0.0, drag)
    if any(wheel.driven for wheel in wheels):
        drag = absolute_deviation(vehicle.deviations, "engine_drag_torque")
        put(Unknown.ENGINE_DRAG, vehicle.engine_drag_torque, drag)
    for unknown, (value, deviation) in _PITCH.items():
        put(unknown, value, deviation if vehicle.centre_of_gravity_height > 0.0 else 0.0)
    height = vehicle.centre_of_gravity_height
    if height > 0.0:
        relative = STATED["centre_of_gravity_height"] * height
        put(
            Unknown.LOG_HEIGHT_RATIO,
            0.0,
            deviation_of(vehicle.deviations, "centre_of_gravity_height", relative) / height,
        )
    share_stddev = 0.0 if _one_axle(vehicle) else absolute_deviation(vehicle.deviations, "front_load_share")
    put(Unknown.FRONT_LOAD_SHARE, vehicle.front_load_share, share_stddev)
    stddev[SHARED:] = SLIP_OFFSET_STDDEV if radius > 0.0 else 0.0
    return Prior(mean, stddev)


def _one_axle(vehicle: Vehicle) -> bool:
    return all(wheel.axle == FRONT for wheel in vehicle.wheels)


def radius_deviation(vehicle: Vehicle) -> float:
    """Relative standard deviation of the radii, the largest of the wheels."""
    return max(relative_deviation(wheel, "radius") for wheel in vehicle.wheels)
