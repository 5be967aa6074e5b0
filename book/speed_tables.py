"""Tables 8.4 and 8.5: errors of lambda_max at the ABS activation and at the end, with measured and estimated speed."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from benchmarks.protocol import ACCELERATION_OFFSET, ACCELERATION_STDDEV, CAR, CORNER, DT, SPEED, STEP, WHEEL
from benchmarks.runner import Row
from benchmarks.slip.stops import GRADE
from book.chapter_numbers import ERRORS_ON_ROADS
from corner_sim.corner import SingleCorner
from corner_sim.sensors import CHAPTER_NOISE
from friction_curve_id.chapter.curve_fitting import PointFitting
from friction_curve_id.chapter.friction_samples import FrictionSamples
from friction_curve_id.interface import CurveEstimate, Refusal, Sample
from friction_curve_id.methods import CHAPTER_METHODS
from friction_curve_id.parameters import SHIPPED, FrictionCurveParameters
from friction_parameters.parameter import changed
from vehicle_models import burckhardt
from vehicle_models.reason import Reason
from vehicle_models.surfaces import surface
from wheel_slip.estimator import SlipEstimator
from wheel_slip.parameters import WheelSlipParameters


class BeyondStart:
    """CurveEstimator of one braking that begins with the first 20 samples beyond `lambda_init`.

    The chapter says that the methods are initialised beyond lambda_init. friction_curve_id begins there, with all the
    samples of the braking so far; this reading has only those that follow.
    """

    def __init__(self, method: str, lambda_init: float) -> None:
        """Make one of CHAPTER_METHODS; `lambda_init` is a slip [-]."""
        self._samples = FrictionSamples(CORNER)
        self._fitting = PointFitting(CHAPTER_METHODS[method]())
        self._lambda_init = lambda_init
        self.reset()

    def reset(self) -> None:
        """Forget the braking."""
        self._samples.reset()
        self._fitting.reset()
        self._begun = False

    def update(self, sample: Sample) -> CurveEstimate | Refusal:
        """Take the next sample."""
        point = self._samples.update(sample)
        if isinstance(point, Refusal):
            return point
        self._begun = self._begun or point.slip > self._lambda_init
        if not self._begun:
            return Refusal(Reason.NOT_READY, f"slip {point.slip:.3f} has not passed {self._lambda_init:.3f}")
        return self._fitting.update(point)


Array = NDArray[np.float64]

CASES = (("rls", "all"), ("rls", "beyond"), ("rml_ml", "all"), ("rml_ml", "beyond"))
"""Methods, and with which samples they begin."""
SPEEDS = ("measured", "estimated")
LAMBDA_INIT = 0.07
ACTIVATION_SLIP = 0.15
_CRUISE = 600
"""Samples before the brake onset: 3 s."""
_BUILD_UP = 0.25
"""[s]"""
_LONGEST = 200
"""Samples after which a torque that does not reach lambda_init is given up."""
_FAILURE = 0.5
"""An error beyond this share of lambda_max is a failure."""


@dataclass(frozen=True)
class Road:
    """A road of the chapter's test drives, and how long they took on it."""

    name: str
    activation: int
    """Samples from lambda_init to the ABS activation."""
    end: int
    """Samples from lambda_init to the end."""


ROADS = (Road("high_grip", 88, 92), Road("off_road", 44, 52))


@dataclass(frozen=True)
class Braking:
    """Noise-free truth, n samples."""

    wheel_speed: Array
    speed: Array
    acceleration: Array
    torque: Array
    begin: int
    """Index of the first sample beyond lambda_init."""


def tables(seeds: range, parameters: WheelSlipParameters) -> list[Row]:
    """Make all runs; return a row per road, method, speed and instant.

    Args:
        seeds: of the noise.
        parameters: of wheel_slip.
    """
    rows: list[Row] = []
    for road in ROADS:
        truth = braking(road)
        at = (truth.begin + road.activation, truth.begin + road.end)
        found = {(*case, speed): np.full((len(seeds), 2), np.nan) for case in CASES for speed in SPEEDS}
        for number, seed in enumerate(seeds):
            samples = _samples(truth, at[1], seed, parameters)
            for (method, start, speed), values in found.items():
                values[number] = _peaks(method, start, samples[speed], at)
        lambda_max = float(burckhardt.peak(surface(road.name))[0])
        errors = {key: 100.0 * (values / lambda_max - 1.0) for key, values in found.items()}
        for case in CASES:
            for speed in SPEEDS:
                for index, instant in enumerate(("activation", "end")):
                    measured = _rmse(errors[(*case, "measured")][:, index])
                    rows.append(_row(road, case, speed, instant, errors[(*case, speed)][:, index], measured))
    return rows


