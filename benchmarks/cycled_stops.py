"""ABS stops with cycled slip on roads straight and curved, split and changing, of cars known and random, as messages.

The plant is corner_sim.car.cornering_car with its own tyres and sensors. Truth: combined slip of the tyre, and the peak
of its road.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np

from benchmarks.stated_deviations import stating
from corner_sim.car.car import STEP
from corner_sim.car.car_parameters import PITCH_GAIN, CarParameters, SensorParameters
from corner_sim.car.cornering_car import CorneringCar
from corner_sim.car.cross_axes import CrossAxes
from corner_sim.car.driving import Cycling, PressureProfile, SlipCycle
from corner_sim.car.measured_car import MeasuredCar
from corner_sim.car.random_car import random_car
from corner_sim.car.recording import SPUN
from corner_sim.car.tyres import BRUSH_TYRES, TYRES, Scaled, Tyre
from corner_sim.ros import messages
from corner_sim.sensors import CHAPTER_NOISE, Measurement
from vehicle_models.constants import GRAVITY
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle

VEHICLE: Final = "compact_car"
FAMILIES: Mapping[str, Mapping[str, Tyre]] = {**TYRES, "brush": BRUSH_TYRES}
CYCLE: Final = Cycling(upper=1.4, lower=0.5)
"""Slip control that is better than most: barely beyond the peak, which is hardest to tell."""
SPEED: Final = 25.0
DURATION: Final = 2.3
"""Time of braking [s]."""
LEAST_SPEED: Final = 3.0
BEND: Final = 0.5
"""Time in which the curve begins [s]."""
CHANGED_AFTER: Final = 14.0
"""Way on the first road after the begin of braking [m]."""
LOAD_VARIATION: Final = 0.03
_ACCELERATION_VARIANCE: Final = 0.0025


@dataclass(frozen=True)
class Case:
    """A kind of stop."""

    name: str
    road: str
    family: str = "burckhardt"
    lateral: float = 0.0
    """Lateral acceleration of the curve at the start [g]."""
    right: str = ""
    """Road of the right wheels where it is another."""
    after: str = ""
    """Road after CHANGED_AFTER where it is another."""
    random: bool = False
    """A random car, of which the estimators know the nominal one; else one whose tyres alone are not known."""
    across: bool = True
    """Yaw rate and lateral acceleration are measured."""
    held: float = 0.0
    """Deceleration that the driver holds in place of slips that cycle [g]; 0: they cycle."""


class Instant(NamedTuple):
    """A sample."""

    stamp: int
    """[ns]"""
    messages: list[tuple[str, Any]]
    """Topics with their messages."""
    time: float
    """Since the start [s]."""
    slip: list[float]
    """True sizes of the combined slips of the tyres [-]."""
    lambda_max: list[float]
    mu_max: list[float]
    """True peaks of the tyres on their roads, that of the friction at the present load."""
    speed: float
    """Truth [m/s]."""


def well_known(vehicle: Vehicle) -> Vehicle:
    """Return a car whose brakes and wheels were measured: gains and inertias to 2 %, delay to 2 ms, drag to 5 N m."""
    of_car = {"brake_pressure_delay": 0.002, "engine_drag_torque": 5.0}
    return stating(vehicle, of_car, {"inertia": 0.02, "brake_gain": 0.02})


def make_car(case: Case, seed: int) -> tuple[CarParameters, Cycling]:
    """Return the car of a case, and how its slips are cycled."""
    if case.random:
        drawn = random_car(seed, case.road, case.family)
        return drawn.parameters, drawn.cycling
    rng = np.random.default_rng([seed, 5])
    roads = (case.road, case.right or case.road) * 2
    first, second, third, fourth = (differing(FAMILIES[case.family][road], rng) for road in roads)
    parameters = CarParameters(
        tyres=(first, second, third, fourth),
        load_variation=LOAD_VARIATION,
        relaxation_length=(0.3,) * 4,
        pitch_gain=PITCH_GAIN,
        damper_share=float(rng.uniform(0.0, 1.0)),
        sensors=SensorParameters(acceleration_bias=float(rng.normal(0.0, 0.05))),
    )
    return parameters, CYCLE


def differing(tyre: Tyre, rng: np.random.Generator) -> Tyre:
    """Return a tyre that differs from others of its kind by 3 % of mu_max and 5 % of lambda_max."""
    return Scaled(tyre, 1.0 + 0.03 * float(rng.normal()), 1.0 + 0.05 * float(rng.normal()))


def sensor_messages(
    measured: MeasuredCar, car: CorneringCar, vehicle: Vehicle, axes: CrossAxes
) -> tuple[int, list[tuple[str, Any]]]:
    """Return stamp [ns] and messages of a sample; the IMU has axes across the car, too."""
    reading = measured.measure()
    taken = Measurement(
        wheel_speed=np.array(reading.wheel_speed),
        brake_pressure=np.array(reading.brake_pressure),
        speed=np.nan,
        acceleration=reading.acceleration,
    )
    stamp = round((reading.time + 1.0) * NANOSECONDS)
    made = messages.sensors(stamp, vehicle, taken, CHAPTER_NOISE, _ACCELERATION_VARIANCE)
    imu = dict(made)["imu/data"]
    leftward = car.lateral_acceleration + 0.04 * car.roll.angle
    imu.linear_acceleration.y, imu.angular_velocity.z = axes.read(leftward, car.yaw_rate)
    imu.angular_velocity_covariance[0] = 0.0
    return stamp, [each for each in made if each[0] != "vehicle_velocity"]


def drive(case: Case, parameters: CarParameters, cycling: Cycling, seed: int) -> Iterator[Instant]:
    """Drive a case with a car until it stands, spins, or DURATION of braking is over."""
    vehicle = load_vehicle(VEHICLE)
    car = CorneringCar(parameters, SPEED, seed)
    measured = MeasuredCar(parameters, SPEED, seed, car)
    pedal: SlipCycle | PressureProfile = SlipCycle(parameters, cycling)
    if case.held:
        per_pressure = sum(g / r for g, r in zip(parameters.brake_gain, parameters.radius, strict=True))
        held = case.held * GRAVITY * parameters.mass / per_pressure
        pedal = PressureProfile((cycling.start, cycling.start + cycling.ramp), (0.0, held))
    axes = CrossAxes(np.random.default_rng([seed, 21]))
    after = FAMILIES[case.family][case.after] if case.after else None
    peak_after = after.peak if after is not None else (np.nan, np.nan)
    braked_at: float | None = None
    peaks = [tyre.peak for tyre in car.tyres]
    for step in range(round((cycling.start + DURATION) / STEP)):
        time = measured.time
        if step % measured.steps_per_sample == 0:
            stamp, made = sensor_messages(measured, car, vehicle, axes)
            if not case.across:
                imu = dict(made)["imu/data"]
                imu.linear_acceleration.y, imu.angular_velocity.z = 0.0, 0.0
                imu.angular_velocity_covariance[0] = -1.0
            lambda_max = [slip for slip, _ in peaks]
            mu_max = [grip * mu for grip, (_, mu) in zip(car.grip, peaks, strict=True)]
            slips = [abs(slip) for slip in car.tyre_slip]
            yield Instant(stamp, made, time, slips, lambda_max, mu_max, car.speed)
        if car.speed < LEAST_SPEED or abs(car.lateral_speed) > SPUN * car.speed:
            return
        if braked_at is None and time >= cycling.start:
            braked_at = car.distance
        if after is not None and braked_at is not None:
            for wheel, behind in enumerate((0.0, 0.0, parameters.wheelbase, parameters.wheelbase)):
                if car.distance - braked_at - behind > CHANGED_AFTER:
                    car.tyres[wheel], peaks[wheel] = after, peak_after
        curvature = case.lateral * GRAVITY * min(time / BEND, 1.0) / max(car.speed, 5.0) ** 2
        measured.step(pedal.pressure(time, STEP, car), 0.0, 0.0, curvature)
