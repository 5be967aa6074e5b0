"""One corner with exactly known parameters: the estimator `car` beside exact_vehicle, and the cost of a message.

Manoeuvre B of the identification protocol with its noise, after LEAD of free rolling: `car` takes the speed from the
wheels before the brakes act. Without accelerometer and speed sensor; all deviations are zero and the formula of the
tyre is known.
"""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import nan

import numpy as np
from numpy.typing import NDArray

from benchmarks.identification.runs import STATED, stated
from benchmarks.protocol import CAR, CORNER, DT, SAMPLES, SPEED, braking, noisy
from benchmarks.real_car.bound import Bound
from benchmarks.real_car.stops import FOLLOWED, METHODS, VEHICLE
from benchmarks.runner import Row, at_least, at_most, not_judged
from corner_sim.car.driving import SlipCycle
from corner_sim.car.random_car import random_car
from corner_sim.car.recording import record
from corner_sim.sensors import CHAPTER_NOISE
from friction_curve_id.car import CarEstimator, CarEstimatorParameters, CarSample
from friction_curve_id.interface import CurveEstimate, Refusal, Sample
from friction_curve_id.methods import EXACT_VEHICLE, exact_wheel_estimator
from vehicle_models import burckhardt
from vehicle_models.surfaces import SURFACES, TABLE_8_1
from vehicle_models.vehicle import Deviation, SharedBy, Vehicle
from vehicle_models.vehicle_file import load_vehicle

Array = NDArray[np.float64]
LEAD = 40
"""Samples of free rolling before the brakes act."""
RMSE = {"dry": 0.78, "wet": 1.29, "cobblestone": 0.43, "snow": 3.4}
"""Of lambda_max by exact_vehicle after 100 samples [%]; at most 1.1 times as much is asked for."""
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
    method: str
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
        update = _updater(job.method)
        for k in range(LEAD + SAMPLES):
            answer = update(k * DT, float(wheel_speed[k]), float(torque[k]))
            if not isinstance(answer, Refusal):
                row[k] = stated(answer)
    return found[:, LEAD:]


def _updater(method: str) -> Callable[[float, float, float], CurveEstimate | Refusal]:
    """Return what takes a sample: time [s], wheel speed [rad/s] and brake torque [N m]."""
    if method == EXACT_VEHICLE:
        wheel = exact_wheel_estimator(EXACT_VEHICLE, CORNER)
        return lambda time, omega, torque: wheel.update(Sample(time, omega, None, torque))
    parameters = CarEstimatorParameters(
        family="burckhardt",
        wheel_speed_is_interval_mean=False,
        slope_stddev=0.0,
        torque_stddev=CHAPTER_NOISE.torque_variance**0.5,
    )
    car, gain = CarEstimator(exactly_known(CAR), parameters), CAR.wheels[0].brake_gain
    return lambda time, omega, torque: car.update(CarSample(time, [omega], [torque / gain], nan))[0]


def known_rows(method: str, parts: Sequence[tuple[str, Array]]) -> list[Row]:
    """Rows of a method from its answers by road; only the car's estimator is judged. Alarms: over all roads."""
    rows: list[Row] = []
    delays = []
    for road in TABLE_8_1:
        found = np.concatenate([answers for name, answers in parts if name == road])
        rows += _errors(method, road, found)
        delays.append(_delays(road, found))
    delay = np.concatenate(delays)
    start: Row = {"case": f"known exactly, {method}", "road": "all", "stops": len(delay)}
    for what, value, limit in (
        ("median", float(np.median(delay)), _MEDIAN_DELAY),
        ("95th percentile", float(np.quantile(delay, 0.95, method="higher")), _LATE_DELAY),
    ):
        judged = not_judged(value) if method == EXACT_VEHICLE else at_most(value, limit)
        rows.append(start | {"quantity": f"delay of the alarm, {what} [ms]"} | judged)
    early = 100.0 * float(np.mean(delay < _EARLY))
    rows.append(start | {"quantity": "early alarms [%]"} | not_judged(early))
    return rows