@cache
def braking(road: Road) -> Braking:
    """Truth of the manoeuvre, with the hold torque that gives the chapter's number of samples."""
    theta = surface(road.name)
    peak = float(CORNER.peak_torque(theta))

    def surplus(ratio: float) -> float:
        truth = _brake(theta, ratio * peak, road)
        at = truth.begin + road.activation
        return float(1.0 - truth.wheel_speed[at] * CORNER.radius / truth.speed[at]) - ACTIVATION_SLIP

    truth = _brake(theta, float(brentq(surplus, 0.995, 1.3, xtol=1e-5)) * peak, road)

    def after_cruise(values: Array, rolling: float) -> Array:
        return np.concatenate([np.full(_CRUISE, rolling), values])

    return Braking(
        after_cruise(truth.wheel_speed, SPEED / CORNER.radius),
        after_cruise(truth.speed, SPEED),
        after_cruise(truth.acceleration, 0.0),
        after_cruise(truth.torque, 0.0),
        _CRUISE + truth.begin,
    )


def _brake(theta: Array, hold: float, road: Road) -> Braking:
    """Truth from the brake onset on."""
    corner = SingleCorner(CORNER, SPEED)
    kept: list[tuple[float, float, float, float]] = []
    begin: int | None = None
    while begin is None or len(kept) <= begin + road.end:
        k = len(kept)
        torque, after = (hold * min(j * DT / _BUILD_UP, 1.0) for j in (k, k + 1))
        if begin is None and (corner.slip[0] > LAMBDA_INIT or k > _LONGEST):
            begin = k
        acceleration = float(corner.acceleration(theta)[0])
        kept.append((float(corner.wheel_speed[0]), float(corner.speed[0]), acceleration, torque))
        corner.step(torque, after, theta, DT)
    wheel_speed, speed, accelerations, torques = np.array(kept).T
    return Braking(wheel_speed, speed, accelerations, torques, begin)


def _samples(truth: Braking, last: int, seed: int, parameters: WheelSlipParameters) -> dict[str, list[Sample]]:
    """Noisy samples from a little before the brake onset, with either speed."""
    rng = np.random.default_rng(seed)
    draws = rng.standard_normal((truth.speed.size, 4))
    omega = truth.wheel_speed + np.sqrt(CHAPTER_NOISE.wheel_speed_variance) * draws[:, 0]
    speed = truth.speed + np.sqrt(CHAPTER_NOISE.speed_variance) * draws[:, 1]
    torque = truth.torque + np.sqrt(CHAPTER_NOISE.torque_variance) * draws[:, 2]
    slope = CORNER.gravity * GRADE * (1.0 if seed % 2 == 0 else -1.0)
    felt = truth.acceleration + slope + ACCELERATION_OFFSET + ACCELERATION_STDDEV * draws[:, 3]
    estimator = SlipEstimator(CAR, parameters.estimator)
    samples: dict[str, list[Sample]] = {name: [] for name in SPEEDS}
    for k in range(last + 1):
        estimate = estimator.update((k + 1) * STEP, [float(omega[k])], float(felt[k]))[0]
        if k >= _CRUISE:
            braked = max(float(torque[k]), 0.0)
            for name, value in (("measured", float(speed[k])), ("estimated", estimate.vehicle_speed)):
                samples[name].append(Sample((k + 1) * DT, float(omega[k]), value, braked))
    return samples


def _peaks(method: str, start: str, samples: list[Sample], at: tuple[int, int]) -> tuple[float, float]:
    """lambda_max [-] at the two instants."""
    answers = _answers(method, start, samples)
    first, last = (answers[k - _CRUISE] for k in at)
    return _lambda_max(first), _lambda_max(last)


def _answers(method: str, start: str, samples: list[Sample]) -> list[CurveEstimate | Refusal]:
    shipped: FrictionCurveParameters = SHIPPED["friction_curve_id"].parameters
    parameters = changed(shipped, {"method": method, "chapter.lambda_init": LAMBDA_INIT})
    estimator = BeyondStart(method, LAMBDA_INIT) if start == "beyond" else parameters.estimator(CAR, WHEEL)
    return [estimator.update(sample) for sample in samples]


def _lambda_max(answer: CurveEstimate | Refusal) -> float:
    return answer.lambda_max if isinstance(answer, CurveEstimate) else float("nan")


def _row(road: Road, case: tuple[str, str], speed: str, instant: str, errors: Array, measured: float) -> Row:
    method, start = case
    good = errors[np.abs(errors) <= 100.0 * _FAILURE]
    low, median, high = np.percentile(good, (5.0, 50.0, 95.0)) if good.size else np.full(3, np.nan)
    chapter = ERRORS_ON_ROADS.get((road.name, method, speed), (float("nan"), float("nan")))
    return {
        "case": f"Table {'8.4' if speed == 'measured' else '8.5'}, {road.name}",
        "method": method,
        "start": start,
        "speed": speed,
        "instant": instant,
        "samples": road.activation if instant == "activation" else road.end,
        "bias_percent": float(good.mean()) if good.size else float("nan"),
        "rmse_percent": _rmse(errors),
        "p5_percent": float(low),
        "median_percent": float(median),
        "p95_percent": float(high),
        "failures": errors.size - good.size,
        "runs": errors.size,
        "over_measured": _rmse(errors) / measured,
        "chapter_percent": chapter[instant == "end"],
    }


def _rmse(errors: Array) -> float:
    """RMS error over the runs that have not failed [%]."""
    good = errors[np.abs(errors) <= 100.0 * _FAILURE]
    return float(np.sqrt(np.mean(good**2))) if good.size else float("nan")
