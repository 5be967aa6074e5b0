"""Braking to a standstill with random cars: estimates of all wheels, and their rows with limits."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from benchmarks.identification.runs import STATED, stated
from benchmarks.runner import Row, at_least, at_most, not_judged
from corner_sim.car.car_parameters import CarParameters
from corner_sim.car.driving import Cycling, SlipCycle
from corner_sim.car.recording import Recording, record
from friction_curve_id.car import CarEstimator, CarSample
from friction_curve_id.interface import Refusal
from vehicle_models.vehicle_file import load_vehicle

Array = NDArray[np.float64]


VEHICLE = "compact_car"
"""Vehicle file of the estimators: nominal values and deviations, of no car of the plant."""


@dataclass(frozen=True)
class Answers:
    """Answers after each of n samples, STATED in order, arrays of shape (n, 4); NaN where there was none."""

    lambda_max: Array
    lambda_max_stddev: Array
    mu_max: Array
    mu_max_stddev: Array
    probability_beyond_peak: Array
    mu_max_valid: Array
    """Whether mu_max was valid, 0 or 1."""
    valid: Array
    """Whether both were, 0 or 1."""
    restarted: Array


def follow(run: Recording, samples: int, across: Array | None = None) -> Answers:
    """Feed the first `samples` samples of a recording to the estimator of the car, with its shipped parameters.

    `across`: lateral accelerations [m/s^2] and yaw rates [rad/s], shape (N, 2); None: they are not measured.
    """
    estimator = CarEstimator(load_vehicle(VEHICLE))
    found = np.full((samples, 4, len(STATED)), np.nan)
    found[:, :, -3:] = 0.0
    across = np.full((samples, 2), np.nan) if across is None else across
    for k in range(samples):
        measured = run.wheel_speed[k], run.brake_pressure[k], float(run.acceleration[k])
        answers = estimator.update(CarSample(float(run.time[k]), *measured, *across[k].tolist()))
        for wheel, answer in enumerate(answers):
            if not isinstance(answer, Refusal):
                found[k, wheel] = stated(answer)
    return Answers(*np.moveaxis(found, 2, 0))


JUDGED = 0.4
"""Time after the first wheel has passed its peak at which estimates are judged [s]."""
FOLLOWED = 1.5
"""Time after that to which a stop is followed [s]."""
TOO_SOON = 0.05
"""Time before which nothing may be valid [s]."""
EARLY = 0.025
"""Time by which an alarm may come before the wheel passes its peak [s]."""
ALARM = 0.9
"""P(beyond the peak) of an alarm."""
_INTERVAL = 1.96


@dataclass(frozen=True)
class Stop:
    """A stop to make."""

    parameters: CarParameters
    cycling: Cycling
    seed: int


@dataclass(frozen=True)
class StopResult:
    """What came of a stop; relative errors of the estimates that were valid at JUDGED, one for each such wheel."""

    lambda_error: Array
    lambda_inside: Array
    """Whether the 95 % interval held the truth."""
    mu_error: Array
    mu_inside: Array
    messages: int
    """Valid messages of all wheels."""
    messages_lambda_inside: int
    mu_messages: int
    """Those with a valid mu_max."""
    mu_messages_inside: int
    first_valid: float
    """First valid message of a wheel after the first passing [s]; infinite where there was none."""
    first_mu: float
    """The first with a valid mu_max."""
    passed: int
    """Wheels that passed their peak."""
    early: int
    """Wheels with an alarm more than EARLY before their passing, or without passing."""
    missed: int
    """Wheels that passed and gave no alarm."""
    alarm_delay: Array
    """From passing to the first alarm of each wheel that is neither early nor missed [s]."""
    false_beyond: float
    """Share of the samples before their peak (25 ms around excepted) with P > ALARM."""
    restarts: int


def make_stop(stop: Stop) -> StopResult:
    """Drive, estimate and sum up; a stop in which no wheel passes its peak is an error of the prescription.

    Raises:
        ValueError: no wheel passes its peak.
    """
    run = record(stop.parameters, SlipCycle(stop.parameters, stop.cycling), stop.seed)
    beyond = run.tyre_slip > run.lambda_max
    if not beyond.any():
        raise ValueError(f"no wheel passes its peak with seed {stop.seed}")
    first = float(run.time[beyond.any(axis=1).argmax()])
    samples = int(np.searchsorted(run.time, first + FOLLOWED))
    return judge(run, follow(run, min(samples, len(run.time))), first)


def judge(run: Recording, found: Answers, first: float) -> StopResult:
    """Compare answers with the truth; `first` is the time of the first passing [s]."""
    n = len(found.valid)
    time, beyond = run.time[:n], (run.tyre_slip > run.lambda_max)[:n]
    valid, known = found.valid == 1.0, found.mu_max_valid == 1.0
    lambda_error = found.lambda_max / run.lambda_max - 1.0
    mu_error = found.mu_max / run.mu_max[:n] - 1.0
    lambda_inside = np.abs(found.lambda_max - run.lambda_max) <= _INTERVAL * found.lambda_max_stddev
    mu_inside = np.abs(found.mu_max - run.mu_max[:n]) <= _INTERVAL * found.mu_max_stddev
    at = min(int(np.searchsorted(time, first + JUDGED)), n - 1)
    passings = np.where(beyond.any(axis=0), time[beyond.argmax(axis=0)], np.inf)
    alarmed = found.probability_beyond_peak > ALARM
    alarms = np.where(alarmed.any(axis=0), time[alarmed.argmax(axis=0)], np.inf)
    with np.errstate(invalid="ignore"):  # infinite where a wheel neither passes nor gives an alarm
        delay = alarms - passings
    early = delay < -EARLY
    missed = np.isfinite(passings) & np.isinf(alarms)
    near = _spread(beyond, round(EARLY / float(time[1] - time[0])))
    return StopResult(
        lambda_error=lambda_error[at, valid[at]],
        lambda_inside=lambda_inside[at, valid[at]],
        mu_error=mu_error[at, known[at]],
        mu_inside=mu_inside[at, known[at]],
        messages=int(valid.sum()),
        messages_lambda_inside=int((valid & lambda_inside).sum()),
        mu_messages=int(known.sum()),
        mu_messages_inside=int((known & mu_inside).sum()),
        first_valid=_first(time, valid) - first,
        first_mu=_first(time, known) - first,
        passed=int(np.isfinite(passings).sum()),
        early=int(early.sum()),
        missed=int(missed.sum()),
        alarm_delay=delay[np.isfinite(delay) & ~early],
        false_beyond=float(alarmed[~near].mean()),
        restarts=int(np.nansum(found.restarted)),
    )


def _first(time: Array, said: NDArray[np.bool_]) -> float:
    """Time at which a wheel first said something; infinite where none did."""
    some = said.any(axis=1)
    return float(time[some.argmax()]) if some.any() else np.inf


def _spread(beyond: NDArray[np.bool_], samples: int) -> NDArray[np.bool_]:
    """Samples within `samples` of one that is beyond the peak."""
    near = beyond.copy()
    for shift in range(1, samples + 1):
        near[shift:] |= beyond[:-shift]
        near[:-shift] |= beyond[shift:]
    return near


COVERAGE = 90.0
"""Least coverage of a 95 % interval [%]."""
VALID = 90.0
"""Least share of the stops that are valid JUDGED after the first passing [%]."""
MOST_EARLY = 1.0
"""Most early alarms [%]."""
MEDIAN = {"lambda_max": 4.0, "mu_max": 1.5}
RMSE = {"lambda_max": 12.0}
"""Largest errors over random cars [%]."""


def stop_rows(case: str, road: str, results: Sequence[StopResult], judge_errors: bool) -> list[Row]:
    """Rows of a case on a road; with `judge_errors` the errors themselves have limits too."""
    rows: list[Row] = []

    def add(quantity: str, judged: Row, **more: float) -> None:
        rows.append({"case": case, "road": road, "stops": len(results), "quantity": quantity} | judged | more)

    for name, errors, inside, all_inside, messages in (
        (
            "lambda_max",
            [result.lambda_error for result in results],
            [result.lambda_inside for result in results],
            sum(result.messages_lambda_inside for result in results),
            sum(result.messages for result in results),
        ),
        (
            "mu_max",
            [result.mu_error for result in results],
            [result.mu_inside for result in results],
            sum(result.mu_messages_inside for result in results),
            sum(result.mu_messages for result in results),
        ),
    ):
        error = 100.0 * np.concatenate(errors)
        statistics = {
            "bias_pct": _mean(error),
            "rmse_pct": _mean(error**2) ** 0.5,
            "median_pct": float(np.median(np.abs(error))) if error.size else np.nan,
            "estimates": float(error.size),
        }
        add(f"coverage of {name} [%]", at_least(100.0 * _mean(np.concatenate(inside)), COVERAGE), **statistics)
        of_messages = 100.0 * all_inside / messages if messages else np.nan
        add(f"coverage of {name}, all valid messages [%]", at_least(of_messages, COVERAGE))
        if judge_errors:
            add(f"median |error| of {name} [%]", at_most(statistics["median_pct"], MEDIAN[name]))
            if name in RMSE:
                add(f"RMSE of {name} [%]", at_most(statistics["rmse_pct"], RMSE[name]))
    mu_first = np.array([result.first_mu for result in results])
    add(f"mu_max valid within {JUDGED} s [%]", at_least(100.0 * _mean(mu_first <= JUDGED), VALID))
    first = np.array([result.first_valid for result in results])
    times = {"median_ms": 1e3 * float(np.median(first)), "p90_ms": 1e3 * _quantile(first, 0.9)}
    add(f"valid within {JUDGED} s [%]", at_least(100.0 * _mean(first <= JUDGED), VALID), **times)
    add(f"valid before {TOO_SOON} s [%]", at_most(100.0 * _mean(first < TOO_SOON), 0.0))
    wheels = 4 * len(results)
    delay = np.concatenate([result.alarm_delay for result in results])
    delays = {"median_ms": 1e3 * float(np.median(delay)), "p90_ms": 1e3 * _quantile(delay, 0.9)} if delay.size else {}
    early = 100.0 * sum(result.early for result in results) / wheels
    add("early alarms [% of wheels]", at_most(early, MOST_EARLY), **delays)
    passed = sum(result.passed for result in results)
    missed = 100.0 * sum(result.missed for result in results) / max(passed, 1)
    add("missed alarms [% of passings]", not_judged(missed))
    add("P > 0.9 before the peak [% of samples]", not_judged(100.0 * _mean([r.false_beyond for r in results])))
    add("restarts of a wheel", not_judged(_mean([result.restarts / 4.0 for result in results])))
    return rows


def _mean(values: ArrayLike) -> float:
    array = np.asarray(values, dtype=np.float64)
    return float(np.mean(array)) if array.size else np.nan


def _quantile(values: Array, share: float) -> float:
    return float(np.quantile(values, share, method="higher"))
