"""Age of the speed sensor beside the wheels that roll freely."""

from math import hypot

import numpy as np

from friction_bringup.doctor.checks.accelerometer import wheel_lag
from friction_bringup.doctor.drive import SPEED, Drive
from friction_bringup.doctor.finding import Finding, Verdict
from friction_bringup.doctor.motion import Motion, free_rims
from friction_bringup.doctor.shift import shift, stretches

_FLOOR = 2e-3
"""Deviation [s] that slip and inertia of the free wheels leave."""
_LATE = 0.02
"""Age [s] from which slips in a stop are wrong by a percent."""


def check(drive: Drive, motion: Motion) -> list[Finding]:
    """Return the finding; none without a speed sensor."""
    if not np.isfinite(motion.measured).any():
        return []
    rims = free_rims(drive, motion)
    rolls = motion.moving & ~motion.braking & np.isfinite(motion.measured) & np.isfinite(rims)
    compared = shift(motion, rims, motion.measured, stretches(motion, rolls, 2.0, 8.0))
    if compared is None or compared.late_stddev > 0.05:
        return [Finding("skew", SPEED, Verdict.NOTE, "age cannot be told: too little rolling at changing speed")]
    age, doubt = compared.late + wheel_lag(drive, motion), hypot(compared.late_stddev, _FLOOR)
    late = abs(age) > max(_LATE, 3.0 * doubt)
    text = f"{1e3 * abs(age):.1f} ms {'later' if age > 0.0 else 'earlier'} than the wheels"
    remedy = "'latency' in the signal map, or speed_sensor.latency of wheel_slip" if late else ""
    verdict = Verdict.WARN if late else Verdict.OK
    return [Finding("skew", SPEED, verdict, text, 1e3 * age, 1e3 * doubt, "ms", remedy)]
