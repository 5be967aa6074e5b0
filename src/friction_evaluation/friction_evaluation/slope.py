"""Slope sign through the peak and back, by the shipped processors wheel_slip and friction_slope.

Parameters are those of friction_slope_monitor.yaml for both methods (only `method` differs) and of wheel_slip.yaml. A
detection before the slip has truly passed the peak counts as early, and with the missed ones as infinitely late.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from rich.progress import Progress

from friction_evaluation.parts import Row
from friction_evaluation.protocol_corner import CAR, WHEEL
from friction_evaluation.slope_runs import (
    ACCELERATION_STDDEV,
    DT,
    Run,
    below_the_peak,
    sensor_messages,
    through_the_peak,
)
from friction_parameters.values import changed
from friction_slope.parameters import SHIPPED, FrictionSlopeParameters
from friction_slope.processor import WheelProcessor
from vehicle_models.sensor_noise import CHAPTER_NOISE, NO_NOISE, SensorNoise
from vehicle_models.surfaces import TABLE_8_1
from wheel_slip.parameters import SHIPPED as SHIPPED_SLIP
from wheel_slip.parameters import WheelSlipParameters
from wheel_slip.processor import CarProcessor

Array = NDArray[np.float64]

METHODS = ("slip", "no_slip")
FALSE_ALARM_RATIO = 0.92
"""Torque of the runs without a crossing, of the peak torque."""
_FALSE_ALARM_HOLD = 1.5
"""[s]"""
_FIRST_SEED = 10_000
"""Far from the seeds of the tuning."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this part."""
    parser.add_argument("--seeds", type=int, default=500, help="noise seeds a surface")
    parser.add_argument(
        "--no-imu", action="store_true", help="without an accelerometer: wheel_slip smooths vehicle_velocity alone"
    )


def run(options: argparse.Namespace) -> list[Row]:
    """Make all runs; return a row per surface and method."""
    settings = shipped_settings(imu=not options.no_imu)
    seeds = range(_FIRST_SEED, _FIRST_SEED + options.seeds)
    rows: list[Row] = []
    with Progress() as progress:
        task = progress.add_task("slope sign", total=len(TABLE_8_1) * options.seeds)
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
    return rows


@dataclass(frozen=True)
class Settings:
    """Parameters of the processors under test."""

    slip: WheelSlipParameters
    slope: FrictionSlopeParameters
    imu: bool

    def processors(self) -> tuple[CarProcessor, dict[str, WheelProcessor]]:
        """Make wheel_slip, and friction_slope by each method."""
        car = CarProcessor(CAR, self.slip if self.imu else replace(self.slip, use_imu=False))
        return car, {method: WheelProcessor(WHEEL, CAR, replace(self.slope, method=method)) for method in METHODS}

    def exact(self) -> "Settings":
        """The shortest window, zero thresholds and dead zones: for signals without noise."""
        exact = {
            "detector.window": 3,
            "detector.rate_window": 3,
            "detector.h_instability": 0.0,
            "detector.h_stability": 0.0,
            "detector.slip_rate_dead_zone": 0.0,
            "no_slip.eta_margin": 0.0,
        }
        return replace(self, slope=changed(self.slope, exact))


@dataclass(frozen=True)
class Detection:
    """What one method said in one run; NaN where nothing was said."""

    lost: float
    """Stamp of the first message with sign -1 [s]."""
    slip: float
    """Slip at that crossing [-]."""
    regained: float
    """Stamp of the first message with sign +1 after that [s]."""
    signs: Array
    """Sign in each message, shape (samples,); 0 where not valid."""
    delay: float
    """Documented delay of the filter [s]."""


def detect(run: Run, settings: Settings, noise: SensorNoise, seed: int) -> dict[str, Detection]:
    """Drive the processors through a run; return what each method said."""
    car, slopes = settings.processors()
    answers: dict[str, list[tuple[int, float, float]]] = {method: [] for method in slopes}
    stddev = ACCELERATION_STDDEV if noise.wheel_speed_variance > 0.0 else 0.0
    for sample in sensor_messages(run, noise, stddev, seed):
        for topic, message in sample:
            inputs = [(topic, message)]
            if topic in car.sensors:
                inputs += car.process(topic, message)
            for method, slope in slopes.items():
                for name, given in inputs:
                    if name in slope.sensors or name in slope.estimates:
                        for _, answer in slope.process(name, given):
                            answers[method].append((answer.sign, answer.slip_at_crossing, answer.delay))
    return {method: _detection(np.array(said), run) for method, said in answers.items()}


def _detection(said: Array, run: Run) -> Detection:
    # Stamps of the answers are those of wheel_states: answer k speaks of sample k.
    time = run.time[: len(said)]
    signs = said[:, 0]
    lost = np.flatnonzero(signs < 0)
    first = lost[0] if lost.size else len(said)
    regained = np.flatnonzero(signs[first:] > 0)
    return Detection(
        lost=float(time[first]) if lost.size else np.nan,
        slip=float(said[first, 1]) if lost.size else np.nan,
        regained=float(time[first + regained[0]]) if regained.size else np.nan,
        signs=signs,
        delay=float(np.nanmax(said[:, 2])),
    )


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


def shipped_settings(imu: bool) -> Settings:
    """Return the shipped parameters, with or without an accelerometer."""
    return Settings(SHIPPED_SLIP["wheel_slip"].parameters, SHIPPED["friction_slope_monitor"].parameters, imu)
