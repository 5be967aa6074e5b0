"""Rolling radii of the wheels under their loads: a tyre that carries more turns faster at the same speed.

A radial tyre rolls on its radius less a third of its deflection, which grows with its load:

    r = r_0 (1 - c d),    d = (Fz - Fz_0) / Fz_0

with c = `radius_loss`, 0.02 to 0.025 for passenger cars (on the measured Stanford P1 the radii of the two sides differ
by 2.3 % where the load of one has doubled). The load moves with the specific force of the car:

    Fz - Fz_0 = -+ m q h / L,    -+ m a_y h s / w

with q the specific force along the car as its pitch follows it (PitchMode), h the height of the centre of gravity, L
the wheelbase, w the track and s the axle's share of the roll moment.
"""

import numpy as np
from numpy.typing import NDArray

from vehicle_models.constants import GRAVITY
from vehicle_models.vehicle import Vehicle, absolute_deviation
from vehicle_models.wheel_forces import LEAST_SHARE, PitchMode

Array = NDArray[np.float64]

_LONGEST = 0.5
"""Longest time between two samples that the pitch follows [s]."""


class RollingRadius:
    """Of the wheels of one car."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Take loads, geometry and tyres of the car."""
        wheels, shares = vehicle.wheels, np.array(vehicle.load_shares)
        self._loss = np.array([wheel.radius_loss for wheel in wheels])
        self._stddev = np.array([absolute_deviation(wheel.deviations, "radius_loss") for wheel in wheels])
        self._forward = -np.array(vehicle.transfer_shares) / shares / GRAVITY
        self._leftward = np.array(vehicle.roll_shares) / shares / GRAVITY
        self._pitch = PitchMode(vehicle.pitch_frequency, vehicle.pitch_damping)

    def update(self, since: float, forward: float, leftward: float) -> tuple[Array, Array]:
        """Return radii over those at rest, and the standard deviations of that, shape (wheels,).

        Args:
            since: time since the last sample [s]; the force is taken to have lasted where it is longer than 0.5 s,
                infinite included, or not positive.
            forward: specific force along the car [m/s^2], as an accelerometer reads it; braking negative.
            leftward: the same across it, to the left [m/s^2].
        """
        if 0.0 < since <= _LONGEST:
            self._pitch.step(since, forward)
        else:
            self._pitch.settle(forward)
        most = 1.0 - LEAST_SHARE
        moved = np.clip(self._forward * self._pitch.moved + self._leftward * leftward, -most, most)
        return 1.0 - self._loss * moved, self._stddev * np.abs(moved)
