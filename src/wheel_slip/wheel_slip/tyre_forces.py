"""Forces of the tyres over their loads, from brake torques where they are known and from the accelerometer where not.

A wheel that is braked by T and turns slower at omega' has the force (T + J omega') / r at the road. What the
accelerometer feels beside the drag and these is the engine's, on the driven wheels. Without torques the brakes are
taken to give all wheels the same force over load, and the engine only to drive. Both are computed, as torques that are
known may be wrong.
"""

from collections.abc import Sequence
from math import hypot, isfinite, nan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vehicle_models.constants import GRAVITY
from vehicle_models.vehicle import Vehicle
from vehicle_models.wheel_forces import LEAST_SHARE, drag
from wheel_slip.motion_noise import MotionNoise

Array = NDArray[np.float64]

TELLING = 0.5
"""Force over load times g [m/s^2] from which on a tyre's slip has the sign of its force."""
SLOWEST = 1.0
"""Speed [m/s] that divides in place of a slower one."""


TOLD, BLIND = range(2)
"""Rows of the forces: by the torques, where they are known; and without them."""


class Forces(NamedTuple):
    """Of all tyres, shapes (2, wheels), over their loads and times g [m/s^2]."""

    force: Array
    """Braking positive."""
    doubt: Array
    """Deviation of it."""
    fleeting: Array
    """What of that is another one in the next step: where torques tell the force of one wheel, all of it."""
    by_engine: Array
    """Change of it with the engine's force over the mass of the car [-]."""
    told: NDArray[np.bool_]
    """Whether the torques are known, shape (2, 1)."""
    felt: float
    """What an accelerometer would read by the torques [m/s^2]; NaN where none of them brakes."""
    pull: float
    """Braking of the car by all its tyres, by the reading of the accelerometer [m/s^2]."""
    braked: float
    """The same by the torques [m/s^2], NaN where they are unknown."""


class TyreForces:
    """Of one car."""

    def __init__(self, vehicle: Vehicle, noise: MotionNoise) -> None:
        """Take loads, inertias and driven wheels of a car; where none is driven there is no engine."""
        self._noise, self._vehicle, self._mass = noise, vehicle, vehicle.mass
        wheels = vehicle.wheels
        self._count = len(wheels)
        self._load = vehicle.mass * GRAVITY * np.array(vehicle.load_shares)
        self._transfer = vehicle.mass * np.array(vehicle.transfer_shares)
        self._inertia = np.array([wheel.inertia for wheel in wheels])
        self._radii = np.array(vehicle.radii)
        self._driven = np.array([wheel.driven for wheel in wheels], dtype=np.float64)

    def told_by(self, torques: Sequence[float]) -> bool:
        """Whether torques tell the forces: of all brakes, and known."""
        return len(torques) == self._count and all([isfinite(torque) for torque in torques])

    def of(
        self,
        reading: float,
        speed: float,
        rim_rates: Array,
        torques: Sequence[float] | None,
        unrest: Array,
        error: float,
        unread: bool,
        locked: NDArray[np.bool_],
    ) -> Forces:
        """Return the forces.

        Args:
            reading: of the accelerometer, forward positive [m/s^2].
            speed: of the car [m/s].
            rim_rates: r omega' of each wheel [m/s^2].
            torques: of the brakes [N m]; None unless `told_by` them.
            unrest: of each wheel, by how much it changes unlike the car [m/s^2], shape (2, wheels).
            error: of the engine's force over the mass that is known [m/s^2].
            unread: whether the wheels themselves tell the reading: by as much as they slip, it is not the car's.
            locked: which wheels stand.
        """
        p, sign = self._noise, 1.0 if speed >= 0.0 else -1.0
        load = np.maximum(self._load - self._transfer * (sign * reading), LEAST_SHARE * self._load)
        resistance = float(drag(self._vehicle, abs(speed))) / self._mass
        pull = -sign * reading - resistance
        felt = braked = nan
        force = np.full(self._count, max(pull, 0.0) ** 3 / (pull**2 + p.blind_force**2))
        off = p.blind_force + (p.unread * abs(pull) if unread else 0.0)
        rows: list[tuple[Array, float, float, float, float]] = [(force, min(pull, 0.0), 0.0, off, p.unequal)] * 2
        if torques is not None:
            at_rim = (np.array(torques) + self._inertia * rim_rates * sign / self._radii) / self._radii
            # The road holds a locked wheel, not its brake.
            at_rim = np.where(locked, np.minimum(at_rim, load / GRAVITY * max(pull, 0.0)), at_rim)
            force, braked = at_rim / load * GRAVITY, float(at_rim.sum()) / self._mass
            own = np.where(locked, np.abs(force), np.minimum(np.abs(force), unrest[TOLD]))
            off = hypot(p.brakes * braked, float(np.linalg.norm(own * load)) / GRAVITY / self._mass)
            if braked > TELLING:
                felt = -sign * (braked + resistance)
            rows[TOLD] = (force, pull - braked, off, p.force, 1.0)
        known = np.array([[torques is not None], [False]])
        by_brakes, engine, unsure, least, uneven = [
            np.array(each, dtype=np.float64).reshape(2, -1) for each in zip(*rows, strict=True)
        ]
        share = p.engine**2 / (p.engine**2 + unsure**2)
        driven = self._driven * (self._mass * GRAVITY / max(float(self._driven @ load), 1.0))
        by_engine = np.where(known | (engine < 0.0), share * driven, 0.0)
        force = by_brakes + by_engine * (engine + error)
        doubt = np.hypot(least + uneven * np.minimum(np.abs(force), unrest), np.sqrt(share) * unsure * driven)
        return Forces(force, doubt, np.where(known, doubt, p.acceleration), by_engine, known, felt, pull, braked)
