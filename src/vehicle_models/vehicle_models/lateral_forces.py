"""Lateral forces of the axles of a car from its motion, and the signs that it slides sideways.

The forces of the axles follow from lateral acceleration a_y, yaw acceleration and the yaw moment M of the brakes, with
f the share of the weight on the front axle, I the yaw inertia and l the wheelbase:

    F_front = m f a_y + (I yaw'' - M) / l,    F_rear = m (1 - f) a_y - (I yaw'' - M) / l
"""

from math import expm1, isfinite
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vehicle_models.vehicle import FRONT, Vehicle

Array = NDArray[np.float64]

ACROSS: Final = 0.92
"""Friction of a tyre across over that along [-]: 0.85 to 1."""
FORCE_STDDEV: Final = 0.06
"""Relative deviation of the lateral force of an axle over its friction [-]."""
ROLLED: Final = 0.1
"""Time constant of the load transfer to the side [s]."""
SMOOTHED: Final = 0.05
"""Time constant of lateral acceleration, yaw acceleration and moment, in step with each other [s]."""
GYRATION: Final = 0.95
"""Yaw inertia over that of masses at the axles [-]."""
SLIDING: Final = 0.08
"""Change of the sideslip angle since the begin of a braking beyond which the car slides [rad]: no steering moves it."""
ACROSS_STDDEV: Final = 0.2, 0.05
"""Error of a measured lateral acceleration, bias [m/s^2] and by the roll of the body [-], three deviations."""


class AxleForces:
    """Forces of the axles of a car with four wheels."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Take the car."""
        self.known = len(vehicle.wheels) == 4
        """Whether the car has two axles of two wheels."""
        places, others = [(wheel.axle, wheel.side) for wheel in vehicle.wheels], {"left": "right", "right": "left"}
        self.partner = [places.index((axle, others[side])) for axle, side in places] if self.known else []
        """Other wheel of the axle of each wheel, by index; empty where the car has not two axles of two wheels."""
        is_front = np.array([wheel.axle == FRONT for wheel in vehicle.wheels])
        sides = np.array([0.5 if wheel.side == "left" else -0.5 for wheel in vehicle.wheels])
        self.lever = sides * vehicle.track
        """Moment, counter-clockwise, of a force backwards at each wheel [m], (n,)."""
        share = vehicle.front_load_share
        self._mass = vehicle.mass * np.where(is_front, share, 1.0 - share)
        self._moment = np.where(is_front, 1.0, -1.0) / vehicle.wheelbase
        self.inertia = GYRATION * vehicle.mass * share * (1.0 - share) * vehicle.wheelbase**2
        """Of yaw [kg m^2]."""

    def at(self, leftward: Array | float, yaw_acceleration: Array | float, moment: Array | float) -> Array:
        """Return the lateral force of the axle of each wheel, to the left [N], (n,) and the shape of the arguments.

        Args:
            leftward: lateral acceleration [m/s^2].
            yaw_acceleration: counter-clockwise [rad/s^2].
            moment: yaw moment of the brakes, counter-clockwise [N m].
        """
        turning = self.inertia * np.asarray(yaw_acceleration) - np.asarray(moment)
        return np.asarray(np.multiply.outer(self._mass, leftward) + np.multiply.outer(self._moment, turning))


class Sideslip:
    """Change of the sideways speed of a car while it brakes."""

    def __init__(self) -> None:
        """Begin a braking."""
        self.begin_braking()

    def begin_braking(self) -> None:
        """Take the sideslip of now for that of a car that does not slide."""
        self.change = self._allowance = 0.0
        """Sideways speed since then, to the left [m/s]; what it may be by errors of its sensors."""
        self.slides = False
        """Whether the car slides sideways: then force and slip of a wheel are as far from any model as the car is."""

    def move(self, dt: float, speed: float, yaw_rate: float, leftward: float) -> None:
        """Take the motion of the car over a time step.

        Args:
            dt: [s].
            speed: [m/s].
            yaw_rate: [rad/s].
            leftward: acceleration [m/s^2].
        """
        self.change += dt * (leftward - speed * yaw_rate)
        bias, by_roll = ACROSS_STDDEV
        self._allowance += dt * (bias + by_roll * abs(leftward))
        self.slides = abs(self.change) > SLIDING * speed + self._allowance


class LateralForces:
    """Forces of the axles of a car sample by sample, all signals late by the same time."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Begin straight ahead."""
        self._axles = AxleForces(vehicle)
        self.known = self._axles.known
        self.reset()

    def reset(self) -> None:
        """Forget the past."""
        self._yaw_rate = self._acceleration = self._brakes = 0.0
        self._begun = False
        self._yaw_acceleration = 0.0

    def move(self, dt: float, yaw_rate: float, leftward: float, brake_forces: Array) -> None:
        """Take the motion of the car over a time step.

        Args:
            dt: [s].
            yaw_rate: [rad/s].
            leftward: acceleration [m/s^2].
            brake_forces: of the wheels [N], (n,).
        """
        if not self._begun:
            self._begun, self._yaw_rate, self._acceleration = True, yaw_rate, leftward
        gain = -expm1(-dt / SMOOTHED)
        change = gain * (yaw_rate - self._yaw_rate)
        self._yaw_rate += change
        self._yaw_acceleration = change / dt
        self._acceleration += gain * (leftward - self._acceleration)
        if isfinite(moment := float(self._axles.lever @ brake_forces)):
            self._brakes += gain * (moment - self._brakes)

    @property
    def forces(self) -> Array:
        """Lateral force of the axle of each wheel, to the left [N], (n,)."""
        return self._axles.at(self._acceleration, self._yaw_acceleration, self._brakes)
