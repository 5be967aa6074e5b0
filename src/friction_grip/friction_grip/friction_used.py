"""Friction in use: force over load of the car, its axles and its wheels, by accelerometer, gyroscope and brakes.

An accelerometer feels the forces on the car over its mass, whatever slope and mass are. With drag of the air and
rolling resistance taken off they are those of the slip of the tyres, a along (braking positive) and a_y across:

    a = -(f + c A rho v^2 / (2 m) + f_r g),  mu_x = a / g,  mu_y = a_y / g,  mu_used = hypot(mu_x, mu_y)

Brakes, inertia of the wheels and the engine say which wheel gives which part of a; their sum is a:

    a_i = (T_i + J_i domega_i / dt + E_i) / (r_i m) +- what is not known of gains, mass, engine;  sum a_i = a +- bias

That is one Gaussian conditioned on its sum. Across, the axles share the force by yaw rate and geometry,

    a_y,front = a_y + l_f dpsi/dt,  a_y,rear = a_y - l_r dpsi/dt   (times their share of the load at rest),

and loads move by pitch and roll.
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
from vehicle_models.vehicle import FRONT, Vehicle, absolute_deviation, deviation_of, mass_deviation, relative_deviation
from vehicle_models.wheel_forces import LEAST_SHARE

Array = NDArray[np.float64]

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
"""Of a load: height and place of the centre of gravity, relative."""
_SIDES: Final = 0.1
"""Of a wheel's share of the lateral force of its axle, which loads divide about evenly, relative."""
_PADS: Final = 0.03
"""Of a brake against the other one of its axle, relative."""
_GUESSED: Final = 0.15
"""Of an axle's share where brakes or engine may act on both and nothing measures it."""
_ENGINE: Final = 5.0
"""Of what an engine gives [m/s^2]."""
_UNREAD: Final = 0.3
"""Of what brakes give that no pressure shows [m/s^2]."""
_LEAST: Final = 0.004
"""Of friction, whatever is known."""
_YAW_ACCELERATION, _YAW_INERTIA = 0.2, 0.1
"""Of the yaw acceleration where it is not measured [rad/s^2], and of the moment of inertia m l_f l_r, relative."""
_BRAKES: Final = 3.0
"""Deviations of a deceleration beyond which the throttle is closed."""


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
    wheels: tuple[Used, ...]
    """In the order of the vehicle; NaN for a wheel whose brake torque is not known."""


UNKNOWN: Final = Used(nan, nan, nan, nan)


