"""The best that the brakes of a car with four wheels can do: each has its full rate until the tyre's slip reaches
lambda_max, and whatever holds that slip from there on.
"""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from corner_sim.car.car import Car
from corner_sim.car.tyre import TYRES
from corner_sim.car_model import CarModelParameters, SensorErrors, as_it_is
from corner_sim.models import CAR
from friction_evaluation.closed_loop.actuator_bound import ActuatorBound
from friction_evaluation.closed_loop.car_setup import MODELS, CarSetup
from friction_evaluation.closed_loop.law_stops import ROLLING
from friction_evaluation.closed_loop.panic_stop import END_SPEED
from friction_evaluation.protocol import DT, SPEED
from vehicle_models.sensor_noise import NO_NOISE
from vehicle_models.single_corner import GRAVITY
from vehicle_models.surfaces import surface
from vehicle_models.two_axle import TwoAxleCar

Array = NDArray[np.float64]

_STEP = 1e-3
"""[s]"""
_RATE = 100.0
"""[1/s] with which an error of the wheel speed vanishes once the slip is held."""
_SLOW = 1.0
"""[m/s] from here on the car brakes as before."""


class _Plant(Protocol):
    """A car of four wheels."""

    speed: float
    wheel_speed: Array
    tyre_slip: Array
    load: Array
    friction: Array
    distance: float

    def step(self, torque: Array) -> None:
        """Advance by _STEP."""


class _TwoAxle:
    def __init__(self, setup: CarSetup) -> None:
        self._theta = surface(setup.surface)
        self._car = TwoAxleCar(setup.vehicle, [SPEED])
        self._read()

    def _read(self) -> None:
        car = self._car
        self.speed, self.distance = float(car.speed[0]), float(car.distance[0])
        self.wheel_speed, self.tyre_slip = car.wheel_speed[0], car.slip[0]
        self.load = car.wheel_loads(self._theta[np.newaxis])[0]
        self.friction = car.friction(self._theta)[0]

    def step(self, torque: Array) -> None:
        self._car.step(torque, torque, self._theta[np.newaxis], _STEP)
        self._read()


class _Car:
    def __init__(self, setup: CarSetup) -> None:
        errors = SensorErrors(NO_NOISE, 0.0, 0.0, 0)
        tyre = TYRES["burckhardt"][setup.surface]
        self._car = Car(as_it_is(setup.vehicle, tyre, CarModelParameters(), errors), SPEED, 0)
        self._read()

    def _read(self) -> None:
        car = self._car
        self.speed, self.distance = car.speed, car.distance
        self.wheel_speed, self.tyre_slip = np.array(car.wheel_speed), np.array(car.tyre_slip)
        self.load, self.friction = np.array(car.vertical_load), np.array(car.friction)

    def step(self, torque: Array) -> None:
        self._car.step(torque.tolist())
        self._read()


def car_bound(setup: CarSetup) -> ActuatorBound:
    """Return the bound of a car on its road, which is even."""
    plant: _Plant = _Car(setup) if MODELS[setup.car] == CAR else _TwoAxle(setup)
    for _ in range(round(ROLLING * DT / _STEP)):
        plant.step(np.zeros(4))
    lambda_max, mu_max = setup.peak
    car, actuator = setup.vehicle, setup.trouble.actuator
    radius = np.array([wheel.radius for wheel in car.wheels])
    inertia = np.array([wheel.inertia for wheel in car.wheels])
    best = mu_max * car.mass * GRAVITY
    torque, held = np.zeros(4), np.zeros(4, dtype=bool)
    time, used, speed, start = 0.0, 0.0, plant.speed, plant.distance
    to_end = used_to_end = 0.0
    while speed > _SLOW:
        if speed > END_SPEED:
            to_end, used_to_end = time, used
        held |= plant.tyre_slip >= lambda_max
        force = plant.load * plant.friction
        wanted = (1.0 - lambda_max) * speed / radius
        spin = inertia * (1.0 - lambda_max) * force.sum() / car.mass / radius
        hold = radius * mu_max * plant.load + spin + inertia * _RATE * (plant.wheel_speed - wanted)
        rising = torque + actuator.apply_rate * _STEP * (time >= actuator.delay)
        torque = np.where(held, np.maximum(hold, 0.0), rising)
        plant.step(torque)
        time += _STEP
        used += _STEP * float(force.sum()) / best
        speed = plant.speed
    last = speed * car.mass / best
    return ActuatorBound(
        used_to_end / to_end, (used + last) / (time + last), plant.distance - start + 0.5 * speed * last
    )
