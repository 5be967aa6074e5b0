"""Slope sign: delay, false alarms and slip at detection; ordinary braking, in which no sign beyond the peak may come.

Ordinary braking is of a car on two axles, whose load follows the acceleration at once; the processors assume a
body that pitches. A front and a rear wheel are judged.
"""

import argparse
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from rich.progress import Progress

from benchmarks.protocol import ACCELERATION_STDDEV, DT
from benchmarks.runner import Row, at_most
from benchmarks.slope.detection import (
    METHODS,
    Detection,
    Run,
    Settings,
    below_the_peak,
    detect,
    detections,
    shipped_settings,
    through_the_peak,
)
from benchmarks.slope.driver_stops import driver_stops, number_of_runs
from corner_sim.car_plant import CarModelParameters, CarPlant, SensorErrors, in_order
from corner_sim.driver import DriverProfile
from corner_sim.plant import SAMPLE_TIME, SAMPLE_TIME_NS
from corner_sim.road import Road
from corner_sim.ros import messages
from corner_sim.sensors import CHAPTER_NOISE, NO_NOISE
from friction_parameters.command_line import count
from friction_runtime.processor import Output
from vehicle_models.brake_actuator import ActuatorParameters, Command
from vehicle_models.constants import GRAVITY
from vehicle_models.surfaces import TABLE_8_1
from vehicle_models.vehicle_file import load_vehicle

ROAD = "dry"
DECELERATIONS = (0.1, 0.3, 0.5)
"""Deceleration that the driver wants, over g."""
RISES = (0.1, 0.5)
"""Times in which the pressure rises [s]."""
WHEELS = ("front_left", "rear_left")
_CAR = in_order(load_vehicle("compact_car"))
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
    variance = ACCELERATION_STDDEV**2
    errors = SensorErrors(CHAPTER_NOISE, variance, 0.0, seed)
    plant = CarPlant(_CAR, Road((ROAD,), (0.0,)), CarModelParameters(), ActuatorParameters(), errors, _SPEED)
    for index in range(round(_DURATION / SAMPLE_TIME)):
        measured = plant.measure(plant.sample())
        yield messages.sensors((index + 1) * SAMPLE_TIME_NS, _CAR, measured, CHAPTER_NOISE, variance)
        plant.advance(driver.demand(index * SAMPLE_TIME), Command.NONE)


FALSE_ALARM_RATIO = 0.92
"""Torque of the runs without a crossing, as a share of the peak torque."""
_FALSE_ALARM_HOLD = 1.5
"""[s]"""
_FIRST_SEED = 10_000
"""Far from the seeds of the tuning."""
_MOST_STOPS, _MOST_BRAKINGS = 100, 5
"""Seeds of the runs of whole cars, which take longest."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this part."""
    parser.add_argument("--seeds", type=count, default=500, help="noise seeds a surface")
    parser.add_argument(
        "--no-imu", action="store_true", help="without an accelerometer: wheel_slip smooths vehicle_velocity alone"
    )


def run(options: argparse.Namespace) -> list[Row]:
    """Make all runs; return a row per surface and method."""
    settings = shipped_settings(imu=not options.no_imu)
    seeds = range(_FIRST_SEED, _FIRST_SEED + options.seeds)
    of_stops, of_brakings = (seeds[:most] if settings.imu else seeds[:0] for most in (_MOST_STOPS, _MOST_BRAKINGS))
    car_runs = number_of_runs(of_stops) + len(of_brakings) * brakings_of_a_seed()
    rows: list[Row] = []
    with Progress() as progress:
        task = progress.add_task("slope sign", total=len(TABLE_8_1) * options.seeds + car_runs)
        for name in TABLE_8_1:
            crossing, level = through_the_peak(name), below_the_peak(name, FALSE_ALARM_RATIO, _FALSE_ALARM_HOLD)
            found: dict[str, list[Detection]] = {method: [] for method in METHODS}
            false_alarms = dict.fromkeys(METHODS, 0)
            for seed in seeds:
                detected = detect(crossing, settings, CHAPTER_NOISE, seed)
                alarms = detect(level, settings, CHAPTER_NOISE, seed)
                for method in METHODS:
                    found[method].append(detected[method])
                    false_alarms[method] += not np.isnan(alarms[method].lost)
                progress.advance(task)
            for method in METHODS:
                noisy = row(name, method, crossing, found[method], false_alarms[method] / len(seeds))
                rows.append(noisy | _noise_free(name, method, settings))
        if settings.imu:
            rows += driver_stops(of_stops, settings, lambda: progress.advance(task))
            rows += ordinary_braking(of_brakings, settings, lambda: progress.advance(task))
    return rows


def row(name: str, method: str, run: Run, found: Sequence[Detection], false_alarms: float) -> Row:
    """Sum up the runs of a surface and method; `false_alarms` is the share of runs with one."""
    up, down = run.crossings()
    lost = np.array([d.lost for d in found]) - up
    regained = np.array([d.regained for d in found]) - down
    slips = np.array([d.slip for d in found])
    in_time = lost >= 0.0
    delay, back = np.where(in_time, lost, np.inf), np.where(regained >= 0.0, regained, np.inf)
    known = slips[in_time & np.isfinite(slips)]
    mean = float(known.mean()) if known.size else np.nan
    return {
        "surface": name,
        "method": method,
        "seeds": len(found),
        "delay_median_ms": 1e3 * float(np.median(delay)),
        "delay_p95_ms": 1e3 * float(np.percentile(delay, 95.0, method="higher")),
        "missed_percent": 100.0 * float(np.isnan(lost).mean()),
        "early_percent": 100.0 * float((lost < 0.0).mean()),
        "false_alarm_percent": 100.0 * false_alarms,
        "lambda_max": run.lambda_max,
        "slip_known_percent": 100.0 * known.size / max(int(in_time.sum()), 1),
        "slip_mean": mean,
        "slip_error_percent": 100.0 * (mean / run.lambda_max - 1.0),
        "slip_stddev": float(known.std()) if known.size else np.nan,
        "regained_median_ms": 1e3 * float(np.median(back)),
        "regained_missed_percent": 100.0 * float(np.isinf(back).mean()),
        "filter_delay_ms": 1e3 * found[0].delay,
    }


def _noise_free(name: str, method: str, settings: Settings) -> Row:
    """Shortest window, zero thresholds and dead zones; and the time after (8.6) in which eta and slip rate disagree."""
    run = through_the_peak(name)
    up, down = run.crossings()
    found = detect(run, settings.exact(), NO_NOISE, 0)[method]
    apart = disagreement(run)
    return {
        "exact_filter_delay_ms": 1e3 * found.delay,
        "exact_lost_ms": 1e3 * (found.lost - up),
        "exact_regained_ms": 1e3 * (found.regained - down),
        "disagreement_onset_ms": 1e3 * apart[0],
        "disagreement_release_ms": 1e3 * apart[1],
    }


def disagreement(run: Run) -> tuple[float, float]:
    """Time [s] in which the signs of eta and slip rate differ while braked, before and after the release begins."""
    differ = (np.sign(run.eta) != np.sign(run.slip_rate)) & (run.torque > 0.0)
    released = int(np.argmax(run.torque >= run.torque.max())) + 1
    released += int(np.argmax(np.diff(run.torque[released:]) < 0.0))
    return DT * float(differ[:released].sum()), DT * float(differ[released:].sum())
