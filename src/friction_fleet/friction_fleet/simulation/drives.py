"""Drives of unknown cars through the town, as the messages of their sensors.

The driver does not know the road: he brakes as on a dry one, a tenth of the times as hard as he can, and an anti-lock
brake holds the wheels near the peak. Only what he asks of engine and steering is within the friction there is.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from math import cos, radians
from typing import Any

import numpy as np
from sensor_msgs.msg import FluidPressure, Imu, JointState, NavSatFix, NavSatStatus

from corner_sim.car.car import STEP, Car
from corner_sim.car.car_parameters import CarParameters
from corner_sim.car.cross_axes import CrossAxes
from corner_sim.car.driving import Cycling, OrdinaryDriver, SlipCycle, Surroundings
from corner_sim.car.measured_car import MeasuredCar
from corner_sim.car.random_car import RandomCar, random_car
from corner_sim.car.tyres import BRUSH_TYRES, TYRES, Scaled, Tyre
from friction_fleet.simulation.town import METRES_PER_DEGREE, START, Street, Town, along, place
from friction_runtime.messages import header_at
from vehicle_models.constants import GRAVITY
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import Vehicle

FAMILIES = {**TYRES, "brush": BRUSH_TYRES}
BETWEEN_TYRES = 0.08
"""Deviation of the friction of cars on one road, relative: of their tyres."""
HARD = 0.1
"""Share of the stops that are hard."""
_FULL = 2.5e7
"""Pressure of a driver who brakes as hard as he can [Pa]."""
_FIRST_SPEED, _LONGEST_WAY = 12.0, 33.0
"""Speed at the start, and a mean speed that no drive reaches [m/s]."""
_TRACTION, _CURVES = 0.5, 0.4
"""Shares of the friction that engine and curves may take."""
_FIX_PERIOD, _FIX_STDDEV = 1.0, 2.0
"""Of the satellite receiver [s], [m]."""


@dataclass(frozen=True)
class DriveJob:
    """A drive to make."""

    car: int
    number: int
    seed: int
    seconds: float

    @property
    def name(self) -> str:
        """Name of its bag."""
        return f"car{self.car:03d}_drive{self.number:03d}"


@dataclass(frozen=True)
class _Tyres:
    """Tyres of a car on every road."""

    family: str
    factor: float

    def on(self, surface: str, friction: float) -> Tyre:
        """Return the tyre of a road of some friction; on ice it has the shape of that on snow."""
        return _scaled(self.family, "snow" if surface == "ice" else surface, friction * self.factor)


@cache
def _scaled(family: str, surface: str, friction: float) -> Tyre:
    shape = FAMILIES[family][surface]
    return _Known(Scaled(shape, friction / shape.peak[1], 1.0), (shape.peak[0], friction))


@dataclass(frozen=True)
class _Known:
    """A tyre whose peak is looked for once."""

    tyre: Tyre
    peak: tuple[float, float]

    def friction(self, slip: float) -> tuple[float, float]:
        return self.tyre.friction(slip)


class _Driver:
    """Brakes, engine and steering of a driver who does not know the road."""

    def __init__(self, parameters: CarParameters, cycling: Cycling, rng: np.random.Generator, seed: int) -> None:
        self._p, self._rng = parameters, rng
        self._wishes = OrdinaryDriver(parameters, seed)
        self._anti_lock = SlipCycle(parameters, replace(cycling, start=0.0))
        self._braked = self._hard = False

    def act(self, time: float, car: Car, friction: float) -> tuple[list[float], Surroundings]:
        """Return pressures [Pa] and surroundings of a step, on a road with some friction."""
        wish = self._wishes.surroundings(time, car)
        pressure = self._wishes.pressure(time, STEP, car)[0]
        if pressure > 0.0 and not self._braked:
            self._hard = bool(self._rng.uniform() < HARD)
        self._braked = pressure > 0.0
        most = _FULL if self._braked and self._hard else pressure
        driven_load = 0.5 * self._p.mass * GRAVITY * (1.0 - self._p.front_load_share)
        torque = min(wish.engine_torque, _TRACTION * friction * driven_load * self._p.radius[2])
        sharpest = _CURVES * friction * GRAVITY / max(car.speed, 1.0) ** 2
        curvature = float(np.clip(wish.curvature, -sharpest, sharpest))
        return self._anti_lock.pressure(time, STEP, car, most), Surroundings(torque, 0.0, curvature)


def begin_of(job: DriveJob) -> float:
    """Return the hour of the day at which a drive begins, 0 to 23.9."""
    return float(np.random.default_rng([job.seed, 22, job.car, job.number]).uniform(0.0, 23.9))


def messages(job: DriveJob, vehicle: Vehicle) -> Iterator[tuple[str, Any]]:
    """Yield topics and messages of a drive, in the order of their stamps.

    Args:
        job: same job, same drive.
        vehicle: names of wheels and joints.
    """
    rng = np.random.default_rng([job.seed, 23, job.car, job.number])
    town, begun = Town(job.seed), begin_of(job)
    car, tyres = _car(job)
    way = town.route(rng, _LONGEST_WAY * job.seconds)
    surface, friction = _road(town, way, 0.0, begun)
    parameters = replace(car.parameters, tyres=(tyres.on(surface, friction),) * 4, slope=0.0)
    of_drive = int(rng.integers(1 << 31))
    measured = MeasuredCar(parameters, _FIRST_SPEED, of_drive)
    dry = replace(parameters, tyres=(tyres.on("dry", 1.0),) * 4)
    driver = _Driver(dry, car.cycling, rng, of_drive)
    roll, axes = float(rng.uniform(0.0, 0.1)), CrossAxes(rng)
    pressure, around, next_fix = [0.0] * 4, Surroundings(), 0.0
    for step in range(round(job.seconds / STEP)):
        now = measured.car
        if step % measured.steps_per_sample == 0:
            m = measured.measure()
            stamp = round((START + 3600.0 * begun + m.time) * 1000.0) * (NANOSECONDS // 1000)
            at = header_at(stamp, "base_link")
            for name, each in zip(vehicle.wheel_names, m.brake_pressure, strict=True):
                yield f"/{name}/brake_pressure", FluidPressure(header=at, fluid_pressure=each)
            imu = Imu(header=at)
            imu.linear_acceleration.x = m.acceleration
            leftward = (1.0 + roll) * around.curvature * now.speed**2
            turn = around.curvature * now.speed
            imu.linear_acceleration.y, imu.angular_velocity.z = axes.read(leftward, turn)
            yield "/imu/data", imu
            yield "/wheel_states", JointState(header=at, name=list(vehicle.joints), velocity=m.wheel_speed)
            if m.time >= next_fix:
                next_fix += _FIX_PERIOD
                yield "/gnss/fix", _fix(stamp, way, now.distance, rng)
            here = _road(town, way, now.distance, begun + m.time / 3600.0)
            if here != (surface, friction):
                surface, friction = here
                now.tyres = [tyres.on(surface, friction)] * 4
        pressure, around = driver.act(measured.time, now, tyres.factor * friction)
        measured.step(pressure, around.engine_torque, around.slope, around.curvature)


def _car(job: DriveJob) -> tuple[RandomCar, _Tyres]:
    rng = np.random.default_rng([job.seed, 24, job.car])
    family = list(FAMILIES)[job.car % len(FAMILIES)]
    tyres = _Tyres(family, float(np.exp(rng.normal(0.0, BETWEEN_TYRES))))
    return random_car(int(rng.integers(1 << 31)), "dry", "burckhardt"), tyres


def _road(town: Town, way: list[tuple[Street, bool]], distance: float, hour: float) -> tuple[str, float]:
    return town.road(*along(way, distance), hour)


def _fix(stamp: int, way: list[tuple[Street, bool]], distance: float, rng: np.random.Generator) -> NavSatFix:
    latitude, longitude = place(*along(way, distance))
    north, east = rng.normal(0.0, _FIX_STDDEV, 2).tolist()
    fix = NavSatFix(header=header_at(stamp, "gnss"))
    fix.status.status = NavSatStatus.STATUS_FIX
    fix.latitude = latitude + north / METRES_PER_DEGREE
    fix.longitude = longitude + east / (METRES_PER_DEGREE * cos(radians(latitude)))
    fix.position_covariance = [_FIX_STDDEV**2, 0.0, 0.0, 0.0, _FIX_STDDEV**2, 0.0, 0.0, 0.0, 100.0]
    fix.position_covariance_type = NavSatFix.COVARIANCE_TYPE_KNOWN
    return fix