class FrictionUsed:
    """Takes samples, answers every 0.05 s."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Choose a car."""
        wheels, mass = vehicle.wheels, vehicle.mass
        self._rolling = vehicle.rolling_resistance * GRAVITY
        self._drag = 0.5 * AIR_DENSITY * vehicle.drag_area / mass
        self._mass_stddev = mass_deviation(vehicle)
        self._drag_stddev = self._drag * hypot(0.15, self._mass_stddev)
        self._bias = hypot(deviation_of(vehicle.accelerometer.deviations, "bias", _BIAS), 0.5 * _BIAS)
        is_front = np.array([wheel.axle == FRONT for wheel in wheels])
        self._at_rest, self._pitched = np.array(vehicle.load_shares), np.array(vehicle.transfer_shares)
        self._rolled = np.array(vehicle.roll_shares)
        self._axles = np.array([is_front, ~is_front], dtype=np.float64)
        self._parts = np.vstack([np.ones(len(wheels)), self._axles, np.eye(len(wheels))])
        """Which wheels car, axles and wheels have, (3 + wheels, wheels)."""
        self._sides = np.array([0.0, 0.0, 0.0, *[_SIDES] * len(wheels)])
        self._loaded = np.array([0.0, *[_GEOMETRY] * (2 + len(wheels))])
        share = vehicle.front_load_share
        self._lever = vehicle.wheelbase * np.where(is_front, 1.0 - share, -share)
        """Of the wheels before the centre of gravity [m]."""
        self._per_torque = 1.0 / (mass * np.array(vehicle.radii))
        self._inertia = np.array([wheel.inertia for wheel in wheels]) * self._per_torque
        self._inertia_stddev = np.array([relative_deviation(wheel, "inertia") for wheel in wheels])
        gains = np.array([wheel.brake_gain for wheel in wheels]) * self._per_torque
        self._gain_stddev = np.array([relative_deviation(wheel, "brake_gain") for wheel in wheels])
        self._braked = gains / gains.sum()
        driven = np.array([float(wheel.driven) for wheel in wheels])
        self._driven = driven / driven.sum() if driven.any() else self._at_rest
        self._engine_split = _GUESSED * self._between_axles(self._driven)
        self._drag_torque = driven * vehicle.engine_drag_torque * self._per_torque
        self._drag_torque_stddev = driven * self._per_torque
        self._drag_torque_stddev *= absolute_deviation(vehicle.deviations, "engine_drag_torque")
        self._rows: deque[tuple[int, Array]] = deque()
        self._answered = 0
        """Number of the period that has been answered last: periods are those of the clock, not of the first sample."""

    def reset(self) -> None:
        """Forget all samples."""
        self._rows.clear()
        self._answered = 0

    def update(
        self,
        stamp: int,
        speed: float,
        forward: float,
        leftward: float,
        yaw_rate: float,
        torques: Sequence[float],
        wheel_speeds: Sequence[float],
    ) -> GripInUse | None:
        """Take a sample; return the friction in use when it is due.

        Args:
            stamp: [ns], later than the last.
            speed: of the car [m/s].
            forward: acceleration that the accelerometer feels along the car [m/s^2]; NaN: not measured.
            leftward: the same across [m/s^2]; NaN: not measured.
            yaw_rate: [rad/s]; NaN: not measured.
            torques: of the brakes, in the order of the wheels [N m]; NaN where not known.
            wheel_speeds: [rad/s]; NaN where not known.
        """
        row = np.array([speed, forward, leftward, yaw_rate, *torques, *wheel_speeds])
        self._rows.append((stamp, row))
        while stamp - self._rows[0][0] > _WINDOW * NANOSECONDS:
            self._rows.popleft()
        number = stamp // round(_PERIOD * NANOSECONDS)
        if number == self._answered or len(self._rows) < _SHORTEST:
            return None
        self._answered = number
        rows = np.array([each for _, each in self._rows])
        time = np.array([(each - stamp) / NANOSECONDS for each, _ in self._rows])
        time -= time.mean()
        rates = time @ rows / (time @ time)
        count = self._at_rest.size
        return self._of_window(rows.mean(axis=0)[: 4 + count], rates[3], rates[4 + count :])

    def _of_window(self, means: Array, yaw_acceleration: float, spins: Array) -> GripInUse:
        speed, forward, leftward = means[:3].tolist()
        drag = self._drag * speed * speed
        along, across = -(forward + drag + self._rolling), leftward / (1.0 + _ROLL[0])
        if not isfinite(along):
            return GripInUse(UNKNOWN, UNKNOWN, UNKNOWN, (UNKNOWN,) * self._at_rest.size)
        along_stddev = hypot(self._bias, hypot(_SCALE * along, self._drag_stddev * speed * speed))
        forces, covariance = self._forces(along, along_stddev, means[4:], spins)
        is_lateral = isfinite(across)
        lateral, lateral_stddev = (across, hypot(_BIAS, _ROLL[1] * across)) if is_lateral else (0.0, 0.0)
        turned, turned_stddev = yaw_acceleration, _YAW_INERTIA * yaw_acceleration
        if not is_lateral:
            turned = turned_stddev = 0.0
        elif not isfinite(turned):
            turned, turned_stddev = 0.0, _YAW_ACCELERATION
        moved = (self._pitched * -forward + self._rolled * lateral) / GRAVITY
        loads = np.maximum(self._at_rest + moved, LEAST_SHARE * self._at_rest)
        of_axle = (self._axles @ self._at_rest) / np.maximum(self._axles @ loads, LEAST_SHARE)
        per_lateral = loads * (of_axle @ self._axles)

        load = np.maximum(GRAVITY * (self._parts @ loads), 1e-9)
        x = self._parts @ forces / load
        y = self._parts @ (per_lateral * (lateral + self._lever * turned)) / load
        x_variance = np.einsum("pi,ij,pj->p", self._parts, covariance, self._parts) / load**2
        y_variance = (self._parts @ per_lateral * lateral_stddev / load) ** 2 + (self._sides * y) ** 2
        y_variance += (self._parts @ (per_lateral * self._lever) * turned_stddev / load) ** 2
        used = np.hypot(x, y)
        # of little force the deviation is that of the larger part
        little = np.maximum(x_variance, y_variance)
        variance = np.where(used > 0.0, (x**2 * x_variance + y**2 * y_variance) / np.maximum(used**2, 1e-12), little)
        stddev = np.sqrt(variance + (self._loaded * used) ** 2 + _LEAST**2)
        known = np.append(self._parts[:3].any(axis=1), np.isfinite(means[4:]))
        parts = [
            Used(float(x[k]), float(y[k]) if is_lateral else nan, float(used[k]), float(stddev[k]))
            if known[k]
            else UNKNOWN
            for k in range(known.size)
        ]
        return GripInUse(parts[0], parts[1], parts[2], tuple(parts[3:]))

    def _forces(self, along: float, along_stddev: float, torques: Array, spins: Array) -> tuple[Array, Array]:
        """Return the braking forces of the wheels over the mass [m/s^2], and their covariance.

        Args:
            along: all of them together, as the accelerometer feels it [m/s^2].
            along_stddev: its deviation [m/s^2].
            torques: of the brakes [N m]; NaN where not known.
            spins: rates of the wheel speeds [rad/s^2]; NaN where not known.
        """
        is_read = np.isfinite(torques)
        brakes = np.where(is_read, torques, 0.0) * self._per_torque
        inertial = np.where(np.isfinite(spins), spins, 0.0) * self._inertia
        expected = brakes + inertial
        modes = [self._mass_stddev * expected, *(self._axles * (self._gain_stddev * brakes))]
        if along > _BRAKES * along_stddev:
            expected = expected + self._drag_torque
            modes += [self._drag_torque_stddev, _UNREAD * self._braked]
            if not is_read.all():
                unread = np.where(is_read, 0.0, self._braked)
                modes += [along * unread / unread.sum(), _GUESSED * along * self._between_axles(unread)]
        else:
            modes += [_ENGINE * self._driven, along * self._engine_split]
        stacked = np.array(modes)
        covariance = stacked.T @ stacked
        covariance += np.diag((_PADS * brakes) ** 2 + (self._inertia_stddev * inertial) ** 2)
        with_sum = covariance.sum(axis=1)
        missed, variance = along - float(expected.sum()), float(with_sum.sum()) + along_stddev**2
        # where brakes and accelerometer contradict each other, what is stated of the brakes was too little
        wider = max(1.0, missed * missed / variance)
        gain = wider * with_sum / (wider * float(with_sum.sum()) + along_stddev**2)
        return expected + gain * missed, wider * (covariance - np.outer(gain, with_sum))

    def _between_axles(self, shares: Array) -> Array:
        """Return what moves from one axle to the other where forces are divided by some shares, sum 0.

        Nothing does where one axle has no share.
        """
        of_axles = self._axles @ shares
        if not np.all(of_axles > 0.0):
            return np.zeros_like(shares)
        return np.asarray(shares * (np.array([1.0, -1.0]) / of_axles @ self._axles))
