"""Reasons for an invalid contact patch or force, in words."""

from vehicle_models.reason import Reason

PATCH_TEXTS = {
    Reason.OK: "",
    Reason.NOT_READY: "no zero yet: waiting for a stretch of constant low speed",
    Reason.SPEED_RANGE: "speed outside the range of the method",
    Reason.GAP: "packets lost: wheel angle unknown until the teeth are recognised again",
    Reason.SATURATED: "accelerometer saturated",
    Reason.NO_FRONTS: "no twin spike found",
    Reason.MISSED_TOOTH: "missed tooth: wheel angle unknown until the teeth are recognised again",
    Reason.REVERSAL: "standstill or reversal: wheel angle unknown until the teeth are recognised again",
    Reason.BAD_INPUT: "signal not finite",
    Reason.NOT_CALIBRATED: "not calibrated: length and shift are raw",
}
FORCE_TEXTS = {
    Reason.OK: "",
    Reason.NO_PATCH: "no valid contact patch",
    Reason.NOT_CALIBRATED: "not calibrated",
    Reason.OUT_OF_RANGE: "outside the range of the calibration",
}
