"""Reasons for an invalid contact patch or force, in words."""

from vehicle_models.reason import Reason

PATCH_TEXTS = {
    Reason.OK: "",
    Reason.NOT_READY: "no zero yet: waiting for a stretch of constant low speed",
    Reason.SPEED_RANGE: "waiting for a speed within the range of the method",
    Reason.GAP: "packets lost: wheel angle unknown until the teeth are recognised again",
    Reason.SATURATED: "accelerometer saturated: use one with a wider range",
    Reason.NO_FRONTS: "waiting for both edges of the contact patch in the acceleration",
    Reason.MISSED_TOOTH: "missed tooth: wheel angle unknown until the teeth are recognised again",
    Reason.REVERSAL: "standstill or reversal: wheel angle unknown until the teeth are recognised again",
    Reason.BAD_INPUT: "signal not finite",
    Reason.NOT_CALIBRATED: "not calibrated: give calibration_file; length and shift are raw",
}
FORCE_TEXTS = {
    Reason.OK: "",
    Reason.NO_PATCH: "waiting for a valid contact patch",
    Reason.NOT_CALIBRATED: "not calibrated: give calibration_file",
    Reason.OUT_OF_RANGE: "outside the calibrated range: calibrate with larger forces",
}
