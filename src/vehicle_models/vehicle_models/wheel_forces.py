"""Loads and longitudinal forces of the wheels of a car on a straight road.

Quasi-static transfer by the acceleration a, with h the height of the centre of gravity, L the wheelbase, f the share of
the weight on the front axle at rest:

    F_front = m g f - m a h / L,    F_rear = m g (1 - f) + m a h / L

The springs pass the load q moved to the front axle on only as the body pitches, a damped oscillation of natural
frequency w and damping ratio z:

    q_ddot = w^2 (q_ss - q) - 2 z w q_dot,    q_ss = -m a h / L,    Fz = Fz_rest +- q / (wheels of the axle)

A lag of first order has the delay of this but not its rate, and the rate is what (8.3) needs: through the build-up of a
stop it errs by half the rate, and after it by the sign. With the acceleration linear in between, the step from one
sample to the next is exact.

At prescribed speed and acceleration the forces follow from drag and rolling resistance, Fx positive forward as in
section 8.4:

    sum Fx = m a + (1/2) rho c_w A v^2,    a free wheel has Fx = -c_r Fz;

the engine drives the driven wheels with equal torques, the brakes share by their gains.
"""

from dataclasses import dataclass
from math import cos, exp, pi, sin, sqrt
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vehicle_models.constants import AIR_DENSITY, GRAVITY
from vehicle_models.nanoseconds import NANOSECOND
from vehicle_models.vehicle import Vehicle, four_wheels

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


LEAST_SHARE: Final = 0.1
"""Smallest load over that at rest: a wheel that lifts is not described, and a division by its load stays finite."""


class PitchMode:
    """The oscillation q_ddot = w^2 (q_ss - q) - 2 z w q_dot, step by step, exact for a linear q_ss."""

    def __init__(self, frequency: float, damping: float) -> None:
        """Choose natural frequency [Hz] and damping ratio, below 1."""
        self._frequency, self._damping = 2.0 * pi * frequency, damping
        self.settle(0.0)

    def settle(self, settled: float) -> None:
        """Take q_ss for one that has lasted."""
        self._settled = self.moved = settled
        self.rate = 0.0
        """dq/dt, in units of q per second."""

    def step(self, dt: float, settled: float) -> None:
        """Advance by dt [s] to q_ss = `settled`."""
        w, z = self._frequency, self._damping
        slope = (settled - self._settled) / dt
        # Behind a ramp of q_ss the mode moves steadily, 2 z / w late; what differs from that is a free oscillation.
        behind = 2.0 * z / w * slope
        away, rate = self.moved - (self._settled - behind), self.rate - slope
        damped = w * sqrt(1.0 - z * z)
        decay, c, s = exp(-z * w * dt), cos(damped * dt), sin(damped * dt) / damped
        self.moved = settled - behind + decay * ((c + z * w * s) * away + s * rate)
        self.rate = slope + decay * ((c - z * w * s) * rate - w * w * s * away)
        self._settled = settled


class WheelLoad:
    """Load of one wheel, sample by sample."""

    def __init__(self, vehicle: Vehicle, wheel: str) -> None:
        """Start at rest.

        Args:
            vehicle: its mass, load share, height of the centre of gravity, wheelbase and pitch are used.
            wheel: name of the wheel.

        Raises:
            KeyError: there is no wheel of this name.
        """
        self.at_rest = vehicle.corner(wheel).vertical_load
        """Load without acceleration [N]."""
        share = vehicle.transfer_shares[vehicle.wheel_names.index(wheel)]
        self.transfer = -share * vehicle.mass
        """Steady change of load over acceleration, forward positive [kg]; 0 where there is one axle only."""
        self._mode = PitchMode(vehicle.pitch_frequency, vehicle.pitch_damping)
        self.reset()

    def reset(self) -> None:
        """Forget the past: the next acceleration is taken to have lasted."""
        self._stamp: int | None = None
        self._mode.settle(0.0)

    @property
    def rate(self) -> float:
        """dFz/dt [N/s], forgetting LEAST_SHARE."""
        return self._mode.rate

    @property
    def load(self) -> float:
        """Fz [N], at least LEAST_SHARE of that at rest."""
        return max(self.at_rest + self._mode.moved, LEAST_SHARE * self.at_rest)

    def update(self, stamp: int, acceleration: float) -> None:
        """Take the acceleration of the car at a stamp.

        Args:
            stamp: [ns], later than the last.
            acceleration: [m/s^2], forward positive, finite.
        """
        settled = self.transfer * acceleration
        if self._stamp is None:
            self._mode.settle(settled)
        else:
            self._mode.step((stamp - self._stamp) * NANOSECOND, settled)
        self._stamp = stamp


@dataclass(frozen=True)
class WheelForces:
    """Forces of one wheel of each axle [N], equal shapes; Fx forward positive, Fz on the tyre upwards."""

    fx_front: Array
    fx_rear: Array
    fz_front: Array
    fz_rear: Array


def wheel_forces(car: Vehicle, speed: ArrayLike, acceleration: ArrayLike) -> WheelForces:
    """Forces of one front and one rear wheel; speed [m/s] and acceleration [m/s^2], forward positive, broadcast.

    Raises:
        ValueError: the car does not have four wheels, or has to be driven and no wheel is.
    """
    v, a = np.broadcast_arrays(np.asarray(speed, dtype=np.float64), np.asarray(acceleration, dtype=np.float64))
    front, rear = axle_loads(a, car.mass, car.front_load_share, car.height_ratio, GRAVITY)
    wanted = car.mass * a + drag(car, v) + car.rolling_resistance * (front + rear)
    drive, brake = np.maximum(wanted, 0.0), np.minimum(wanted, 0.0)
    wheels = four_wheels(car)
    radius = np.array([wheel.radius for wheel in wheels])
    force_per_torque = radius[0] / radius
    front_braking = _front_share(force_per_torque * [wheel.brake_gain for wheel in wheels])
    front_driving = 0.0
    if np.any(drive > 0.0):
        if not any(wheel.driven for wheel in wheels):
            raise ValueError(f"no wheel of '{car.name}' is driven ('driven'): it cannot hold its speed or accelerate")
        front_driving = _front_share(force_per_torque * [float(wheel.driven) for wheel in wheels])
    fx_front = brake * front_braking + drive * front_driving - car.rolling_resistance * front
    fx_rear = brake * (1.0 - front_braking) + drive * (1.0 - front_driving) - car.rolling_resistance * rear
    return WheelForces(0.5 * fx_front, 0.5 * fx_rear, 0.5 * front, 0.5 * rear)


def drag(car: Vehicle, speed: ArrayLike) -> Array:
    """Drag of the air [N] at `speed` [m/s], any shape."""
    return np.asarray(0.5 * AIR_DENSITY * car.drag_area * np.asarray(speed, dtype=np.float64) ** 2)


def coasting_acceleration(car: Vehicle, speed: ArrayLike) -> Array:
    """Acceleration [m/s^2] out of gear at `speed` [m/s], any shape."""
    return np.asarray(-drag(car, speed) / car.mass - car.rolling_resistance * GRAVITY)


def _front_share(of_wheels: Array) -> float:
    return float(of_wheels[:2].sum() / of_wheels.sum())