def _errors(method: str, road: str, found: Array) -> list[Row]:
    lambda_max, mu_max = (float(each[0]) for each in burckhardt.peak(np.array([SURFACES[road]])))
    last = dict(zip(STATED, found[:, -1].T, strict=True))
    error = 100.0 * (last["lambda_max"] / lambda_max - 1.0)
    start: Row = {"case": f"known exactly, {method}", "road": road, "stops": len(found)}
    rmse = float(np.sqrt(np.mean(error**2)))
    judged = not_judged(rmse) if method == EXACT_VEHICLE else at_most(rmse, _TIMES * RMSE[road])
    quantity = "RMSE of lambda_max after 100 samples [%]"
    rows = [start | {"quantity": quantity} | judged | {"bias_pct": float(np.mean(error))}]
    for name, truth in (("lambda_max", lambda_max), ("mu_max", mu_max)):
        inside = 100.0 * float(np.mean(np.abs(last[name] - truth) <= 1.96 * last[f"{name}_stddev"]))
        judged = not_judged(inside) if method == EXACT_VEHICLE else at_least(inside, _COVERAGE)
        rows.append(start | {"quantity": f"coverage of {name} [%]"} | judged)
    return rows


def _delays(road: str, found: Array) -> Array:
    """Delay of the first alarm of each run behind the passing of the peak [ms]; infinite where there is none."""
    lambda_max = float(burckhardt.peak(np.array([SURFACES[road]]))[0][0])
    passing = int((braking("B", SURFACES[road]).slip[0] > lambda_max).argmax())
    alarmed = found[:, :, STATED.index("probability_beyond_peak")] > _ALARM
    first = np.where(alarmed.any(axis=1), alarmed.argmax(axis=1), np.inf)
    return np.asarray(1e3 * DT * (first - passing))


Times = NDArray[np.float64]
_DEARER, _SLOWEST = 2.5, 1.5
"""Largest median in medians of exact_vehicle, and largest 99th percentile [ms a wheel]."""


def timed(stop: Bound) -> Mapping[str, Times]:
    """CPU time of each sample of the stop of a random car [ms a wheel], by method."""
    car = random_car(stop.seed, stop.road, stop.family)
    run = record(car.parameters, SlipCycle(car.parameters, car.cycling), stop.seed)
    beyond = run.tyre_slip > run.lambda_max
    last = float(run.time[beyond.any(axis=1).argmax()]) + FOLLOWED
    estimators = {name: make(load_vehicle(VEHICLE)) for name, make in METHODS.items()}
    found: dict[str, list[float]] = {name: [] for name in METHODS}
    straight = np.full(2, nan)
    for k in range(min(int(np.searchsorted(run.time, last)), len(run.time))):
        sample = float(run.time[k]), run.wheel_speed[k], run.brake_pressure[k], float(run.acceleration[k]), straight
        for name, estimator in estimators.items():
            begin = time.thread_time_ns()
            estimator.update(*sample)
            found[name].append((time.thread_time_ns() - begin) * 1e-6 / run.wheel_speed.shape[1])
    return {name: np.array(times) for name, times in found.items()}


def cost_rows(stops: Sequence[Mapping[str, Times]]) -> list[Row]:
    """Rows of the methods; those of car are judged."""
    times = {name: np.concatenate([stop[name] for stop in stops]) for name in METHODS}
    reference = float(np.median(times[EXACT_VEHICLE]))
    rows: list[Row] = []
    for name, found in times.items():
        median, slowest = float(np.median(found)), float(np.percentile(found, 99))
        start: Row = {"case": f"cost, {name}", "road": "all", "stops": len(stops)}
        relative = not_judged(1.0) if name == EXACT_VEHICLE else at_most(median / reference, _DEARER)
        rows.append(start | {"quantity": "median CPU time of a sample [of exact_vehicle]"} | relative)
        judged = not_judged(slowest) if name == EXACT_VEHICLE else at_most(slowest, _SLOWEST)
        rows.append(start | {"quantity": "99th percentile [ms a wheel]"} | judged | {"median_ms": median})
    return rows
