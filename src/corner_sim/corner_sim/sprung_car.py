"""A car on two axles whose tyres relax and whose load moves through springs.

Two things are added to the quasi-static car of two_axle, with the slip s that the contact has built up so far:

    L s_dot = v (lambda - s),    Fx_i = Fz_i mu(s_i)                                 (relaxation length L of a tyre)
    q_ddot = w^2 (q_ss - q) - 2 z w q_dot,    q_ss = m h |a| / wheelbase             (load q moved to the front axle)

The suspension lets the load of the front axle overshoot, so that Fx over the quasi-static load exceeds the static curve
before it settles (Figure 8.9). No rolling resistance and no grade; the car must not come to rest.
"""

import numpy as np
from numpy.typing import NDArray

from corner_sim.two_axle import peak_torque
from vehicle_models import burckhardt
from vehicle_models.constants import AIR_DENSITY, GRAVITY
from vehicle_models.vehicle import Vehicle, four_wheels

Array = NDArray[np.float64]

_SUBSTEPS = 25


class SprungCar:
    """The car; arrays have shape (4,) over the wheels, in the order of two_axle.four_wheels."""

    def __init__(self, vehicle: Vehicle, speed: float) -> None:
        """Start free rolling at `speed` [m/s].

        Raises:
            ValueError: the vehicle does not have four wheels.
        """
        wheels = four_wheels(vehicle)
        self._vehicle = vehicle
        self._radius = np.array([wheel.radius for wheel in wheels])
        self._inertia = np.array([wheel.inertia for wheel in wheels])
        self._relaxation_length = np.array([wheel.relaxation_length for wheel in wheels])
        self._state = np.concatenate([[speed], speed / self._radius, np.zeros(6)])
        self._distance = 0.0

    @property
    def speed(self) -> float:
        """Speed of the car [m/s]."""
        return float(self._state[0])

    @property
    def distance(self) -> Array:
        """Distance of each wheel from where the front axle started [m], shape (4,)."""
        return self._distance - np.array([0.0, 0.0, self._vehicle.wheelbase, self._vehicle.wheelbase])

    @property
    def wheel_speed(self) -> Array:
        """Wheel speeds [rad/s], shape (4,)."""
        return np.asarray(self._state[1:5])

    @property
    def slip(self) -> Array:
        """Slips lambda [-], shape (4,)."""
        return 1.0 - self._radius * self.wheel_speed / self.speed

    @property
    def radius(self) -> Array:
        """Radii [m], shape (4,)."""
        return self._radius

    @property
    def inertia(self) -> Array:
        """Wheel inertias [kg m^2], shape (4,)."""
        return self._inertia

    def peak_torque(self, theta: Array) -> float:
        """Quasi-static brake torque [N m] that holds a front wheel at the peak while all wheels are at theirs."""
        return float(peak_torque(self._vehicle, theta)[0])

    def friction(self, theta: Array) -> Array:
        """Friction coefficients Fx / Fz [-] of the relaxed tyres, shape (4,)."""
        return np.asarray(burckhardt.friction(theta, self._state[5:9]))

    def vertical_load(self, theta: Array) -> Array:
        """Loads [N], shape (4,)."""
        return self._loads(self._state)

    def acceleration(self, theta: Array) -> float:
        """Acceleration [m/s^2]."""
        return float(self._rate(self._state, theta, np.zeros(4))[0])

    def wheel_acceleration(self, theta: Array, brake_torque: Array) -> Array:
        """Wheel accelerations [rad/s^2], shape (4,)."""
        return np.asarray(self._rate(self._state, theta, brake_torque)[1:5])

    def step(self, torque_begin: Array, torque_end: Array, theta: Array, dt: float) -> None:
        """Advance by dt [s] with the midpoint rule; the wheels must not stand."""
        h = dt / _SUBSTEPS
        for k in range(_SUBSTEPS):
            torque = torque_begin + (torque_end - torque_begin) * (k + 0.5) / _SUBSTEPS
            middle = self._state + 0.5 * h * self._rate(self._state, theta, torque)
            self._distance += h * float(middle[0])
            self._state = self._state + h * self._rate(middle, theta, torque)
            self._state[1:5] = np.maximum(self._state[1:5], 0.0)

    def _loads(self, state: Array) -> Array:
        car = self._vehicle
        weight = car.mass * GRAVITY
        front, rear = weight * car.front_load_share + state[9], weight * (1.0 - car.front_load_share) - state[9]
        return 0.5 * np.array([front, front, rear, rear])

    def _rate(self, state: Array, theta: Array, torque: Array) -> Array:
        """Rates of speed, wheel speeds, built-up slips, moved load and its rate."""
        car = self._vehicle
        speed, wheel_speed, built_up = state[0], state[1:5], state[5:9]
        force = self._loads(state) * burckhardt.friction(theta, built_up)
        drag = 0.5 * AIR_DENSITY * car.drag_area * speed**2
        acceleration = -(np.sum(force) + drag) / car.mass
        slip = 1.0 - self._radius * wheel_speed / speed
        moved = -car.mass * acceleration * car.centre_of_gravity_height / car.wheelbase
        frequency = 2.0 * np.pi * car.pitch_frequency
        pitch = frequency**2 * (moved - state[9]) - 2.0 * car.pitch_damping * frequency * state[10]
        return np.concatenate(
            [
                [acceleration],
                (self._radius * force - torque) / self._inertia,
                speed / self._relaxation_length * (slip - built_up),
                [state[10], pitch],
            ]
        )
