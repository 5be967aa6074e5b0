"""Motion of the car across its direction, sample by sample: sideways speed and roll.

What the accelerometer along the car reads in a curve is v' - yaw' v_y. The sideways speed v_y is the integral of
a_y - yaw' v while the car brakes, and that of steady cornering before:

    v_y = b yaw' - v a_y / (C g),    b: from the centre of gravity to the rear axle, C: stiffness of rolling tyres
"""

from math import expm1
from typing import Final

from vehicle_models.constants import GRAVITY
from vehicle_models.lateral_forces import ROLLED, Sideslip
from vehicle_models.vehicle import Vehicle

_STIFFNESS: Final = 25.0
"""Lateral force over load and slip of a tyre far from its peak [-]: 15 to 40 on any road but cobblestone."""
_STEADY: Final = 0.3
"""Time in which a car that does not brake corners steadily [s]."""


class LateralMotion:
    """Follows the car."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Begin straight ahead."""
        self._behind = vehicle.wheelbase * vehicle.front_load_share
        self._sideslip = Sideslip()
        self.reset()

    def reset(self) -> None:
        """Forget the past."""
        self._begun = False
        self._rolling = 0.0
        self.turned = 0.0
        """Integral of a_y - yaw' v [m/s]."""
        self.rolled = 0.0
        """Lateral acceleration whose steady load transfer acts [m/s^2]."""
        self.begin_braking()

    def begin_braking(self) -> None:
        """Take the car for one that does not slide now."""
        self._sideslip.begin_braking()

    @property
    def slides(self) -> bool:
        """Whether the car slides sideways."""
        return self._sideslip.slides

    @property
    def sideways(self) -> float:
        """v_y, to the left [m/s]."""
        return self._rolling + self._sideslip.change

    def update(self, dt: float, speed: float, yaw_rate: float, leftward: float, braking: bool) -> None:
        """Take a sample.

        Args:
            dt: time since the last one [s].
            speed: of the car [m/s].
            yaw_rate: counter-clockwise [rad/s].
            leftward: acceleration [m/s^2].
            braking: whether the car brakes.
        """
        if not self._begun:
            self._begun, self.rolled = True, leftward
        self.rolled -= expm1(-dt / ROLLED) * (leftward - self.rolled)
        self.turned += dt * (leftward - speed * yaw_rate)
        if braking:
            self._sideslip.move(dt, speed, yaw_rate, leftward)
            return
        steady = self._behind * yaw_rate - speed * leftward / (_STIFFNESS * GRAVITY)
        self._rolling -= expm1(-dt / _STEADY) * (steady - self._rolling)
