"""Reasons why an estimate may not be used, the same list for all packages."""

from collections.abc import Mapping
from enum import IntEnum
from typing import Final


class Reason(IntEnum):
    """Reason of an estimate; names, values and meanings are those of friction_msgs/Validity."""

    OK = 0
    NOT_READY = 1
    BAD_INPUT = 2
    GAP = 3
    UNCERTAIN = 4
    LOW_SPEED = 5
    SPEED_RANGE = 6
    NOT_CALIBRATED = 7
    OUT_OF_RANGE = 8
    NO_WHEEL_SPEED = 20
    NO_PRESSURE = 21
    NO_DEMAND = 22
    NO_ACCELERATION = 23
    NO_SPEED = 24
    NO_SLIP = 25
    NO_SLOPE = 26
    INVALID_SLOPE = 27
    NO_PATCH = 28
    NOT_BRAKING = 40
    NO_EXCITATION = 41
    NOT_LASTING = 42
    PEAK_NOT_PASSED = 43
    NO_PEAK = 44
    UNKNOWN_CAR = 45
    NOTHING_LEARNED = 46
    WHEEL_SENSOR = 60
    PRESSURE_MISMATCH = 61
    SATURATED = 62
    NO_FRONTS = 63
    MISSED_TOOTH = 64
    REVERSAL = 65


_TOPIC: Final = "check that its topic is published, with stamps of the same clock"
_TEETH: Final = "drive on: the teeth are recognised again within some revolutions"
REMEDIES: Final[Mapping[Reason, str]] = {
    Reason.NOT_READY: "wait; for a curve keep braking",
    Reason.BAD_INPUT: "run vehicle_doctor; correct unit, sign or topic in the signal map",
    Reason.GAP: "find the cause of lost samples; the estimate starts again by itself",
    Reason.UNCERTAIN: "brake through the peak on one road; if it stays, run vehicle_doctor and take its vehicle file",
    Reason.LOW_SPEED: "wait for more speed",
    Reason.SPEED_RANGE: "drive within the speed range of the parameter file",
    Reason.NOT_CALIBRATED: "give calibration_file",
    Reason.OUT_OF_RANGE: "calibrate with loads and forces that include those of the drive",
    Reason.NO_WHEEL_SPEED: f"{_TOPIC}, and names this wheel's joint",
    Reason.NO_PRESSURE: _TOPIC,
    Reason.NO_DEMAND: _TOPIC,
    Reason.NO_ACCELERATION: _TOPIC,
    Reason.NO_SPEED: f"{_TOPIC}; without a speed sensor let the wheels roll first",
    Reason.NO_SLIP: "start wheel_slip, and see its own reason",
    Reason.NO_SLOPE: "start friction_slope",
    Reason.INVALID_SLOPE: "see the reason of slope_vote",
    Reason.NO_PATCH: "see the reason of contact_patch",
    Reason.NOT_BRAKING: "brake",
    Reason.NO_EXCITATION: "change the brake force: a constant slip shows no slope",
    Reason.NOT_LASTING: "wait for the delay of the sign",
    Reason.PEAK_NOT_PASSED: "brake harder, until the slip of a wheel exceeds lambda_max; with ABS wait",
    Reason.NO_PEAK: "brake through the peak; on a road without a peak in (0, 1) nothing helps",
    Reason.UNKNOWN_CAR: "use method car, or a vehicle file without deviations",
    Reason.NOTHING_LEARNED: "brake a few times",
    Reason.WHEEL_SENSOR: "check the sensor and wiring of this wheel; run vehicle_doctor",
    Reason.PRESSURE_MISMATCH: "check brake, valve and pressure sensor of this wheel",
    Reason.SATURATED: "use an accelerometer with a wider range",
    Reason.NO_FRONTS: "check mounting and filter of the in-tyre accelerometer",
    Reason.MISSED_TOOTH: _TEETH,
    Reason.REVERSAL: _TEETH,
}
"""What a user can do about each reason, or wait for."""
