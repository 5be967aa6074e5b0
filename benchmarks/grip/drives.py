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
_STEERING = 0.3
"""Time constant of the steering [s]."""
_YAW_INERTIA = 0.85, 1.1
"""Moment of inertia about the vertical axis over m l_f l_r: from and to."""
_LOAD_EXPONENT = 0.9
"""Power of the load by which the wheels of an axle share its lateral force."""


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
    yaw_rate: Array
    """Reading of the gyroscope [rad/s], (N,)."""
    pressure: Array
    """[Pa], (N, 4)."""
    used: Array
    """Truth of car, front, rear and the wheels: force over load, (N, 7)."""
    mu_max: Array
    """Friction of the road: the largest of the tyres, (N,)."""
    bias: float
    """Of the accelerometer along the car [m/s^2]."""


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
    bias, inertia = float(rng.normal(0.0, 0.1)), float(rng.uniform(*_YAW_INERTIA))
    rows, roads = [], []
    around, curvature, turned = Surroundings(), 0.0, 0.0
    for step in range(round(seconds / STEP)):
        if step % measured.steps_per_sample == 0:
            m = measured.measure()
            lateral, yaw_rate = curvature * car.speed**2, curvature * car.speed
            turning, turned = (yaw_rate - turned) / (measured.steps_per_sample * STEP), yaw_rate
            bank = _BANK * 1.4 * GRAVITY * float(np.sin(distance / 90.0 + bank_phase))
            leftward = (1.0 + roll) * (lateral + bank) + bias + 0.05 * float(rng.normal())
            used = _used(parameters, car, lateral + bank, inertia * turning)
            gyroscope = yaw_rate + 0.01 * float(rng.normal())
            peak = max(grip * tyre.peak[1] for grip, tyre in zip(car.grip, car.tyres, strict=True))
            rows.append(
                [
                    m.time,
                    car.speed,
                    *m.wheel_speed,
                    m.acceleration,
                    leftward,
                    gyroscope,
                    *m.brake_pressure,
                    *used,
                    peak,
                    since,
                ]
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
        curvature += (gentle * around.curvature - curvature) * STEP / _STEERING
        measured.step(pressure, around.engine_torque, around.slope, curvature)
        distance += STEP * car.speed
        since += STEP * car.speed
    table = np.array(rows)
    return GripDrive(
        roads,
        table[:, 21],
        table[:, 0],
        table[:, 1],
        table[:, 2:6],
        table[:, 6],
        table[:, 7],
        table[:, 8],
        table[:, 9:13],
        table[:, 13:20],
        table[:, 20],
        parameters.sensors.acceleration_bias,
    )


def _drawn(rng: np.random.Generator) -> str:
    shares = np.array(list(ROADS.values()))
    return str(rng.choice(list(ROADS), p=shares / shares.sum()))


def _on(parameters: CarParameters, road: str, family: str) -> CarParameters:
    tyre = tyre_of(road, family)
    return replace(parameters, tyres=(tyre, tyre, tyre, tyre))


def _used(parameters: CarParameters, car: Car, lateral: float, turning: float) -> list[float]:
    """Friction in use of the car, the front and the rear axle, and each wheel; `turning`: as if of m l_f l_r."""
    loads = np.maximum(np.array(car.vertical_load), 1.0)
    along = np.array(car.friction) * loads
    share = parameters.front_load_share
    ahead = parameters.wheelbase * turning
    across = np.zeros(4)
    for axle, of_axle in (
        (slice(0, 2), share * (lateral + (1.0 - share) * ahead)),
        (slice(2, 4), (1.0 - share) * (lateral - share * ahead)),
    ):
        carried = loads[axle] ** _LOAD_EXPONENT
        across[axle] = parameters.mass * of_axle * carried / carried.sum()
    parts = (slice(0, 4), slice(0, 2), slice(2, 4), *(slice(k, k + 1) for k in range(4)))
    return [hypot(float(along[part].sum()), float(across[part].sum())) / float(loads[part].sum()) for part in parts]
