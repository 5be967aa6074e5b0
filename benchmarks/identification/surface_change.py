"""Change of the road under braking beyond the peak: delay of its detection, errors of the new curve."""

import argparse
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from rich.progress import Progress

from benchmarks.protocol import CORNER, DT, SAMPLES, SPEED, brake_torque, hold_torque, noisy
from benchmarks.runner import Row
from corner_sim.corner import SingleCorner
from friction_curve_id.interface import CurveEstimate, RestartCause, Sample
from friction_curve_id.methods import EXACT_VEHICLE, exact_wheel_estimator
from vehicle_models import burckhardt
from vehicle_models.surfaces import surface

Array = NDArray[np.float64]

_FIRST_SEED = 20_000
_CHANGES = (("dry", "snow"), ("dry", "wet"), ("wet", "snow"), ("cobblestone", "wet"), ("dry", "cobblestone"))
_AFTER = 100
"""Samples within which the new curve must be found."""
_APPLY_RATE, _RELEASE_RATE = 2400.0, 5000.0
"""[N m/s]"""
_RELEASE_SLIP, _APPLY_SLIP = 2.0, 0.5
"""In units of lambda_max: where a brake under control releases and applies."""


@dataclass(frozen=True)
class Change:
    """Manoeuvre B on one road, then another road, with the torque held or under control; true histories."""

    wheel_speed: Array
    speed: Array
    torque: Array


def drive(before: Array, after: Array, controlled: bool) -> Change:
    """Drive until `_AFTER` samples past the change or until the wheel locks."""
    plant = SingleCorner(CORNER, np.array([SPEED]))
    level = float(hold_torque("B", before)[0])
    ramp = brake_torque("B", level, np.arange(SAMPLES + 1) * DT)
    release_slip, apply_slip = (share * float(burckhardt.peak(after)[0]) for share in (_RELEASE_SLIP, _APPLY_SLIP))
    torque, applying = 0.0, True
    states = []
    for k in range(SAMPLES + _AFTER):
        slip = float(plant.slip[0])
        if slip > 0.99:
            break
        states.append((float(plant.wheel_speed[0]), float(plant.speed[0]), torque))
        following = torque
        if k < SAMPLES:
            following = float(ramp[k + 1])
        elif controlled:
            applying = slip < apply_slip or (applying and slip < release_slip)
            rate = _APPLY_RATE if applying else -_RELEASE_RATE
            following = min(max(torque + rate * DT, 0.0), level)
        plant.step(torque, following, before if k < SAMPLES else after, DT)
        torque = following
    return Change(*np.array(states).T)


def surface_change(options: argparse.Namespace) -> list[Row]:
    """Rows per change and kind of braking; the seeds are those of the noise."""
    rows: list[Row] = []
    with Progress() as progress:
        bar = progress.add_task("surface change", total=2 * len(_CHANGES) * options.seeds)
        for names in _CHANGES:
            before, after = surface(names[0]), surface(names[1])
            for controlled in (False, True):
                change = drive(before, after, controlled)
                results = []
                for seed in range(options.seeds):
                    results.append(_follow(change, after, seed))
                    progress.advance(bar)
                delay, false, lambda_z, mu_z = np.array(results).T
                rows.append(
                    {
                        "before": names[0],
                        "after": names[1],
                        "torque": "controlled" if controlled else "held",
                        "runs": options.seeds,
                        "samples_after": len(change.torque) - SAMPLES,
                        "not_detected": int(np.isinf(delay).sum()),
                        "false_restarts": int(false.sum()),
                        "delay_ms_median": float(np.median(delay)),
                        "delay_ms_p95": float(np.quantile(delay, 0.95, method="higher")),
                        "lambda_within_2_stddev_pct": 100.0 * float(np.mean(np.abs(lambda_z) <= 2.0)),
                        "mu_within_2_stddev_pct": 100.0 * float(np.mean(np.abs(mu_z) <= 2.0)),
                        "both_within_2_stddev_pct": 100.0 * float(np.mean(np.maximum(abs(lambda_z), abs(mu_z)) <= 2.0)),
                    }
                )
    return rows


def _follow(change: Change, after: Array, seed: int) -> tuple[float, int, float, float]:
    """Delay of the restart [ms], restarts before the change, errors of lambda_max and mu_max at the end [stddev]."""
    generator = np.random.default_rng([_FIRST_SEED, 20, seed])
    omega, speed, torque = noisy((change.wheel_speed, change.speed, change.torque), generator)
    estimator = exact_wheel_estimator(EXACT_VEHICLE, CORNER)
    delay, false, last = np.inf, 0, CurveEstimate(0, 0.0)
    for k in range(len(torque)):
        answer = estimator.update(Sample(k * DT, float(omega[k]), float(speed[k]), float(torque[k])))
        if not isinstance(answer, CurveEstimate):
            continue
        last = answer
        if answer.restart_cause is RestartCause.SURFACE:
            if k < SAMPLES:
                false += 1
            else:
                delay = min(delay, 1e3 * DT * (k - SAMPLES))
    lambda_max, mu_max = (float(value) for value in burckhardt.peak(after))
    return (
        delay,
        false,
        (last.lambda_max - lambda_max) / last.lambda_max_stddev,
        (last.mu_max - mu_max) / last.mu_max_stddev,
    )
