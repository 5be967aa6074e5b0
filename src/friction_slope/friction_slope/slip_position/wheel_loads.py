"""Vertical loads of the wheels by the accelerations of the car, with what is not known of their delay.

Dampers pass load to the other axle at once, springs as the body pitches; which share each has is not known. The load is
the mean of both, and their difference, times a share between -1/2 and 1/2, is left to the bank.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from friction_runtime.filters import first_order_gain
from vehicle_models.constants import GRAVITY
from vehicle_models.lateral_forces import ROLLED
from vehicle_models.vehicle import Vehicle
from vehicle_models.wheel_forces import PitchMode

Array = NDArray[np.float64]

PITCH_DAMPING: Final = 0.4
"""Damping ratio of the pitch of a body, tyres and seals included [-]."""
DAMPED: Final = 0.03
"""Time constant with which dampers and stiff bushings pass load on [s]."""
LEAST_SHARE: Final = 0.15
"""Least load of a wheel over that at rest [-]."""


class WheelLoads:
    """Loads of all wheels, sample by sample."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Begin at rest."""
        weight = vehicle.mass * GRAVITY
        self._at_rest = weight * np.array(vehicle.load_shares)
        self._along = -vehicle.mass * np.array(vehicle.transfer_shares)
        self._across = vehicle.mass * np.array(vehicle.roll_shares)
        self._pitch = PitchMode(vehicle.pitch_frequency, PITCH_DAMPING)
        self.reset()

    def reset(self) -> None:
        """Forget the past."""
        self._damped = self._rolled = 0.0
        self._pitch.settle(0.0)
        self._begun = False
        self.loads = self._at_rest.copy()
        """[N], shape (n,)."""
        self.delayed = np.zeros_like(self._at_rest)
        """Load by springs alone less that by dampers alone [N], shape (n,)."""

    def update(self, dt: float, forward: float, leftward: float) -> None:
        """Take accelerations of the car [m/s^2] after a time step [s]."""
        if not self._begun:
            self._begun, self._damped, self._rolled = True, forward, leftward
            self._pitch.settle(forward)
        self._damped += first_order_gain(dt, DAMPED) * (forward - self._damped)
        self._pitch.step(dt, forward)
        self._rolled += first_order_gain(dt, ROLLED) * (leftward - self._rolled)
        moved = 0.5 * (self._damped + self._pitch.moved) * self._along + self._rolled * self._across
        self.loads = np.maximum(self._at_rest + moved, LEAST_SHARE * self._at_rest)
        self.delayed = (self._pitch.moved - self._damped) * self._along
