"""Drives of `model: car` in ordinary traffic, as the doctor gets them."""

from dataclasses import dataclass, replace

import numpy as np

from corner_sim.car.car import STEP, Car
from corner_sim.car.car_parameters import CarParameters
from corner_sim.car.ordinary_driving import OrdinaryDriver
from corner_sim.car.random_car import random_car
from corner_sim.car.recording import Recording, Surroundings, record
from corner_sim.car.tyre import TYRES
from vehicle_doctor.drive import IMU, SPEED, WHEEL_STATES, Array, Drive, Recorded, pressure_topic
from vehicle_models.vehicle import Vehicle

_START = 15.0
_SPEED_NOISE = 0.03
"""Noise of the speed sensor [m/s]."""
_TURNING_NOISE = 0.01
"""Noise of the yaw rate [rad/s]."""
_ROADS = ("dry", "wet")
"""Roads on which ordinary driving brakes hard enough to tell gains."""


@dataclass(frozen=True)
class Driven:
    """A drive, and the truth."""

    drive: Drive
    truth: CarParameters
    flat: bool
    """Whether the road has no slope."""
    wheel_age: float
    """Mean age of the wheel speeds at their stamps [s]."""


def driven(vehicle: Vehicle, seed: int, seconds: float, fading: float = 0.0, hot: float = 4e5) -> Driven:
    """Drive a car whose values are spread as its vehicle file states.

    Args:
        vehicle: `compact_car`, around which random_car draws.
        seed: same seed, same car and drive. Odd ones have a flat road, and encoders with teeth.
        seconds: length.
        fading: share of the brake gain that is lost to heat.
        hot: work of a brake at which it is lost [J].
    """
    families = tuple(TYRES)
    family, road = families[seed // 2 % len(families)], _ROADS[seed // 4 % len(_ROADS)]
    flat, teeth = bool(seed % 2), 48 if seed // 2 % 2 else 0
    car = random_car(seed, road, family).parameters
    sensors = replace(car.sensors, encoder_teeth=teeth, acceleration_stddev=0.1)
    car = replace(car, slope=0.0, sensors=sensors, fading=fading, fading_energy=hot)
    driver = OrdinaryDriver(car, seed)
    every = round(1.0 / (STEP * sensors.sample_rate))
    turning: list[float] = []

    def around(time: float, body: Car) -> Surroundings:
        found = driver.surroundings(time, body)
        turning.append(found.curvature * body.speed)
        return replace(found, slope=0.0) if flat else found

    recording = record(car, driver, seed, speed=_START, duration=seconds, surroundings=around)
    yaw_rate = np.resize(turning[::every], recording.time.size)  # the last sample has no step behind it
    omega = np.maximum(recording.wheel_speed, 1.0)
    # an encoder's speed is the mean over its interval, which ends up to a tooth before the stamp
    age = 0.5 / sensors.sample_rate + float(np.mean(np.pi / teeth / omega)) if teeth else 0.0
    return Driven(as_drive(recording, yaw_rate, vehicle, seed), car, flat, age)


def as_drive(recording: Recording, yaw_rate: Array, vehicle: Vehicle, seed: int) -> Drive:
    """Return the topics of a recording, a speed sensor at 20 Hz among them.

    Args:
        recording: of N samples.
        yaw_rate: truth [rad/s], (N,).
        vehicle: the car as its file says.
        seed: of the noise that the recording lacks.
    """
    count = recording.time.size
    time = recording.time

    def topic(values: Array) -> Recorded:
        return Recorded(time, time, np.asarray(values, dtype=np.float64).reshape(count, -1))

    turning = yaw_rate + _TURNING_NOISE * np.random.default_rng([seed, 7]).normal(size=count)
    lateral = yaw_rate * recording.speed
    zero = 0.02 * np.random.default_rng([seed, 6]).normal(size=(count, 2))
    slow = slice(None, None, max(round(0.05 / (time[1] - time[0])), 1))
    noise = _SPEED_NOISE * np.random.default_rng([seed, 5]).normal(size=time[slow].size)
    measured = (recording.speed[slow] + noise)[:, None]
    topics = {
        WHEEL_STATES: topic(recording.wheel_speed),
        IMU: topic(np.column_stack([recording.acceleration, lateral + zero[:, 0], 9.81 + zero[:, 1], turning])),
        SPEED: Recorded(time[slow], time[slow], measured),
    }
    for i, name in enumerate(vehicle.wheel_names):
        topics[pressure_topic(name)] = topic(recording.brake_pressure[:, i])
    return Drive(vehicle, topics, ())
