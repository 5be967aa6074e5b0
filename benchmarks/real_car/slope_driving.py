"""Slope signs in ordinary driving of random cars: wheel_slip without a speed sensor, and friction_slope behind it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from friction_msgs.msg import FrictionSlope
from sensor_msgs.msg import FluidPressure, Imu, JointState

from benchmarks.real_car.answers import VEHICLE
from benchmarks.real_car.driving import LASTING
from benchmarks.rows import Row, at_most, not_judged
from benchmarks.run_lengths import run_lengths
from benchmarks.slope.detection import METHODS, shipped_settings
from corner_sim.car.recording import Recording
from friction_runtime.processor import Output
from friction_runtime.stamps import header_at
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle


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


def signs_of_drive(run: Recording) -> SlopeDrive:
    """Let the processors follow a drive and count the signs."""
    vehicle, settings = load_vehicle(VEHICLE), shipped_settings(imu=True)
    slip, _ = settings.processors(vehicle, vehicle.wheel_names[0])
    slopes = [settings.processors(vehicle, wheel)[1] for wheel in vehicle.wheel_names]
    signs: dict[str, list[list[tuple[bool, bool]]]] = {method: [[] for _ in slopes] for method in METHODS}
    for sample in sensor_messages(run, vehicle):
        for topic, message in sample:
            given = [(topic, message), *(slip.process(topic, message) if topic in slip.sensors else ())]
            for wheel, of_wheel in enumerate(slopes):
                for method, slope in of_wheel.items():
                    for name, each in given:
                        if name in slope.sensors or name in slope.estimates:
                            for _, answer in slope.process(name, each):
                                if isinstance(answer, FrictionSlope):
                                    signs[method][wheel].append((answer.sign < 0, answer.sign < 0 and answer.valid))
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


def sensor_messages(run: Recording, vehicle: Vehicle) -> Iterator[list[Output]]:
    """Yield the messages of the sensors of each sample of a recording."""
    for k, time in enumerate(run.time.tolist()):
        at = header_at(round((time + 1.0) * NANOSECONDS), "base_link")
        imu = Imu(header=at)
        imu.linear_acceleration.x = float(run.acceleration[k])
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
