"""Friction in use: force over load of the car and of its axles, by what the accelerometer feels.

An accelerometer feels the forces on the car over its mass, whatever slope and mass are. With the drag of the air taken
off they are those of the tyres:

    mu_x = -(f + c A rho v^2 / (2 m)) / g,  mu_y = a_y / g,  mu_used = hypot(mu_x, mu_y)

An axle carries its share of the load, with the transfer f h / (g l), its share s of the force along the car, and its
share of the lateral force by the load at rest. Where brake torques are known s is theirs; else it is that of the driven
axle, or of the brake gains of the file, and as uncertain as that.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot, isfinite, nan
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vehicle_models.constants import AIR_DENSITY, GRAVITY
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import Vehicle, deviation_of, mass_deviation

_WINDOW: Final = 0.2
"""Time over which forces are meant [s]: shorter ones are jolts of the body."""
_PERIOD: Final = 0.05
"""Time between two answers [s]."""
_SHORTEST: Final = 5
"""Samples without which a window says nothing."""

# What is not known, each as one standard deviation.
_BIAS: Final = 0.15
"""Of an accelerometer whose file states none, crossfall and pitch of the road's unevenness included [m/s^2]."""
_SCALE: Final = 0.017
"""Of its scale and of the pitch of the body, relative."""
_ROLL: Final = 0.05, 0.03
"""Lateral reading beyond the lateral acceleration, by the roll of the body: mean and deviation, relative."""
_GEOMETRY: Final = 0.03
"""Of an axle's load: height and place of the centre of gravity, relative."""
_SPLIT_BRAKED, _SPLIT_GUESSED = 0.06, 0.15
"""Of an axle's share of the force along the car, with brake torques and without."""
_SLIDES: Final = 0.3
"""The same per share of the brake torque that the tyres do not give: a wheel of one axle slides or is slowed down."""
_BRAKED_TORQUE: Final = 60.0
"""Torque of all brakes together above which they are applied [N m]."""
_DRAGGED: Final = 1.0
"""Deceleration up to which an engine, and not a brake, slows the car [m/s^2]."""


@dataclass(frozen=True)
class Used:
    """Friction in use."""

    mu_x: float
    """Along the car, braking positive."""
    mu_y: float
    """Across, leftward positive; NaN where there is no lateral reading."""
    mu_used: float
    """Of both; of what is known."""
    stddev: float


@dataclass(frozen=True)
class GripInUse:
    """Friction in use over the last 0.2 s."""

    vehicle: Used
    front: Used
    rear: Used


