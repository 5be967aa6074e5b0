"""Why a contact patch or a force may not be used; values as in friction_msgs/ContactPatch and TyreForce."""

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
