"""Forces under the wheels of a car on a straight road at prescribed speed: load transfer, drag, rolling resistance.

    sum Fx = m a + (1/2) rho c_w A v^2,    a free wheel has Fx = -c_r Fz,    Fz from load_transfer;

the engine drives the driven wheels with equal torques, the brakes share by their gains. Here Fx is positive forward, as
in section 8.4.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vehicle_models import load_transfer
from vehicle_models.constants import AIR_DENSITY, GRAVITY
from vehicle_models.two_axle import four_wheels
from vehicle_models.vehicle import Vehicle

Array = NDArray[np.float64]


@dataclass(frozen=True)
class WheelForces:
    """Forces of one wheel of each axle [N], equal shapes; Fx forward positive, Fz on the tyre upwards."""

    fx_front: Array
    fx_rear: Array
    fz_front: Array
    fz_rear: Array


def wheel_forces(car: Vehicle, speed: ArrayLike, acceleration: ArrayLike) -> WheelForces:
    """Forces of one front and one rear wheel; speed [m/s] and acceleration [m/s^2], forward positive, broadcast.

    Raises:
        ValueError: the car does not have four wheels, or has to be driven and no wheel is.
    """
    v, a = np.broadcast_arrays(np.asarray(speed, dtype=np.float64), np.asarray(acceleration, dtype=np.float64))
    front, rear = load_transfer.axle_loads(a, car.mass, car.front_load_share, car.height_ratio, GRAVITY)
    wanted = car.mass * a + drag(car, v) + car.rolling_resistance * (front + rear)
    drive, brake = np.maximum(wanted, 0.0), np.minimum(wanted, 0.0)
    wheels = four_wheels(car)
    radius = np.array([wheel.radius for wheel in wheels])
    force_per_torque = radius[0] / radius
    front_braking = _front_share(force_per_torque * [wheel.brake_gain for wheel in wheels])
    front_driving = 0.0
    if np.any(drive > 0.0):
        if not any(wheel.driven for wheel in wheels):
            raise ValueError(f"no wheel of '{car.name}' is driven ('driven'): it cannot hold its speed or accelerate")
        front_driving = _front_share(force_per_torque * [float(wheel.driven) for wheel in wheels])
    fx_front = brake * front_braking + drive * front_driving - car.rolling_resistance * front
    fx_rear = brake * (1.0 - front_braking) + drive * (1.0 - front_driving) - car.rolling_resistance * rear
    return WheelForces(0.5 * fx_front, 0.5 * fx_rear, 0.5 * front, 0.5 * rear)


def drag(car: Vehicle, speed: ArrayLike) -> Array:
    """Drag of the air [N] at `speed` [m/s], any shape."""
    return np.asarray(0.5 * AIR_DENSITY * car.drag_area * np.asarray(speed, dtype=np.float64) ** 2)


def coasting_acceleration(car: Vehicle, speed: ArrayLike) -> Array:
    """Acceleration [m/s^2] out of gear at `speed` [m/s], any shape."""
    return np.asarray(-drag(car, speed) / car.mass - car.rolling_resistance * GRAVITY)


def _front_share(of_wheels: Array) -> float:
    return float(of_wheels[:2].sum() / of_wheels.sum())
