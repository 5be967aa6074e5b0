"""All checks of a drive, in their order: each corrects the motion for those that follow."""

import numpy as np

from vehicle_doctor.checks import accelerometer, brakes, curves, radii, recording, speed_sensor, units, wheels
from vehicle_doctor.drive import Drive
from vehicle_doctor.findings import Finding, Verdict
from vehicle_doctor.motion import ROLLS, motion_of

_STANDS = 0.1
"""Speed of the fastest moment of a car that does not move [m/s]."""


def examine(drive: Drive, road: str = accelerometer.UNKNOWN) -> list[Finding]:
    """Return the findings of all checks; `road` is one of accelerometer.ROADS."""
    findings = recording.check_topics(drive)
    found, drive = recording.leave_out_codes(drive)
    findings += found
    motion = motion_of(drive)
    if motion is None:
        text = "cannot be judged: there are no wheel speeds"
        return [*findings, Finding("motion", "car", Verdict.NOTE, text), *recording.check_estimator_inputs(drive)]
    found, motion = wheels.check_signals(drive, motion)
    findings += found
    if not motion.moving.any():
        top = float(np.nanmax(np.nan_to_num(motion.speed)))
        slow = f"the car is never faster than {top:.1f} m/s, and {ROLLS:.0f} m/s are needed"
        text = f"cannot be judged: {slow if top > _STANDS else 'the car does not move'}"
        return [*findings, Finding("motion", "car", Verdict.NOTE, text), *recording.check_estimator_inputs(drive)]
    found, motion = speed_sensor.leave_out_useless(motion)
    findings += found
    found, motion = units.check(drive, motion)
    findings += found
    findings += [*wheels.check_exchanged(drive, motion), *wheels.check_missing_teeth(drive, motion)]
    found, motion = curves.straighten(drive, motion)
    findings += found
    found, motion = radii.check(drive, motion)
    findings += found
    findings += speed_sensor.check(drive, motion)
    found, compared = accelerometer.check(drive, motion, road)
    findings += found
    findings += brakes.check(drive, motion, compared)
    return [*findings, *recording.check_quantization(drive), *recording.check_estimator_inputs(drive)]


def exit_code(findings: list[Finding]) -> int:
    """Return 1 where something is a WARN or a FAIL, else 0."""
    return int(any(each.verdict in (Verdict.WARN, Verdict.FAIL) for each in findings))
