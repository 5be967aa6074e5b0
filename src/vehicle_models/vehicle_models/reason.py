"""Reasons why an estimate may not be used, the same list for all packages."""

from enum import IntEnum


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
