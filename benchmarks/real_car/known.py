"""One corner with exactly known parameters, and the cost of a message.

Manoeuvre B of the identification protocol with its noise, after LEAD of free rolling: `car` takes the speed from the
wheels before the brakes act. Without accelerometer and speed sensor; all deviations are zero and the formula of the
tyre is known.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import nan

import numpy as np
from numpy.typing import NDArray

from benchmarks.identification.runs import STATED, stated
from benchmarks.protocol import CAR, CORNER, DT, SAMPLES, SPEED, braking, noisy
from benchmarks.real_car.bound import Bound
from benchmarks.real_car.stops import FOLLOWED, VEHICLE
from benchmarks.runner import Row, at_least, at_most, not_judged
from corner_sim.car.driving import SlipCycle
from corner_sim.car.random_car import random_car
from corner_sim.car.recording import record
from corner_sim.sensors import CHAPTER_NOISE
from friction_curve_id.car import CarEstimator, CarEstimatorParameters, CarSample
from friction_curve_id.interface import Refusal
from vehicle_models import burckhardt
from vehicle_models.surfaces import SURFACES, TABLE_8_1
from vehicle_models.vehicle import Deviation, SharedBy, Vehicle
from vehicle_models.vehicle_file import load_vehicle

Array = NDArray[np.float64]
LEAD = 40
"""Samples of free rolling before the brakes act."""
RMSE = {"dry": 0.78, "wet": 1.29, "cobblestone": 0.43, "snow": 3.4}
"""Of lambda_max by a fit of the wheel alone after 100 samples [%]; at most 1.1 times as much is asked for."""
_TIMES = 1.1
_COVERAGE = 90.0
_MEDIAN_DELAY, _LATE_DELAY = 10.0, 20.0
"""Largest delay of an alarm behind the passing, median and 95th percentile [ms]."""
_ALARM, _EARLY = 0.9, -25.0
_NO_RELAXATION = 1e-3
"""Shortest relaxation length of a vehicle file [m]."""
_EXACT = Deviation(0.0, SharedBy.ALL)


@dataclass(frozen=True)
class Known:
    """Runs to make on a road of Table 8.1."""

    road: str
    seeds: tuple[int, ...]


def exactly_known(vehicle: Vehicle) -> Vehicle:
    """Return the vehicle with deviations of zero, on tyres that respond at once as those of the chapter do."""
    of_car = ("mass", "centre_of_gravity_height", "front_load_share", "brake_pressure_delay", "engine_drag_torque")
    of_wheel = ("inertia", "brake_gain", "radius", "relaxation_length")
    of_accelerometer = ("bias", "scale", "pitch_gain", "delay")
    return replace(
        vehicle,
        wheels=tuple(
            replace(wheel, relaxation_length=_NO_RELAXATION, deviations=dict.fromkeys(of_wheel, _EXACT))
            for wheel in vehicle.wheels
        ),
        accelerometer=replace(vehicle.accelerometer, deviations=dict.fromkeys(of_accelerometer, _EXACT)),
        deviations=dict.fromkeys(of_car, _EXACT),
    )


KNOWN = CarEstimatorParameters(
    family="burckhardt",
    wheel_speed_is_interval_mean=False,
    slope_stddev=0.0,
    torque_stddev=CHAPTER_NOISE.torque_variance**0.5,
)
"""What is known of the sensors, the tyre and the road, besides the car."""


def make_known(job: Known) -> Array:
    """Return the answers after each sample of the braking, shape (runs, SAMPLES, len(STATED)); NaN where none."""
    truth = braking("B", SURFACES[job.road])
    rolling = np.full(LEAD, SPEED)
    signals = (
        np.concatenate([rolling / CORNER.radius, truth.wheel_speed[0]]),
        np.concatenate([rolling, truth.speed[0]]),
        np.concatenate([0.0 * rolling, truth.torque[0]]),
    )
    found = np.full((len(job.seeds), LEAD + SAMPLES, len(STATED)), nan)
    for row, seed in zip(found, job.seeds, strict=True):
        wheel_speed, _, torque = noisy(signals, np.random.default_rng([seed, TABLE_8_1.index(job.road)]))
        car, gain = CarEstimator(exactly_known(CAR), KNOWN), CAR.wheels[0].brake_gain
        for k in range(LEAD + SAMPLES):
            answer = car.update(CarSample(k * DT, [float(wheel_speed[k])], [float(torque[k]) / gain], nan))[0]
            if not isinstance(answer, Refusal):
                row[k] = stated(answer)
    return found[:, LEAD:]


def known_rows(parts: Sequence[tuple[str, Array]]) -> list[Row]:
    """Rows of the answers by road. Alarms: over all roads."""
    rows: list[Row] = []
    delays = []
    for road in TABLE_8_1:
        found = np.concatenate([answers for name, answers in parts if name == road])
        rows += _errors(road, found)
        delays.append(_delays(road, found))
    delay = np.concatenate(delays)
    start: Row = {"case": "known exactly", "road": "all", "stops": len(delay)}
    for what, value, limit in (
        ("median", float(np.median(delay)), _MEDIAN_DELAY),
        ("95th percentile", float(np.quantile(delay, 0.95, method="higher")), _LATE_DELAY),
    ):
        rows.append(start | {"quantity": f"delay of the alarm, {what} [ms]"} | at_most(value, limit))
    early = 100.0 * float(np.mean(delay < _EARLY))
    rows.append(start | {"quantity": "early alarms [%]"} | not_judged(early))
    return rows


def _errors(road: str, found: Array) -> list[Row]:
    lambda_max, mu_max = (float(each[0]) for each in burckhardt.peak(np.array([SURFACES[road]])))
    last = dict(zip(STATED, found[:, -1].T, strict=True))
    error = 100.0 * (last["lambda_max"] / lambda_max - 1.0)
    start: Row = {"case": "known exactly", "road": road, "stops": len(found)}
    rmse = float(np.sqrt(np.mean(error**2)))
    quantity = "RMSE of lambda_max after 100 samples [%]"
    rows = [start | {"quantity": quantity} | at_most(rmse, _TIMES * RMSE[road]) | {"bias_pct": float(np.mean(error))}]
    for name, truth in (("lambda_max", lambda_max), ("mu_max", mu_max)):
        inside = 100.0 * float(np.mean(np.abs(last[name] - truth) <= 1.96 * last[f"{name}_stddev"]))
        rows.append(start | {"quantity": f"coverage of {name} [%]"} | at_least(inside, _COVERAGE))
    return rows


def _delays(road: str, found: Array) -> Array:
    """Delay of the first alarm of each run behind the passing of the peak [ms]; infinite where there is none."""
    lambda_max = float(burckhardt.peak(np.array([SURFACES[road]]))[0][0])
    passing = int((braking("B", SURFACES[road]).slip[0] > lambda_max).argmax())
    alarmed = found[:, :, STATED.index("probability_beyond_peak")] > _ALARM
    first = np.where(alarmed.any(axis=1), alarmed.argmax(axis=1), np.inf)
    return np.asarray(1e3 * DT * (first - passing))


_SLOWEST = 1.5
"""Largest 99th percentile [ms a wheel]."""


def timed(stop: Bound) -> Array:
    """CPU time of each sample of the stop of a random car [ms a wheel]."""
    car = random_car(stop.seed, stop.road, stop.family)
    run = record(car.parameters, SlipCycle(car.parameters, car.cycling), stop.seed)
    beyond = run.tyre_slip > run.lambda_max
    last = float(run.time[beyond.any(axis=1).argmax()]) + FOLLOWED
    estimator = CarEstimator(load_vehicle(VEHICLE))
    found: list[float] = []
    for k in range(min(int(np.searchsorted(run.time, last)), len(run.time))):
        sample = CarSample(float(run.time[k]), run.wheel_speed[k], run.brake_pressure[k], float(run.acceleration[k]))
        begin = time.thread_time_ns()
        estimator.update(sample)
        found.append((time.thread_time_ns() - begin) * 1e-6 / run.wheel_speed.shape[1])
    return np.array(found)


def cost_rows(stops: Sequence[Array]) -> list[Row]:
    """Return the rows of the cost of a sample."""
    found = np.concatenate(stops)
    start: Row = {"case": "cost", "road": "all", "stops": len(stops)}
    median, slowest = float(np.median(found)), float(np.percentile(found, 99))
    return [
        start | {"quantity": "median [ms a wheel]"} | not_judged(median),
        start | {"quantity": "99th percentile [ms a wheel]"} | at_most(slowest, _SLOWEST),
    ]
