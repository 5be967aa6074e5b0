"""Every number of a run as a signal of one's own choice, and the friction that was measured over slip."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from friction_bags.results.recorded_run import VEHICLE, WHY, Array, RecordedRun

_GRIP_MEAN = 0.2
"""Time [s] over which `grip` is a mean."""


@dataclass(frozen=True)
class Signal:
    """A number of a topic over time, as the messages hold it."""

    topic: str
    field: str
    time: Array
    """[s], shape (n,)."""
    values: Array
    """Shape (n,); NaN where there is none."""


@dataclass(frozen=True)
class Points:
    """Friction along the car that was measured, over the slip at that time. Braking is positive."""

    label: str
    about: str
    """What the points are, in words."""
    of: str
    """Wheel, or VEHICLE for an axle."""
    kind: str
    """sensor, points or truth, as of a line."""
    time: Array
    """[s], shape (n,)."""
    slip: Array
    """[-], shape (n,)."""
    mu: Array
    """[-], shape (n,)."""


def signals_of(run: RecordedRun) -> Iterator[Signal]:
    """Yield every field with a number, in the order of the topics."""
    for topic, series in sorted(run.series.items()):
        for field, values in series.columns.items():
            if field != WHY and np.any(np.isfinite(values)):
                yield Signal(topic, field, series.time, values)


def points_of(run: RecordedRun) -> Iterator[Points]:
    """Yield the friction of axles by the deceleration, of tyres by their forces, and the true one, over slip."""
    yield from _grip_points(run)
    for start, kind in (("", "points"), ("truth/", "truth")):
        for wheel in run.wheels:
            yield from _force_points(run, start, wheel, kind)


def _grip_points(run: RecordedRun) -> Iterator[Points]:
    if (grip := run.get("grip")) is None:
        return
    for part in ("front", "rear"):
        slips = [_mean_slip(run, wheel, grip.time) for wheel in run.wheels if part in wheel.split("_")]
        if known := [slip for slip in slips if slip is not None]:
            about = f"hollow squares: friction of an axle by the deceleration, mean over {_GRIP_MEAN} s"
            mu = grip[f"{part}.mu_x"]
            yield Points(f"{part} axle", about, VEHICLE, "sensor", grip.time, np.mean(known, axis=0), mu)


def _mean_slip(run: RecordedRun, wheel: str, time: Array) -> Array | None:
    """Return the mean slip of a wheel over the time of the friction that is known at `time`; NaN with gaps in it."""
    if (slip := run.get(f"{wheel}/slip")) is None:
        return None
    sums = np.concatenate([[0.0], np.cumsum(np.nan_to_num(slip["slip"] * (slip["valid"] > 0.0)))])
    counts = np.concatenate([[0], np.cumsum(np.isfinite(slip["slip"]) & (slip["valid"] > 0.0))])
    first, last = (np.searchsorted(slip.time, at, side="right") for at in (time - _GRIP_MEAN, time))
    count = counts[last] - counts[first]
    return np.where((count > 0) & (count == last - first), (sums[last] - sums[first]) / np.maximum(count, 1), np.nan)


def _force_points(run: RecordedRun, start: str, wheel: str, kind: str) -> Iterator[Points]:
    force, slip = run.get(f"{start}{wheel}/tyre_force"), run.get(f"{start}{wheel}/slip")
    if force is None or slip is None:
        return
    row = np.searchsorted(slip.time, force.time, side="right") - 1
    good = (row >= 0) & (force["valid"] > 0.0) & (slip["valid"][row] > 0.0) & (force["fz"] > 0.0)
    slips = np.where(good, slip["slip"][row], np.nan)
    mu = np.where(good, -force["fx"] / np.where(good, force["fz"], 1.0), np.nan)
    about = "full squares: Fx/Fz of the smart tyres" if kind == "points" else "small dots: true"
    label = f"{wheel}, Fx/Fz" if kind == "points" else f"{wheel}, true Fx/Fz"
    yield Points(label, about, wheel, kind, force.time, slips, mu)
