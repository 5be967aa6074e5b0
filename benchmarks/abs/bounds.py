"""Bounds of an emergency stop: full brake rate up to lambda_max, mu_max beyond it; and an ideal slip controller."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_supervisor.brake_model import BrakeModel
from abs_supervisor.measurements import Measurements
from abs_supervisor.road_curve import RoadCurve
from abs_supervisor.slip_control import SlipController
from benchmarks.abs.car import CarSetup, car_parameters
from benchmarks.abs.controllers import ROLLING
from benchmarks.abs.panic_stop import (
    END_SPEED,
    LOCK_ABOVE,
    Commands,
    Flags,
    LongestLock,
    PanicPlant,
    PanicStops,
    Perturbation,
    brake_to_rest,
)
from benchmarks.protocol import DT, SPEED, STEP
from corner_sim.car.car import Car
from corner_sim.car.tyres import TYRES
from vehicle_models import burckhardt
from vehicle_models.brake_actuator import Command


@dataclass(frozen=True)
class ActuatorBound:
    """Of one plant; no law is better but by luck."""

    utilisation: float
    """To END_SPEED [-]."""
    utilisation_to_rest: float
    """[-]"""
    distance: float
    """To standstill [m]."""
    longest_lock: float = 0.0
    """[s] where the road changes: what no release comes in time for."""


def actuator_bound(surface: str, perturbation: Perturbation) -> ActuatorBound:
    """Return the bound of a plant on a road of one surface; a load that varies does not count."""
    plant = PanicPlant(surface, perturbation.steady, np.zeros((1, 1)))
    corner = plant.corner
    lambda_max = float(burckhardt.peak(plant.theta)[0][0])
    increase = np.array([int(Command.INCREASE)])
    while corner.slip[0] < lambda_max and corner.speed[0] > END_SPEED:
        plant.advance(plant.demand, increase)
    best, time = float(plant.best_deceleration[0]), plant.since
    speed = float(corner.speed[0])
    to_end, to_rest = time + (speed - END_SPEED) / best, time + speed / best
    return ActuatorBound(
        (SPEED - END_SPEED) / (best * to_end),
        SPEED / (best * to_rest),
        float(corner.distance[0]) + speed**2 / (2.0 * best),
    )


Array = NDArray[np.float64]

_STEP = 1e-3
"""[s]"""
_RATE = 100.0
"""[1/s] with which an error of the wheel speed vanishes once the slip is held."""
_SLOW = 1.0
"""[m/s] from here on the car brakes as before."""


class _Car:
    """The car on its road, read as arrays of shape (4,)."""

    def __init__(self, setup: CarSetup) -> None:
        self._road, self._behind = setup.road, _behind(setup)
        self._tyres = [TYRES["burckhardt"][name] for name in self._road.names]
        self._told = setup.parameters.car
        self._car = Car(car_parameters(setup.vehicle, self._road.names[0]), SPEED, 0)
        self._read()

    def _read(self) -> None:
        car = self._car
        self.speed, self.distance = car.speed, car.distance
        car.tyres = [self._tyres[k] for k in self._road.index(car.distance - self._behind)]
        self.wheel_speed, self.slip, self.tyre_slip = map(np.array, (car.wheel_speed, car.slip, car.tyre_slip))
        self.load, self.friction = np.array(car.vertical_load), np.array(car.friction)
        self.lambda_max, self.mu_max = np.array([tyre.peak for tyre in car.tyres]).T

    def step(self, torque: Array) -> None:
        self._car.step(torque.tolist(), slope=self._told.hill_at(self._car.distance))
        self._read()


def _behind(setup: CarSetup) -> Array:
    wheelbase = setup.vehicle.wheelbase
    return np.array([0.0, 0.0, wheelbase, wheelbase])


def car_bound(setup: CarSetup) -> ActuatorBound:
    """Return the bound of a car on its road, whose surface is even.

    Where it changes to one with less grip the brake comes down with its full rate from there on, not before.
    """
    plant = _Car(setup)
    for _ in range(round(ROLLING * DT / _STEP)):
        plant.step(np.zeros(4))
    car, actuator = setup.vehicle, setup.perturbation.actuator
    radius = np.array([wheel.radius for wheel in car.wheels])
    inertia = np.array([wheel.inertia for wheel in car.wheels])
    rise, fall = actuator.apply_rate * _STEP, actuator.release_rate * _STEP
    torque, held, falls = np.zeros(4), np.zeros(4, dtype=bool), np.zeros(4, dtype=bool)
    mu_max = plant.mu_max
    lock = LongestLock(4, _STEP)
    time, used, speed, start = 0.0, 0.0, plant.speed, plant.distance
    to_end = used_to_end = best = 0.0
    while speed > _SLOW:
        if speed > END_SPEED:
            to_end, used_to_end = time, used
        held |= plant.tyre_slip >= plant.lambda_max
        force, best = plant.load * plant.friction, float(plant.load @ plant.mu_max)
        rolls = 1.0 - plant.lambda_max
        spin = inertia * rolls * force.sum() / car.mass / radius
        error = plant.wheel_speed - rolls * speed / radius
        hold = radius * plant.mu_max * plant.load + spin + inertia * _RATE * error
        wanted = np.where(held, np.maximum(hold, 0.0), torque + rise * (time >= actuator.delay))
        falls = (falls | (plant.mu_max < mu_max)) & (torque - fall > wanted)
        torque, mu_max = np.where(falls, torque - fall, wanted), plant.mu_max
        plant.step(torque)
        lock.update(plant.slip, np.full(4, plant.speed > LOCK_ABOVE))
        time += _STEP
        used += _STEP * float(force.sum()) / best
        speed = plant.speed
    last = speed * car.mass / best
    return ActuatorBound(
        used_to_end / to_end,
        (used + last) / (time + last),
        plant.distance - start + 0.5 * speed * last,
        float(lock.longest.max()),
    )


def ideal_controller(surface: str, perturbation: Perturbation) -> PanicStops:
    """Return the stop of the ideal controller, arrays of shape (1,); a load that varies does not count."""
    plant = PanicPlant(surface, perturbation.steady, np.zeros((1, 1)))
    corner = plant.corner
    actuator = perturbation.actuator
    model = BrakeModel(actuator)
    controller = SlipController(plant.parameters, actuator, model)
    thetas = plant.way.theta(np.array(plant.way.distances))
    values = np.column_stack((thetas, burckhardt.peak(thetas)[0])).tolist()
    curves = [RoadCurve(theta_1, theta_2, theta_3, peak) for theta_1, theta_2, theta_3, peak in values]

    def brake(running: Flags) -> Commands:
        stamp = round(plant.since * 1e9) + STEP
        curve = curves[int(plant.way.index(plant.braked_way)[0])]
        speed, slip, torque = float(corner.speed[0]), float(corner.slip[0]), float(plant.torque[0])
        demand = plant.demand * plant.gain
        # What is known leaves no torque unexplained.
        controller.forget_disturbance()
        model.update(stamp, torque, obeys=False)
        measured = Measurements(float(corner.wheel_speed[0]), torque, demand, slip=slip, car_speed=speed)
        controller.observe(stamp, measured, curve)
        given = controller.ask(slip, demand, curve, seen=True)
        model.order(stamp, given, demand)
        commands = np.array([int(given)])
        plant.advance(plant.demand, commands)
        return commands

    return brake_to_rest(plant, brake)
