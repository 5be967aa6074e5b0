"""Vertical load of the axles of a car in straight-line motion: quasi-static transfer by the acceleration.

With h the height of the centre of gravity, L the wheelbase, f the share of the weight on the front axle at rest:

    F_front = m g f - m a h / L,    F_rear = m g (1 - f) + m a h / L

The forces determine the acceleration, and the acceleration the loads; with the mean braking friction coefficients of
the axles mu_front, mu_rear and further resistance R the loop closes in one line:

    a (1 - (h/L)(mu_front - mu_rear)) = -g (f mu_front + (1 - f) mu_rear) - R/m
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def axle_loads(
    acceleration: ArrayLike, mass: float, front_share: float, height_ratio: float, gravity: float
) -> tuple[Array, Array]:
    """Return the loads (front, rear) [N] under `acceleration` [m/s^2], forward positive; shapes of the acceleration.

    Args:
        acceleration: any shape.
        mass: mass of the car [kg].
        front_share: f, 0 to 1.
        height_ratio: h / L.
        gravity: [m/s^2].
    """
    transfer = mass * height_ratio * np.asarray(acceleration, dtype=np.float64)
    weight = mass * gravity
    return np.asarray(weight * front_share - transfer), np.asarray(weight * (1.0 - front_share) + transfer)


def acceleration(
    front_friction: ArrayLike,
    rear_friction: ArrayLike,
    resistance: ArrayLike,
    front_share: float,
    height_ratio: float,
    gravity: float,
) -> Array:
    """Acceleration [m/s^2] of the car, consistent with the loads it causes.

    Args:
        front_friction: mean friction coefficient of the front wheels, positive in braking.
        rear_friction: the same of the rear wheels.
        resistance: deceleration by all else, R / m [m/s^2].
        front_share: f, 0 to 1.
        height_ratio: h / L.
        gravity: [m/s^2].
    """
    front, rear = np.asarray(front_friction, dtype=np.float64), np.asarray(rear_friction, dtype=np.float64)
    driving = gravity * (front_share * front + (1.0 - front_share) * rear) + np.asarray(resistance, dtype=np.float64)
    return np.asarray(-driving / (1.0 - height_ratio * (front - rear)))
