"""Forces under the wheels of a car on a straight road at prescribed speed: load transfer, drag, rolling resistance.

    sum Fx = m a + (1/2) rho c_w A v^2,    a free wheel has Fx = -c_r Fz,    Fz from load_transfer;

the engine drives the rear axle, the brakes share by `front_braking`. Here Fx is positive forward, as in section 8.4.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vehicle_models import load_transfer
from vehicle_models.two_axle import CarParameters

Array = NDArray[np.float64]


@dataclass(frozen=True)
class WheelForces:
    """Forces of one wheel of each axle [N], equal shapes; Fx forward positive, Fz on the tyre upwards."""

    fx_front: Array
    fx_rear: Array
    fz_front: Array
    fz_rear: Array


def wheel_forces(car: CarParameters, speed: ArrayLike, acceleration: ArrayLike) -> WheelForces:
    """Forces of one front and one rear wheel; speed [m/s] and acceleration [m/s^2], forward positive, broadcast."""
    v, a = np.broadcast_arrays(np.asarray(speed, dtype=np.float64), np.asarray(acceleration, dtype=np.float64))
    front, rear = load_transfer.axle_loads(a, car.mass, car.front_share, car.height_ratio, car.gravity)
    wanted = car.mass * a + drag(car, v) + car.rolling_resistance * (front + rear)
    drive, brake = np.maximum(wanted, 0.0), np.minimum(wanted, 0.0)
    fx_front = brake * car.front_braking - car.rolling_resistance * front
    fx_rear = brake * (1.0 - car.front_braking) + drive - car.rolling_resistance * rear
    return WheelForces(0.5 * fx_front, 0.5 * fx_rear, 0.5 * front, 0.5 * rear)


def drag(car: CarParameters, speed: ArrayLike) -> Array:
    """Drag of the air [N] at `speed` [m/s], any shape."""
    return np.asarray(0.5 * car.air_density * car.drag_area * np.asarray(speed, dtype=np.float64) ** 2)


def coasting_acceleration(car: CarParameters, speed: ArrayLike) -> Array:
    """Acceleration [m/s^2] out of gear at `speed` [m/s], any shape."""
    return np.asarray(-drag(car, speed) / car.mass - car.rolling_resistance * car.gravity)
