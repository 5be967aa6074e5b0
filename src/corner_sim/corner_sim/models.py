"""The vehicle models to choose from: the parameter `model`."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from corner_sim.two_axle import peak_torque
from corner_sim.two_axle_car import TwoAxleCar, WheelRoads
from corner_sim.vehicle_model import JoinedCorners, VehicleModel
from vehicle_models.vehicle import Vehicle, four_wheels

Array = NDArray[np.float64]

CAR = "car"
_TWO_AXLE = "two_axle"


def in_order(model: str, vehicle: Vehicle) -> Vehicle:
    """Return the vehicle with its wheels in the order of the model's arrays.

    Raises:
        ValueError: the vehicle does not have the wheels that the model needs.
    """
    if model not in (_TWO_AXLE, CAR):
        return vehicle
    try:
        return replace(vehicle, wheels=four_wheels(vehicle))
    except ValueError as error:
        raise ValueError(f"parameter 'model' = '{model}': {error}") from error


def build_model(model: str, vehicle: Vehicle, speed: float) -> VehicleModel:
    """Make the model of a vehicle `in_order`, rolling freely at `speed` [m/s]."""
    if model == _TWO_AXLE:
        return Car(vehicle, speed)
    return JoinedCorners([vehicle.corner(name) for name in vehicle.wheel_names], speed)


class Car:
    """One car on two axles, in neutral; its brake lines are the plant's."""

    def __init__(self, vehicle: Vehicle, speed: float) -> None:
        """Start free rolling at `speed` [m/s]."""
        self._vehicle = vehicle
        self._behind = np.array([0.0, 0.0, vehicle.wheelbase, vehicle.wheelbase])
        self._car = TwoAxleCar(vehicle, speed)
        self.radius: Array = np.array(self._car.radius)
        """Radii [m], shape (4,)."""
        self.inertia: Array = np.array(self._car.inertia)
        """Wheel inertias [kg m^2], shape (4,)."""

    @property
    def speed(self) -> float:
        """Speed of the car [m/s]."""
        return self._car.speed

    @property
    def distance(self) -> Array:
        """Distance of each wheel from where the front axle started [m], shape (4,)."""
        return self._car.distance - self._behind

    @property
    def wheel_speed(self) -> Array:
        """Wheel speeds [rad/s], shape (4,)."""
        return np.array(self._car.wheel_speed)

    @property
    def slip(self) -> Array:
        """Slips [-], shape (4,)."""
        return np.array(self._car.slip)

    def peak_torque(self, theta: Array) -> float:
        """Brake torque [N m] that holds the front left wheel at the peak while all wheels are at theirs."""
        return float(peak_torque(self._vehicle, theta)[0])

    def vertical_load(self, theta: Array) -> Array:
        """Loads [N], shape (4,), including the load transfer by the present acceleration."""
        return np.array(self._car.loads(self.acceleration(theta)))

    def acceleration(self, theta: Array) -> float:
        """Acceleration [m/s^2]."""
        return self._car.acceleration(self._friction(theta))

    def wheel_acceleration(self, theta: Array, brake_torque: Array) -> Array:
        """Wheel accelerations [rad/s^2], shape (4,)."""
        return np.array(self._car.wheel_acceleration(self._friction(theta), brake_torque.tolist()))

    def step(self, torque_begin: Array, torque_end: Array, theta: Array, dt: float) -> None:
        """Advance by dt [s]."""
        self._car.step(torque_begin.tolist(), torque_end.tolist(), theta, dt)

    def _friction(self, theta: Array) -> list[float]:
        return WheelRoads(theta).friction(self._car.slip)
