"""Delay of the speed sensor against freely rolling wheels; a sensor that is too late is excluded."""

from dataclasses import replace
from math import hypot

import numpy as np

from vehicle_doctor.checks.accelerometer import wheel_lag
from vehicle_doctor.comparison import shift, stretches
from vehicle_doctor.drive import SPEED, Drive
from vehicle_doctor.findings import Finding, Verdict, failure
from vehicle_doctor.motion import Motion, free_rims

_FLOOR = 2e-3
"""Deviation [s] that slip and inertia of the free wheels leave."""
_LATE = 0.02
"""Age [s] from which slips in a stop are wrong by a percent."""
_OLD = 0.45
"""Age [s] beyond which it is not a shift of a few samples: a logged satellite receiver, or a value that is held."""
_OLDEST = 4.0
_STEP = 0.05
"""Ages [s] up to which it is looked for, and between them."""
_LEAST = 10.0
"""Minimum duration of driving [s]."""
_EXPLAINS = 0.5
"""Share of what younger ages leave unexplained that an old one leaves at most."""


def leave_out_useless(motion: Motion) -> tuple[list[Finding], Motion]:
    """Return the finding, and the motion without the sensor, where its speeds are none or those of long ago."""
    known = motion.moving & np.isfinite(motion.measured) & np.isfinite(motion.speed)
    if known.any() and not motion.measured[known].any():
        text = "reads 0 while the wheels turn: not used here"
        finding = failure("speed", SPEED, text, "look at its sensor, and at the field in the signal map")
        return [finding], replace(motion, measured=np.full_like(motion.measured, np.nan))
    if known.sum() * motion.step < _LEAST:
        return [], motion
    wheels_known = np.isfinite(motion.speed)
    time, measured = motion.time[known], motion.measured[known]

    def unexplained(late: float) -> float:
        then = np.interp(time - late, motion.time[wheels_known], motion.speed[wheels_known])
        gain = float(then @ measured) / max(float(then @ then), 1e-12)
        return float(np.mean((measured - gain * then)[time - late >= motion.time[0]] ** 2))

    ages = np.arange(0.0, _OLDEST, _STEP)
    left = np.array([unexplained(late) for late in ages])
    age, least = float(ages[left.argmin()]), float(left.min())
    if age <= _OLD or least > _EXPLAINS * float(left[ages <= _OLD].min()):
        return [], motion
    text = f"{age:.1f} s later than the wheels: too late for comparison, not used here"
    remedy = "a sensor that is younger; held values of a slow one only in the rows in which it spoke"
    finding = Finding("skew", SPEED, Verdict.FAIL, text, 1e3 * age, unit="ms", remedy=remedy)
    return [finding], replace(motion, measured=np.full_like(motion.measured, np.nan))


def check(drive: Drive, motion: Motion) -> list[Finding]:
    """Return the finding; none without a speed sensor."""
    if not np.isfinite(motion.measured).any():
        return []
    rims = free_rims(drive, motion)
    rolls = motion.moving & ~motion.braking & np.isfinite(motion.measured) & np.isfinite(rims)
    compared = shift(motion, rims, motion.measured, stretches(motion, rolls, 2.0, 8.0))
    if compared is None or compared.late_stddev > 0.05:
        return [Finding("skew", SPEED, Verdict.NOTE, "age not determined: too little rolling at changing speed")]
    age, uncertainty = compared.late + wheel_lag(drive, motion), hypot(compared.late_stddev, _FLOOR)
    late = abs(age) > max(_LATE, 3.0 * uncertainty)
    text = f"{1e3 * abs(age):.1f} ms {'later' if age > 0.0 else 'earlier'} than the wheels"
    remedy = "'latency' in the signal map, or speed_sensor.latency of wheel_slip" if late else ""
    verdict = Verdict.WARN if late else Verdict.OK
    return [Finding("skew", SPEED, verdict, text, 1e3 * age, 1e3 * uncertainty, "ms", remedy)]
