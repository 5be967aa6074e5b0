"""All checks of a drive, in their order: what later checks need is put right by earlier ones."""

from vehicle_doctor.checks import (
    accelerometer,
    brakes,
    estimators,
    exchanged,
    radii,
    resolution,
    speed_sensor,
    teeth,
    topics,
    units,
    wheel_signals,
)
from vehicle_doctor.drive import Drive
from vehicle_doctor.finding import Finding, Verdict
from vehicle_doctor.motion import motion_of


def examine(drive: Drive, road: str = accelerometer.UNKNOWN) -> list[Finding]:
    """Return what all checks say of a drive; `road` is one of accelerometer.ROADS."""
    findings = topics.check(drive)
    motion = motion_of(drive)
    if motion is None or not motion.moving.any():
        text = "cannot be judged: the car does not move" if motion else "cannot be judged: there are no wheel speeds"
        return [*findings, Finding("motion", "car", Verdict.NOTE, text), *estimators.check(drive)]
    found, motion = wheel_signals.check(drive, motion)
    findings += found
    found, motion = speed_sensor.leave_out_old(motion)
    findings += found
    found, motion = units.check(drive, motion)
    findings += found
    findings += [*exchanged.check(drive, motion), *teeth.check(drive, motion)]
    found, motion = radii.check(drive, motion)
    findings += found
    findings += speed_sensor.check(drive, motion)
    found, compared = accelerometer.check(drive, motion, road)
    findings += found
    findings += brakes.check(drive, motion, compared)
    return [*findings, *resolution.check(drive), *estimators.check(drive)]


def exit_code(findings: list[Finding]) -> int:
    """Return 1 where something is a WARN or a FAIL, else 0."""
    return int(any(each.verdict in (Verdict.WARN, Verdict.FAIL) for each in findings))
