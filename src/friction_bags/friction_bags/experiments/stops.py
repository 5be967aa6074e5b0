"""The driver's stops of section 8.2.3, in a car whose measured friction differs from the static curve (Figure 8.9)."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from corner_sim.driver import DriverProfile
from corner_sim.plant import SAMPLE_TIME, SAMPLE_TIME_NS, Plant, PlantSample, SlopeCrossings
from corner_sim.road import Road
from corner_sim.ros import messages
from corner_sim.sensors import CHAPTER_NOISE, Sensors
from corner_sim.sprung_car import SprungCar
from friction_runtime.processor import Output
from vehicle_models.brake_actuator import ActuatorParameters, Command
from vehicle_models.vehicle import Vehicle, four_wheels
from vehicle_models.vehicle_file import load_vehicle

VEHICLE = "chapter_car"
_PROPORTIONING = np.array([1.0, 1.0, 0.375, 0.375])
"""Line pressure of each wheel over the driver's: a proportioning valve reduces that of the rear axle."""
_SPEED = 25.0
_DURATION = 2.5
ACCELERATION_VARIANCE = 0.01
"""Noise of the accelerometer [m^2/s^4]."""


@dataclass(frozen=True)
class Stop:
    """A stop that the driver breaks off beyond the peak."""

    note: str
    """Description of the stop."""
    surface: str
    """Name of the road."""
    level: float
    """Brake torque of a front wheel in multiples of its quasi-static peak torque."""


def _stop(surface: str, level: float) -> Stop:
    note = "stop by the driver's brake as in 8.2.3, with load transfer, suspension and tyre relaxation"
    return Stop(f"{surface}: {note} (the overshoot of Figure 8.9); four wheels", surface, level)


STOPS = {"high_grip_stop": _stop("high_grip", 1.02), "low_grip_stop": _stop("off_road", 1.03)}


def car_of_the_stops() -> Vehicle:
    """Return the car, its wheels in the order of the arrays."""
    vehicle = load_vehicle(VEHICLE)
    return replace(vehicle, wheels=four_wheels(vehicle))


def drive(stop: Stop, vehicle: Vehicle) -> Iterator[tuple[PlantSample, float]]:
    """Yield the true samples of a stop, SAMPLE_TIME apart, and the pressure [Pa] that the driver demands at each.

    Args:
        stop: the stop.
        vehicle: the car, its wheels in the order of two_axle.four_wheels.
    """
    car = SprungCar(vehicle, _SPEED)
    road = Road((stop.surface,), (0.0,))
    plant = Plant(car, road, ActuatorParameters(), vehicle)
    pressure = stop.level * car.peak_torque(road.theta(0.0)) / vehicle.wheels[0].brake_gain
    driver = DriverProfile(pressure, start=0.5, rise=0.4, hold=0.35, release=0.1)
    for index in range(round(_DURATION / SAMPLE_TIME) + 1):
        demand = driver.demand(index * SAMPLE_TIME)
        sample = plant.sample()
        yield replace(sample, friction=car.friction(sample.theta)), demand
        plant.advance(demand * _PROPORTIONING, Command.NONE)


def simulate(stop: Stop, start_stamp: int, seed: int = 0) -> Iterator[Output]:
    """Yield absolute topics and messages of a stop; the first sample is at `start_stamp` [ns]."""
    vehicle = car_of_the_stops()
    sensors = Sensors(CHAPTER_NOISE, ACCELERATION_VARIANCE, 0.0, vehicle, seed)
    crossings = SlopeCrossings(len(vehicle.wheels))
    for sample, demand in drive(stop, vehicle):
        stamp = start_stamp + sample.index * SAMPLE_TIME_NS
        crossings.update(sample, stamp)
        measured = sensors.measure(sample)
        outputs = messages.truth(stamp, vehicle.wheel_names, sample, crossings)
        outputs.append(("brake_demand", messages.brake_demand(stamp, demand)))
        outputs += messages.sensors(stamp, vehicle, measured, CHAPTER_NOISE, ACCELERATION_VARIANCE)
        yield from ((f"/{topic}", message) for topic, message in outputs)
