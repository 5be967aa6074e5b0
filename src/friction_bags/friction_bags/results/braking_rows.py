"""Each braking of a drive with the friction that was used and identified in it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import hypot, nan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_bags.results.brakings import NO_CURVES, Array, all_brakings, decelerations, last_known
from friction_bags.results.recorded_run import VEHICLE, WHY, RecordedRun, Series
from friction_runtime.reports import INTERVAL_95, plain_reason

CAR = "car"
"""Name of the part that holds what all wheels have in common."""
_CURVE = ("lambda_max", "lambda_max_stddev", "mu_max", "mu_max_stddev")
SLIP_COUNTS_ABOVE = 5.0
"""Speed [m/s] above which slips count for the largest one: below it, every wheel that stops locks."""


@dataclass(frozen=True)
class Part:
    """Friction of the car, an axle or some wheels in one braking. NaN where it is not known."""

    of: str
    """CAR, or the axle or the wheels that differ from the rest."""
    mu_used: float = nan
    """Largest friction used [-], mean over 0.2 s."""
    mu_used_stddev: float = nan
    lambda_max: float = nan
    """Slip at the peak [-] of the most certain valid curve."""
    lambda_max_stddev: float = nan
    mu_max: float = nan
    """Friction at the peak [-] of the same curve; known alone where no curve was valid, but the friction was."""
    mu_max_stddev: float = nan
    valid: float = nan
    """Share of the curves that were valid [-]; NaN where there were none."""
    valid_at: float = nan
    """Time of that curve [s]."""
    reason: str = ""
    """Most frequent reason, where no curve was valid."""
    true_lambda_max: float = nan
    """At `valid_at`, else at the end of the braking [-]; NaN for a measured drive."""
    true_mu_max: float = nan


@dataclass(frozen=True)
class BrakingRow:
    """One braking. SI units."""

    start: float
    end: float
    from_speed: float
    to_speed: float
    mean_deceleration: float
    """Between 10 and 90 % of the loss of speed: fully developed [m/s^2]."""
    largest_deceleration: float
    """Over 0.1 s [m/s^2]."""
    largest_slip: float
    """Largest valid slip of any wheel above 5 m/s [-]; NaN where none was valid."""
    slip_of: str
    """Wheel with the largest slip."""
    parts: tuple[Part, ...]
    """The car first; then axles and wheels that differ."""


@dataclass(frozen=True)
class Fit:
    """Friction curves of a wheel or the vehicle over time."""

    label: str
    of: str
    """Wheel or VEHICLE."""
    topic: str
    curve: Series


def fits_of(run: RecordedRun, start: str) -> list[Fit]:
    """Return the friction curves of topics that begin with `start`.

    Wheels that all have the same peak are a single one, with the widest intervals.
    """
    fits = _all_fits(run, start)
    wheels = [fit for fit in fits if fit.of != VEHICLE]
    if len(wheels) > 1 and all(_same(wheels[0].curve, fit.curve) for fit in wheels[1:]):
        widest = {name: np.fmax.reduce([fit.curve[name] for fit in wheels]) for name in _CURVE if "stddev" in name}
        curve = replace(wheels[0].curve, columns={**wheels[0].curve.columns, **widest})
        return [Fit("all wheels", VEHICLE, wheels[0].topic, curve), *fits[len(wheels) :]]
    return fits


def main_reason(series: Series, of: str, inside: NDArray[np.bool_]) -> str:
    """Return the most frequent reason among the messages inside, else among all; empty where all were valid.

    Args:
        series: messages with a validity.
        of: wheel or vehicle that the reason need not name.
        inside: which messages count, shape (n,).
    """
    codes = series[WHY].astype(np.int64)
    given = codes[inside & (codes > 0)] if np.any(inside & (codes > 0)) else codes[codes > 0]
    return plain_reason(list(series.reasons)[int(np.bincount(given).argmax()) - 1], of) if given.size else ""


def most_certain(curve: Series, start: float, end: float) -> int | None:
    """Return the index of the most certain peak of a braking: the valid one with the smallest deviation of lambda_max.

    It is the last valid one where the method has no deviation, and where no curve is valid the last with a mu_max; None
    where there is neither. Wheels with one curve have one such time.
    """
    inside = (curve.time >= start) & (curve.time < end)
    valid = np.flatnonzero(inside & (curve["valid"] > 0.0))
    if valid.size:
        stddev = np.nan_to_num(curve["lambda_max_stddev"][valid], nan=np.inf)
        return int(valid[::-1][np.argmin(stddev[::-1])])
    known = np.flatnonzero(inside & np.isfinite(curve["mu_max"]))
    return int(known[-1]) if known.size else None


def vehicle_speed(run: RecordedRun) -> tuple[Array, Array] | None:
    """Return time [s] and speed [m/s] of the vehicle: as estimated, else as measured, else true; None where unknown."""
    for wheel in run.wheels:
        if (slip := run.get(f"{wheel}/slip")) is not None and np.any(np.isfinite(slip["vehicle_speed"])):
            return slip.time, slip["vehicle_speed"]
    for topic in ("vehicle_velocity", "truth/vehicle_velocity"):
        if (velocity := run.get(topic)) is not None:
            return velocity.time, velocity["twist.twist.linear.x"]
    return None


def braking_rows(run: RecordedRun) -> list[BrakingRow]:
    """Return every braking of a run, by the speed of vehicle_speed, in the order of time."""
    if (speed := vehicle_speed(run)) is None:
        return []
    rows = []
    at, mean, deceleration = decelerations(*speed)
    until, left = last_known(*speed)
    fits = _all_fits(run, "")
    learned = np.concatenate([NO_CURVES, *(fit.curve.time[fit.curve["valid"] > 0.0] for fit in fits)])
    for start, end in all_brakings(*speed, learned):
        before, after = map(float, np.interp((start, end), np.append(at, until), np.append(mean, left)))
        inside = (at >= start) & (at <= end)
        falling = -np.minimum.accumulate(mean[inside])
        developed = np.interp([-0.9 * before - 0.1 * after, -0.1 * before - 0.9 * after], falling, at[inside])
        mean_and_most = 0.8 * (before - after) / float(np.diff(developed)[0]), float(np.max(deceleration[inside]))
        parts = _parts(run, start, end)
        rows.append(BrakingRow(start, end, before, after, *mean_and_most, *_largest_slip(run, start, end), parts))
    return rows


def _all_fits(run: RecordedRun, start: str) -> list[Fit]:
    topics = {of: f"{start}{of}/friction_curve" for of in (*run.wheels, VEHICLE)}
    return [Fit(of, of, topic, curve) for of, topic in topics.items() if (curve := run.get(topic)) is not None]


def _same(one: Series, other: Series) -> bool:
    """Whether the peaks of two friction curves, where valid, are equal at all times."""
    if not np.array_equal(one.time, other.time) or not np.array_equal(one["valid"], other["valid"]):
        return False
    valid = one["valid"] > 0.0
    names = (name for name in _CURVE if "stddev" not in name)
    return all(np.array_equal(one[name][valid], other[name][valid], equal_nan=True) for name in names)


def _largest_slip(run: RecordedRun, start: float, end: float) -> tuple[float, str]:
    found = [(np.nan, "")]
    for wheel in run.wheels:
        if (slip := run.get(f"{wheel}/slip")) is not None:
            inside = slice(*np.searchsorted(slip.time, (start, end), side="left"))
            counts = (slip["valid"][inside] > 0.0) & (slip["vehicle_speed"][inside] > SLIP_COUNTS_ABOVE)
            values = slip["slip"][inside][counts]
            found += [(float(np.max(values)), wheel)] if values.size else []
    return max(found[1:], default=found[0])


def _parts(run: RecordedRun, start: float, end: float) -> tuple[Part, ...]:
    """Return the friction of the car, then of axles and wheels that differ; those alike have the widest interval."""
    alike: dict[str, list[Part]] = {}
    for fit in _all_fits(run, ""):
        if (part := _curve_part(run, fit, start, end)) is not None:
            numbers = (part.lambda_max, part.mu_max, part.valid, part.true_lambda_max, part.true_mu_max)
            alike.setdefault(f"{part.reason} {' '.join(f'{each:.3f}' for each in numbers)}", []).append(part)
    by_name = {CAR: Part(CAR)}
    for parts in alike.values():
        name = CAR if len(alike) == 1 else _common_name([part.of for part in parts], run.wheels)
        widest = {each: max(getattr(part, each) for part in parts) for each in ("lambda_max_stddev", "mu_max_stddev")}
        by_name[name] = replace(parts[0], of=name, **widest)
    for name, (used, stddev) in _grips(run, start, end).items():
        by_name[name] = replace(by_name.get(name, Part(name)), mu_used=used, mu_used_stddev=stddev)
    return tuple(by_name.values())


def _curve_part(run: RecordedRun, fit: Fit, start: float, end: float) -> Part | None:
    """Return the friction curve of wheels in one braking; None where there is no message of it."""
    braked = (fit.curve.time >= start) & (fit.curve.time < end)
    if not braked.any():
        return None
    best = most_certain(fit.curve, start, end)
    at = end if best is None else float(fit.curve.time[best])
    valid = float(np.mean(fit.curve["valid"][braked] > 0.0))
    part = Part(fit.label, valid=valid)
    if (true := run.get(f"truth/{fit.topic}")) is not None:
        lambda_max, mu_max = (float(np.interp(at, true.time, true[name])) for name in ("lambda_max", "mu_max"))
        part = replace(part, true_lambda_max=lambda_max, true_mu_max=mu_max)
    if valid == 0.0:
        part = replace(part, reason=main_reason(fit.curve, fit.topic.rpartition("/")[0], braked))
    if best is None:
        return part
    names = _CURVE if valid > 0.0 else _CURVE[2:]
    peak: dict[str, Any] = {name: float(fit.curve[name][best]) for name in names}
    return replace(part, **peak, valid_at=at)


def _grips(run: RecordedRun, start: float, end: float) -> dict[str, tuple[float, float]]:
    """Return the largest friction used in a braking, with its deviation: of the car, and of axles that differ."""
    if (grip := run.get("grip")) is None:
        return {}
    inside = slice(*np.searchsorted(grip.time, (start, end), side="left"))
    found = {}
    for name in (VEHICLE, "front", "rear"):
        used = grip[f"{name}.mu_used"][inside]
        if np.any(used > 0.0):
            row = int(np.nanargmax(used))
            found[CAR if name == VEHICLE else name] = (
                float(used[row]),
                float(grip[f"{name}.mu_used_stddev"][inside][row]),
            )
    front, rear = found.get("front"), found.get("rear")
    if front and rear and abs(front[0] - rear[0]) > INTERVAL_95 * hypot(front[1], rear[1]):
        return found
    return {CAR: found[CAR]} if CAR in found else {}


def _common_name(wheels: list[str], all_wheels: tuple[str, ...]) -> str:
    """Return the word that the names of these wheels share and no other has, such as front; else the names."""
    words = set.intersection(*(set(wheel.split("_")) for wheel in wheels))
    for word in sorted(words):
        if sum(word in wheel.split("_") for wheel in all_wheels) == len(wheels) > 1:
            return word
    return ", ".join(wheels)