class FrictionUsed:
    """Takes samples, answers every 0.05 s."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Choose a car."""
        mass = vehicle.mass
        self._drag = 0.5 * AIR_DENSITY * vehicle.drag_area / mass
        self._drag_stddev = self._drag * hypot(0.15, mass_deviation(vehicle))
        self._mass = mass
        self._height = vehicle.centre_of_gravity_height / vehicle.wheelbase
        self._front = vehicle.front_load_share
        self._bias = hypot(deviation_of(vehicle.accelerometer.deviations, "bias", _BIAS), 0.5 * _BIAS)
        self._is_front = np.array([wheel.axle == "front" for wheel in vehicle.wheels])
        self._radii = np.array(vehicle.radii)
        gains = np.array([wheel.brake_gain / wheel.radius for wheel in vehicle.wheels])
        self._braked_share = float(gains[self._is_front].sum() / gains.sum())
        driven = np.array([wheel.driven for wheel in vehicle.wheels])
        self._driven_share = float(driven[self._is_front].sum() / driven.sum()) if driven.any() else nan
        self._rows: deque[tuple[int, NDArray[np.float64]]] = deque()
        self._answered = 0
        """Number of the period that has been answered last: periods are those of the clock, not of the first sample."""

    def reset(self) -> None:
        """Forget all samples."""
        self._rows.clear()
        self._answered = 0

    def update(
        self, stamp: int, speed: float, forward: float, leftward: float, torques: Sequence[float]
    ) -> GripInUse | None:
        """Take a sample; return the friction in use when it is due.

        Args:
            stamp: [ns], later than the last.
            speed: of the car [m/s].
            forward: acceleration that the accelerometer feels along the car [m/s^2].
            leftward: the same across [m/s^2]; NaN: not measured.
            torques: of the brakes, in the order of the wheels [N m]; NaN where not known.
        """
        brakes = np.asarray(torques) / self._radii
        row = np.array([speed, forward, leftward, brakes[self._is_front].sum(), brakes[~self._is_front].sum()])
        self._rows.append((stamp, row))
        while stamp - self._rows[0][0] > _WINDOW * NANOSECONDS:
            self._rows.popleft()
        number = stamp // round(_PERIOD * NANOSECONDS)
        if number == self._answered or len(self._rows) < _SHORTEST:
            return None
        self._answered = number
        return self._of_means(np.mean([each for _, each in self._rows], axis=0))

    def _of_means(self, means: NDArray[np.float64]) -> GripInUse:
        speed, forward, leftward, front_brakes, rear_brakes = (float(each) for each in means)
        drag = self._drag * speed * speed
        along, across = -(forward + drag), leftward / (1.0 + _ROLL[0])
        along_stddev = hypot(self._bias, hypot(_SCALE * along, self._drag_stddev * speed * speed))
        across_stddev = hypot(self._bias, _ROLL[1] * across) if isfinite(across) else 0.0
        share, split = self._split(along, front_brakes, rear_brakes)
        asked = front_brakes + rear_brakes
        if isfinite(asked) and asked > max(self._mass * along, 1.0):
            # brakes that ask for more than the tyres give slow the wheels down, at an axle that is not known
            split = hypot(split, _SLIDES * (1.0 - max(self._mass * along, 0.0) / asked))
        moved = -self._height * forward / GRAVITY
        loads = self._front + moved, 1.0 - self._front - moved
        known_across = across if isfinite(across) else 0.0

        def of_axle(share: float, at_rest: float, load: float) -> Used:
            load = max(load, 0.05)
            mu_x, mu_y = share * along / (GRAVITY * load), at_rest * known_across / (GRAVITY * load)
            used = hypot(mu_x, mu_y)
            force = _projected(mu_x, mu_y, share * along_stddev, at_rest * across_stddev) / (GRAVITY * load)
            of_split = split * abs(along) / (GRAVITY * load) * (abs(mu_x) / used if used else 0.0)
            stddev = hypot(hypot(force, of_split), _GEOMETRY * used)
            return Used(mu_x, mu_y if isfinite(across) else nan, used, hypot(stddev, 0.005))

        whole = hypot(along, known_across) / GRAVITY
        stddev = _projected(along, known_across, along_stddev, across_stddev) / GRAVITY
        vehicle = Used(along / GRAVITY, across / GRAVITY, whole, hypot(stddev, 0.003))
        rest = 1.0 - self._front
        return GripInUse(vehicle, of_axle(share, self._front, loads[0]), of_axle(1.0 - share, rest, loads[1]))

    def _split(self, along: float, front_brakes: float, rear_brakes: float) -> tuple[float, float]:
        """Return the front axle's share of the force along the car, and its deviation; braking is positive."""
        brakes = front_brakes + rear_brakes
        if isfinite(brakes) and brakes * float(self._radii[0]) > _BRAKED_TORQUE:
            return front_brakes / brakes, _SPLIT_BRAKED
        if along > _DRAGGED and not isfinite(brakes):
            return self._braked_share, _SPLIT_GUESSED
        if isfinite(self._driven_share):
            is_sure = self._driven_share in (0.0, 1.0)
            return self._driven_share, _SPLIT_BRAKED if is_sure and isfinite(brakes) else _SPLIT_GUESSED
        return self._front, _SPLIT_GUESSED


def _projected(x: float, y: float, x_stddev: float, y_stddev: float) -> float:
    """Return the deviation of hypot(x, y); of little force it is that of the larger part."""
    size = hypot(x, y)
    if not size:
        return max(x_stddev, y_stddev)
    return hypot(x / size * x_stddev, y / size * y_stddev)
