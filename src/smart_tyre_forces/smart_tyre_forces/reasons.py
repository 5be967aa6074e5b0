"""Reasons for an invalid contact patch or force; values as in friction_msgs/ContactPatch and TyreForce."""

from enum import IntEnum


class PatchReason(IntEnum):
    """Why a contact patch may not be used."""

    OK = 0
    NOT_READY = 1
    SPEED_RANGE = 2
    LOST_PACKETS = 3
    SATURATED = 4
    NO_FRONTS = 5
    MISSED_TOOTH = 6
    REVERSAL = 7
    BAD_INPUT = 8
    NOT_CALIBRATED = 9


class ForceReason(IntEnum):
    """Why a force may not be used."""

    OK = 0
    NO_PATCH = 1
    NOT_CALIBRATED = 2
    OUT_OF_RANGE = 3


PATCH_TEXTS = {
    PatchReason.OK: "",
    PatchReason.NOT_READY: "no zero yet: waiting for a stretch of constant low speed",
    PatchReason.SPEED_RANGE: "speed outside the range of the method",
    PatchReason.LOST_PACKETS: "packets lost: wheel angle unknown until the teeth are recognised again",
    PatchReason.SATURATED: "accelerometer saturated",
    PatchReason.NO_FRONTS: "no twin spike found",
    PatchReason.MISSED_TOOTH: "missed tooth: wheel angle unknown until the teeth are recognised again",
    PatchReason.REVERSAL: "standstill or reversal: wheel angle unknown until the teeth are recognised again",
    PatchReason.BAD_INPUT: "signal not finite",
    PatchReason.NOT_CALIBRATED: "not calibrated: length and shift are raw",
}
FORCE_TEXTS = {
    ForceReason.OK: "",
    ForceReason.NO_PATCH: "no valid contact patch",
    ForceReason.NOT_CALIBRATED: "not calibrated",
    ForceReason.OUT_OF_RANGE: "outside the range of the calibration",
}
