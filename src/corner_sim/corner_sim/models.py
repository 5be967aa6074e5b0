"""The vehicle models to choose from: the parameter `model`."""

import numpy as np
from numpy.typing import NDArray

from corner_sim.parameters import SimParameters
from corner_sim.vehicle import JoinedCorners, Vehicle
from vehicle_models.single_corner import CornerParameters
from vehicle_models.two_axle import CarParameters, TwoAxleCar

Array = NDArray[np.float64]


def build_vehicle(p: SimParameters) -> Vehicle:
    """Make the vehicle in its first state.

    Raises:
        ValueError: the parameters make no vehicle.
    """
    if p.model == "two_axle":
        car = CarParameters(
            mass=4.0 * p.mass,
            radius=p.radius,
            inertia=p.inertia,
            wheelbase=p.wheelbase,
            height=p.height,
            front_share=p.front_share,
            drag_area=p.drag_area,
            rolling_resistance=p.rolling_resistance,
        )
        return Car(car, p.initial_speed)
    return JoinedCorners(len(p.wheels), CornerParameters(p.radius, p.inertia, p.mass), p.initial_speed)


class Car:
    """One car of vehicle_models.two_axle, in neutral; its brake lines are the plant's."""

    def __init__(self, parameters: CarParameters, speed: float) -> None:
        """Start free rolling at `speed` [m/s]."""
        self._parameters = parameters
        self._car = TwoAxleCar(parameters, [speed])

    @property
    def speed(self) -> float:
        """Speed of the car [m/s]."""
        return float(self._car.speed[0])

    @property
    def distance(self) -> Array:
        """Distance of each wheel from where the front axle started [m], shape (4,)."""
        behind = self._parameters.wheelbase
        return self._car.distance[0] - np.array([0.0, 0.0, behind, behind])

    @property
    def wheel_speed(self) -> Array:
        """Wheel speeds [rad/s], shape (4,)."""
        return self._car.wheel_speed[0]

    @property
    def slip(self) -> Array:
        """Slips [-], shape (4,)."""
        return self._car.slip[0]

    @property
    def radius(self) -> Array:
        """Radii [m], shape (4,)."""
        return np.full(4, self._parameters.radius)

    @property
    def inertia(self) -> Array:
        """Wheel inertias [kg m^2], shape (4,)."""
        return np.full(4, self._parameters.inertia)

    def peak_torque(self, theta: Array) -> float:
        """Brake torque [N m] that holds a front wheel at the peak while all wheels are there."""
        return float(self._parameters.peak_torque(theta)[0])

    def vertical_load(self, theta: Array) -> Array:
        """Loads [N], shape (4,), with what the present acceleration moves to the front."""
        return self._car.wheel_loads(theta[np.newaxis])[0]

    def acceleration(self, theta: Array) -> float:
        """Acceleration [m/s^2]."""
        return float(self._car.acceleration(theta[np.newaxis])[0])

    def wheel_acceleration(self, theta: Array, brake_torque: Array) -> Array:
        """Wheel accelerations [rad/s^2], shape (4,)."""
        return self._car.wheel_acceleration(theta[np.newaxis], brake_torque)[0]

    def step(self, torque_begin: Array, torque_end: Array, theta: Array, dt: float) -> None:
        """Advance by dt [s]."""
        self._car.step(torque_begin, torque_end, theta[np.newaxis], dt)
