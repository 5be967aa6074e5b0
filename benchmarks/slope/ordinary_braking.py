"""Ordinary braking of a car with load transfer: no wheel passes the peak, and none may be reported beyond it.

The plant is corner_sim's car on two axles, whose load follows the acceleration at once; the processors take the body to
pitch. Both a front and a rear wheel are judged.
"""

from collections.abc import Callable, Iterator

import numpy as np

from benchmarks.protocol import ACCELERATION_STDDEV
from benchmarks.rows import Row, at_most
from benchmarks.slope.detection import METHODS, Settings, detections
from corner_sim import messages
from corner_sim.driver import DriverProfile
from corner_sim.models import build_model, in_order
from corner_sim.plant import SAMPLE_TIME, SAMPLE_TIME_NS, Plant
from corner_sim.road import Road
from corner_sim.sensors import Sensors
from friction_runtime.processor import Output
from vehicle_models.brake_actuator import ActuatorParameters, Command
from vehicle_models.constants import GRAVITY
from vehicle_models.sensor_noise import CHAPTER_NOISE
from vehicle_models.vehicle_file import load_vehicle

ROAD = "dry"
DECELERATIONS = (0.1, 0.3, 0.5)
"""Deceleration that the driver wants, over g."""
RISES = (0.1, 0.5)
"""Times in which the pressure rises [s]."""
WHEELS = ("front_left", "rear_left")
_MODEL = "two_axle"
_CAR = in_order(_MODEL, load_vehicle("compact_car"))
_SPEED = 25.0
_DURATION = 2.5


def ordinary_braking(seeds: range, settings: Settings, done: Callable[[], None] = lambda: None) -> list[Row]:
    """One row for each method: all time that any braking was said to be beyond the peak.

    Args:
        seeds: of the sensor noise.
        settings: parameters of the processors.
        done: called after each braking.
    """
    beyond = dict.fromkeys(METHODS, 0.0)
    time = SAMPLE_TIME * np.arange(round(_DURATION / SAMPLE_TIME), dtype=np.float64)
    for seed in seeds:
        for deceleration in DECELERATIONS:
            for rise in RISES:
                samples = list(sensor_messages(deceleration, rise, seed))
                for wheel in WHEELS:
                    for method, found in detections(samples, time, settings, _CAR, wheel).items():
                        beyond[method] += 1e3 * SAMPLE_TIME * float((found.signs < 0).sum())
                done()
    quantity = "beyond the peak in ordinary braking [ms]"
    return [
        {"surface": ROAD, "method": method, "quantity": quantity, **at_most(beyond[method], 0.0)} for method in METHODS
    ]


def brakings_of_a_seed() -> int:
    """Return the number of brakings that `ordinary_braking` makes for each seed."""
    return len(DECELERATIONS) * len(RISES)


def sensor_messages(deceleration: float, rise: float, seed: int) -> Iterator[list[Output]]:
    """Yield the messages of each sample: 0.6 s of rolling, the rise, a hold, and a release within 0.2 s.

    Args:
        deceleration: wanted deceleration over g [-].
        rise: time in which the pressure rises [s].
        seed: of the sensor noise.
    """
    gains = sum(wheel.brake_gain / wheel.radius for wheel in _CAR.wheels)
    driver = DriverProfile(deceleration * GRAVITY * _CAR.mass / gains, start=0.6, rise=rise, hold=1.0, release=0.2)
    plant = Plant(build_model(_MODEL, _CAR, _SPEED), Road((ROAD,), (0.0,)), ActuatorParameters(), _CAR)
    variance = ACCELERATION_STDDEV**2
    sensors = Sensors(CHAPTER_NOISE, variance, 0.0, _CAR, seed)
    for index in range(round(_DURATION / SAMPLE_TIME)):
        measured = sensors.measure(plant.sample())
        yield messages.sensors((index + 1) * SAMPLE_TIME_NS, _CAR, measured, CHAPTER_NOISE, variance)
        plant.advance(driver.demand(index * SAMPLE_TIME), Command.NONE)
