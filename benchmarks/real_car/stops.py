"""Stops through the peak: the answers beside the truth, summed up per stop."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.real_car.answers import Answers, follow
from corner_sim.car.car_parameters import CarParameters
from corner_sim.car.pressure_prescription import Cycling, SlipCycle
from corner_sim.car.recording import Recording, record

Array = NDArray[np.float64]
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
    method: str


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
    messages_mu_inside: int
    first_valid: float
    """First valid message of a wheel after the first passing [s]; infinite where there was none."""
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
    return judge(run, follow(stop.method, run, min(samples, len(run.time))), first)


def judge(run: Recording, found: Answers, first: float) -> StopResult:
    """Compare answers with the truth; `first` is the time of the first passing [s]."""
    n = len(found.valid)
    time, beyond = run.time[:n], (run.tyre_slip > run.lambda_max)[:n]
    valid = found.valid == 1.0
    lambda_error = found.lambda_max / run.lambda_max - 1.0
    mu_error = found.mu_max / run.mu_max[:n] - 1.0
    lambda_inside = np.abs(found.lambda_max - run.lambda_max) <= _INTERVAL * found.lambda_max_stddev
    mu_inside = np.abs(found.mu_max - run.mu_max[:n]) <= _INTERVAL * found.mu_max_stddev
    at = min(int(np.searchsorted(time, first + JUDGED)), n - 1)
    some = valid.any(axis=1)
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
        mu_error=mu_error[at, valid[at]],
        mu_inside=mu_inside[at, valid[at]],
        messages=int(valid.sum()),
        messages_lambda_inside=int((valid & lambda_inside).sum()),
        messages_mu_inside=int((valid & mu_inside).sum()),
        first_valid=float(time[some.argmax()]) - first if some.any() else np.inf,
        passed=int(np.isfinite(passings).sum()),
        early=int(early.sum()),
        missed=int(missed.sum()),
        alarm_delay=delay[np.isfinite(delay) & ~early],
        false_beyond=float(alarmed[~near].mean()),
        restarts=int(np.nansum(found.restarted)),
    )


def _spread(beyond: NDArray[np.bool_], samples: int) -> NDArray[np.bool_]:
    """Samples within `samples` of one that is beyond the peak."""
    near = beyond.copy()
    for shift in range(1, samples + 1):
        near[shift:] |= beyond[:-shift]
        near[:-shift] |= beyond[shift:]
    return near
