"""Steps in which a signal is counted."""

import numpy as np

from vehicle_doctor.drive import IMU, SPEED, WHEEL_STATES, Array, Drive, pressure_topic
from vehicle_doctor.finding import Finding, Verdict

_DISTINCT = 0.25
"""Share of different values in a signal that is not counted in steps."""
_LEAST = 200


def check(drive: Drive) -> list[Finding]:
    """Return a finding for each signal that is counted in coarse steps."""
    axis = "xyz".index(drive.vehicle.accelerometer.axis)
    columns = {WHEEL_STATES: 0, IMU: axis, SPEED: 0, **dict.fromkeys(map(pressure_topic, drive.vehicle.wheel_names), 0)}
    found = []
    for topic, column in columns.items():
        recorded = drive.topics.get(topic)
        step = np.nan if recorded is None else step_of(recorded.values[:, column])
        if recorded is None or not np.isfinite(step):
            continue
        known = recorded.values[np.isfinite(recorded.values[:, column]), column]
        low, high = np.percentile(known, [2, 98])
        share = step / max(float(high - low), 1e-12)
        # a step of a hundredth of what the signal spans is 1 % of a hard braking
        coarse = share > 0.01
        text = f"is counted in steps of {step:.3g}, 1/{1.0 / share:.0f} of what it spans"
        where = "as wheel_filter.speed_stddev of wheel_slip" if topic == WHEEL_STATES else "in the signal map"
        remedy = f"log it with more bits, or state the deviation {where}" if coarse else ""
        verdict = Verdict.WARN if coarse else Verdict.OK
        found.append(Finding("resolution", topic, verdict, text, step, remedy=remedy))
    return found


def step_of(values: Array) -> float:
    """Return the step of which all values are multiples, apart from a constant; NaN where there is none."""
    known = values[np.isfinite(values)]
    levels = np.unique(known)
    if known.size < _LEAST or levels.size < 3 or levels.size > _DISTINCT * known.size:
        return np.nan
    gaps = np.diff(levels)
    step = float(np.median(gaps[gaps > 1e-6 * np.ptp(levels)]))
    share = gaps / step
    return step if (np.abs(share - np.round(share)) < 0.05).mean() > 0.95 else np.nan
