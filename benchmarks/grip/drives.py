"""Drives of random cars on roads that change, with the friction that the tyres use and that the road has."""

from dataclasses import dataclass, replace
from math import hypot

import numpy as np
from numpy.typing import NDArray

from corner_sim.car.car import STEP, Car
from corner_sim.car.car_parameters import CarParameters
from corner_sim.car.driving import OrdinaryDriver, Surroundings
from corner_sim.car.measured_car import MeasuredCar
from corner_sim.car.random_car import random_car
from corner_sim.car.tyres import TYRES, Burckhardt, Tyre
from vehicle_models.constants import GRAVITY

Array = NDArray[np.float64]

ROADS = {"dry": 0.5, "wet": 0.25, "cobblestone": 0.05, "snow": 0.15, "ice": 0.05}
"""Shares of the roads."""
LENGTH = 300.0
"""Mean length of a stretch of one road [m]."""
_ICE = Burckhardt(0.05, 306.39, 0.001)
_START = 12.0
_ROLL = 0.0, 0.1
"""Lateral reading beyond the lateral acceleration by the roll of the body, relative: from and to."""
_BANK = 0.02
"""RMS of the crossfall [rad], as of roads."""


@dataclass(frozen=True)
class GripDrive:
    """Samples of the sensors, N of them, and the truth at each."""

    road: list[str]
    """Road under the car at each sample."""
    since: Array
    """Distance since the road began [m], (N,)."""
    time: Array
    speed: Array
    """Truth [m/s], (N,)."""
    wheel_speed: Array
    """[rad/s], (N, 4)."""
    forward: Array
    leftward: Array
    """Readings of the accelerometer [m/s^2], (N,)."""
    pressure: Array
    """[Pa], (N, 4)."""
    used: Array
    """Truth of car, front and rear: force over load, (N, 3)."""
    mu_max: Array
    """Friction of the road: the largest of the tyres, (N,)."""


def tyre_of(road: str, family: str) -> Tyre:
    """Return a tyre on a road; on ice all families are alike."""
    return _ICE if road == "ice" else TYRES[family][road]


def drive(seed: int, seconds: float, gentle: float = 1.0) -> GripDrive:
    """Drive a random car.

    Args:
        seed: same seed, same car, roads and drive.
        seconds: length.
        gentle: share of the driver's usual accelerations, in curves too.
    """
    rng = np.random.default_rng([seed, 11])
    family = tuple(TYRES)[seed % len(TYRES)]
    road = _drawn(rng)
    parameters = _on(random_car(seed, "dry", family).parameters, road, family)
    measured = MeasuredCar(parameters, _START, seed)
    car = measured.car
    driver, begun, number = OrdinaryDriver(parameters, seed), 0.0, 0
    end, distance, since = float(rng.exponential(LENGTH)), 0.0, 0.0
    roll, bank_phase = float(rng.uniform(*_ROLL)), float(rng.uniform(0.0, 6.0))
    bias = float(rng.normal(0.0, 0.1))
    rows, roads = [], []
    around = Surroundings()
    for step in range(round(seconds / STEP)):
        if step % measured.steps_per_sample == 0:
            m = measured.measure()
            lateral = around.curvature * car.speed**2
            bank = _BANK * 1.4 * GRAVITY * float(np.sin(distance / 90.0 + bank_phase))
            leftward = (1.0 + roll) * (lateral + bank) + bias + 0.05 * float(rng.normal())
            used = _used(parameters, car, lateral + bank)
            peak = max(grip * tyre.peak[1] for grip, tyre in zip(car.grip, car.tyres, strict=True))
            rows.append(
                [m.time, car.speed, *m.wheel_speed, m.acceleration, leftward, *m.brake_pressure, *used, peak, since]
            )
            roads.append(road)
        if distance >= end:
            road, end, since = _drawn(rng), distance + float(rng.exponential(LENGTH)), 0.0
            number += 1
            parameters = _on(parameters, road, family)
            car.tyres = list(parameters.tyres)
            driver, begun = OrdinaryDriver(parameters, seed + 1000 * number), measured.time
        around = driver.surroundings(measured.time - begun, car)
        pressure = [gentle * each for each in driver.pressure(measured.time - begun, STEP, car)]
        around = replace(around, curvature=gentle * around.curvature)
        measured.step(pressure, around.engine_torque, around.slope, around.curvature)
        distance += STEP * car.speed
        since += STEP * car.speed
    table = np.array(rows)
    return GripDrive(
        roads,
        table[:, 16],
        table[:, 0],
        table[:, 1],
        table[:, 2:6],
        table[:, 6],
        table[:, 7],
        table[:, 8:12],
        table[:, 12:15],
        table[:, 15],
    )


def _drawn(rng: np.random.Generator) -> str:
    shares = np.array(list(ROADS.values()))
    return str(rng.choice(list(ROADS), p=shares / shares.sum()))


def _on(parameters: CarParameters, road: str, family: str) -> CarParameters:
    tyre = tyre_of(road, family)
    return replace(parameters, tyres=(tyre, tyre, tyre, tyre))


def _used(parameters: CarParameters, car: Car, lateral: float) -> tuple[float, float, float]:
    """Friction in use of the car, the front and the rear axle."""
    loads = np.array(car.vertical_load)
    along = np.array(car.friction) * loads
    share = parameters.front_load_share
    across = parameters.mass * lateral * np.array([0.5 * share] * 2 + [0.5 * (1.0 - share)] * 2)
    parts = (slice(0, 4), slice(0, 2), slice(2, 4))
    whole, front, rear = (
        hypot(float(along[part].sum()), float(across[part].sum())) / max(float(loads[part].sum()), 1.0)
        for part in parts
    )
    return whole, front, rear
