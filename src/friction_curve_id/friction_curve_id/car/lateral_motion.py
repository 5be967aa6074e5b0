"""Motion of the car across its direction, sample by sample: sideways speed, forces of the axles, roll.

What the accelerometer along the car reads in a curve is v' - yaw' v_y. The sideways speed v_y is the integral of
a_y - yaw' v while the car brakes, and goes to that of steady cornering before:

    v_y = b yaw' - v a_y / (C g),    b: from the centre of gravity to the rear axle, C: stiffness of rolling tyres
"""

from math import expm1
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vehicle_models.constants import GRAVITY
from vehicle_models.lateral_forces import LateralForces
from vehicle_models.vehicle import Vehicle

Array = NDArray[np.float64]

ROLLED: Final = 0.1
"""Time constant of the load transfer to the side [s]."""
_STIFFNESS: Final = 25.0
"""Lateral force over load and slip of a tyre far from its peak [-]: 15 to 40 on any road but cobblestone."""
_STEADY: Final = 0.3
"""Time in which a car that does not brake corners steadily [s]."""


class LateralMotion:
    """Follows the car."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Begin straight ahead."""
        self._axles = LateralForces(vehicle)
        self._mass, self._behind = vehicle.mass, vehicle.wheelbase * vehicle.front_load_share
        self.possible = self._axles.known
        """Whether the car has four wheels: for others it is not known how they share a lateral force."""
        self.reset()

    def reset(self) -> None:
        """Forget the past."""
        self._axles.reset()
        self.sideways = 0.0
        """v_y, to the left [m/s]."""
        self.rolled = 0.0
        """Lateral acceleration whose steady load transfer acts [m/s^2]."""
        self._begun = False

    def begin_braking(self) -> None:
        """Take the car for one that does not slide now."""
        self._axles.begin_braking()

    @property
    def slides(self) -> bool:
        """Whether the car slides sideways."""
        return self._axles.slides

    @property
    def across(self) -> Array:
        """Lateral force of the axle of each wheel over the mass of the car [m/s^2], shape (W,)."""
        return self._axles.forces / self._mass

    def update(
        self, dt: float, speed: float, yaw_rate: float, leftward: float, brake_forces: Array, braking: bool
    ) -> None:
        """Take a sample.

        Args:
            dt: time since the last one [s].
            speed: of the car [m/s].
            yaw_rate: counter-clockwise [rad/s].
            leftward: acceleration [m/s^2].
            brake_forces: of the wheels [N], shape (W,).
            braking: whether the car brakes.
        """
        steady = self._behind * yaw_rate - speed * leftward / (_STIFFNESS * GRAVITY)
        if not self._begun or dt <= 0.0:
            self._begun, self.sideways, self.rolled = True, steady, leftward
            return
        self._axles.move(dt, speed, yaw_rate, leftward, brake_forces)
        self.rolled -= expm1(-dt / ROLLED) * (leftward - self.rolled)
        if braking:
            self.sideways += dt * (leftward - speed * yaw_rate)
        else:
            self.sideways -= expm1(-dt / _STEADY) * (steady - self.sideways)
