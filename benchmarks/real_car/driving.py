"""Ordinary driving of random cars: no peak is passed; no valid peak and no lasting slope sign beyond it may come.

The IMUs differ from drive to drive: one measures the motion across, one states that it does not turn (REP 145), and one
leaves zeros in what it does not measure, as many drivers do.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from friction_msgs.msg import FrictionSlope
from sensor_msgs.msg import FluidPressure, Imu, JointState

from benchmarks.real_car.stops import ALARM, VEHICLE, Array, follow
from benchmarks.runner import Row, at_most, not_judged, run_lengths
from benchmarks.slope.detection import METHODS, shipped_settings
from corner_sim.car.cornering_car import CorneringCar
from corner_sim.car.cross_axes import CrossAxes
from corner_sim.car.driving import OrdinaryDriver
from corner_sim.car.random_car import random_car
from corner_sim.car.recording import Recording, record
from friction_runtime.lateral_inputs import MEASURED, LateralInput
from friction_runtime.messages import header_at
from friction_runtime.processor import Output
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle

DRIVE = 120.0
"""Length of a drive [s]; the hours are made of such drives, each of another car."""
_START = 15.0
"""Speed at the begin [m/s]."""
LASTING = 0.05
"""Time for which P(beyond the peak) > 0.9 is a lasting alarm [s]."""


class Across(Enum):
    """What an IMU has of the motion across the car."""

    MEASURED = 0
    NOT_MEASURED = 1
    ZEROS = 2
    """A lateral acceleration, and a yaw rate of zero that is not marked as missing."""


@dataclass(frozen=True)
class Drive:
    """A drive to make, with a random car."""

    seed: int
    road: str
    family: str
    across: Across = Across.MEASURED
    duration: float = DRIVE
    """[s]"""


@dataclass(frozen=True)
class DriveResult:
    """What was claimed in a drive, which never comes near the peak."""

    hours: float
    valid_peaks: int
    """Runs of messages with a valid lambda_max or mu_max, of all wheels."""
    lasting_alarms: int
    """Runs of P > 0.9 that last, of all wheels."""
    largest_slip: float
    """Largest slip of a tyre over its lambda_max, braking or driving."""


def record_drive(drive: Drive) -> Recording:
    """Drive; the estimator is not used."""
    # the drive has hills of its own: on snow no car with two driven wheels climbs more
    car = replace(random_car(drive.seed, drive.road, drive.family).parameters, slope=0.0)
    driver = OrdinaryDriver(car, drive.seed)
    moving = CorneringCar(car, _START, drive.seed)
    return record(
        car, driver, drive.seed, speed=_START, duration=drive.duration, surroundings=driver.surroundings, car=moving
    )


def curves_of_drive(run: Recording, drive: Drive) -> DriveResult:
    """Estimate the curves of a drive and count what is claimed."""
    found = follow(run, len(run.time), _across(run, drive))
    lasting = round(LASTING * run.parameters.sensors.sample_rate)
    return DriveResult(
        hours=float(run.time[-1]) / 3600.0,
        valid_peaks=len(run_lengths((found.valid == 1.0) | (found.mu_max_valid == 1.0))),
        lasting_alarms=int(np.sum(run_lengths(found.probability_beyond_peak > ALARM) > lasting)),
        largest_slip=float(np.abs(run.tyre_slip / run.lambda_max).max()),
    )


def _across(run: Recording, drive: Drive) -> Array:
    """Lateral accelerations and yaw rates as the node reads them, NaN where they are not measured, shape (N, 2)."""
    vehicle = load_vehicle(VEHICLE)
    lateral = LateralInput(vehicle.accelerometer)
    read = np.array([lateral.read(dict(sample)["imu/data"]) for sample in sensor_messages(run, vehicle, drive)])
    return np.where(read[:, 2:] == MEASURED, read[:, :2], np.nan)


def drive_rows(results: Sequence[DriveResult]) -> list[Row]:
    """Rows of all drives."""
    start = {"case": "ordinary driving", "road": "all", "stops": len(results)}
    hours = sum(result.hours for result in results)
    return [
        start | {"quantity": "valid peaks"} | at_most(sum(result.valid_peaks for result in results), 0),
        start | {"quantity": "lasting alarms"} | at_most(sum(result.lasting_alarms for result in results), 0),
        start | {"quantity": "hours"} | not_judged(hours),
        start
        | {"quantity": "largest slip over lambda_max"}
        | not_judged(max(result.largest_slip for result in results)),
    ]


@dataclass(frozen=True)
class SlopeDrive:
    """What was said in a drive, by method of friction_slope."""

    hours: float
    lasting: dict[str, int]
    """Runs of the sign -1 that last, of all wheels, valid or held."""
    lasting_valid: dict[str, int]
    """Those of valid messages."""
    beyond: dict[str, float]
    """Time with the sign -1, of all wheels together [s]."""


def signs_of_drive(run: Recording, drive: Drive) -> SlopeDrive:
    """Let the processors follow a drive and count the signs."""
    vehicle, settings = load_vehicle(VEHICLE), shipped_settings(imu=True)
    slip, _ = settings.processors(vehicle, vehicle.wheel_names[0])
    slopes = [settings.processors(vehicle, wheel)[1] for wheel in vehicle.wheel_names]
    signs: dict[str, list[list[tuple[bool, bool]]]] = {method: [[] for _ in slopes] for method in METHODS}
    for sample in sensor_messages(run, vehicle, drive):
        for topic, message in sample:
            given = [(topic, message), *(slip.process(topic, message) if topic in slip.sensors else ())]
            for wheel, of_wheel in enumerate(slopes):
                for method, slope in of_wheel.items():
                    for name, each in given:
                        if name in slope.sensors or name in slope.estimates:
                            for _, answer in slope.process(name, each):
                                if isinstance(answer, FrictionSlope):
                                    past_peak = answer.sign < 0
                                    signs[method][wheel].append((past_peak, past_peak and answer.validity.valid))
    lasting: dict[str, int] = {}
    lasting_valid: dict[str, int] = {}
    beyond: dict[str, float] = {}
    interval = float(run.time[1])
    for method, of_wheels in signs.items():
        # an answer is missing where a sample still waits for its inputs
        negative = np.array([each[: min(map(len, of_wheels))] for each in of_wheels])
        lasting[method], lasting_valid[method] = (
            int(np.sum(run_lengths(negative[:, :, kind].T) > round(LASTING / interval))) for kind in (0, 1)
        )
        beyond[method] = interval * float(negative[:, :, 0].sum())
    return SlopeDrive(float(run.time[-1]) / 3600.0, lasting, lasting_valid, beyond)


def sensor_messages(run: Recording, vehicle: Vehicle, drive: Drive) -> Iterator[list[Output]]:
    """Yield the messages of the sensors of each sample of the recording of a drive."""
    axes = CrossAxes(np.random.default_rng([drive.seed, 31]))
    for k, time in enumerate(run.time.tolist()):
        at = header_at(round((time + 1.0) * NANOSECONDS), "base_link")
        imu = Imu(header=at)
        imu.linear_acceleration.x = float(run.acceleration[k])
        leftward, yaw_rate = axes.read(float(run.yaw_rate[k] * run.speed[k]), float(run.yaw_rate[k]))
        if drive.across is Across.NOT_MEASURED:
            imu.angular_velocity_covariance[0] = -1.0
        else:
            imu.linear_acceleration.y = leftward
        if drive.across is Across.MEASURED:
            imu.angular_velocity.z = yaw_rate
        pressures = [
            (f"{wheel}/brake_pressure", FluidPressure(header=at, fluid_pressure=float(pressure)))
            for wheel, pressure in zip(vehicle.wheel_names, run.brake_pressure[k], strict=True)
        ]
        speeds = JointState(header=at, name=list(vehicle.joints), velocity=run.wheel_speed[k].tolist())
        yield [*pressures, ("imu/data", imu), ("wheel_states", speeds)]


def slope_drive_rows(results: Sequence[SlopeDrive]) -> list[Row]:
    """Rows of all drives."""
    rows: list[Row] = []
    for method in METHODS:
        start = {"case": f"ordinary driving, friction_slope {method}", "road": "all", "stops": len(results)}
        lasting = sum(result.lasting[method] for result in results)
        beyond = sum(result.beyond[method] for result in results)
        rows.append(start | {"quantity": "lasting signs beyond the peak"} | at_most(lasting, 0))
        valid = sum(result.lasting_valid[method] for result in results)
        rows.append(start | {"quantity": "of them valid throughout"} | not_judged(valid))
        rows.append(start | {"quantity": "time beyond the peak, all wheels [s]"} | not_judged(beyond))
        rows.append(start | {"quantity": "hours"} | not_judged(sum(result.hours for result in results)))
    return rows
