"""Messages of the two detectors of a wheel."""

from typing import Any

from friction_msgs.msg import FrictionSlope, SlopeVote

from friction_runtime.messages import from_nanoseconds, header_at, validity
from friction_slope.estimate import SlopeEstimate


def estimate_message(wheel: str, stamp: int, estimate: SlopeEstimate) -> FrictionSlope:
    """Return the estimate of a wheel at a stamp [ns]."""
    message = _common(FrictionSlope, wheel, stamp, estimate)
    message.method = estimate.method.value
    message.sign = estimate.sign
    message.probability_beyond_peak = estimate.probability
    message.crossings = estimate.crossings
    message.crossing_sign = estimate.crossing_sign
    message.slip_at_crossing = estimate.slip_at_crossing
    message.crossing_stamp = from_nanoseconds(estimate.crossing_stamp)
    return message


def vote_message(wheel: str, stamp: int, vote: SlopeEstimate) -> SlopeVote:
    """Return the vote of a wheel at a stamp [ns]."""
    return _common(SlopeVote, wheel, stamp, vote)


def _common(kind: type, wheel: str, stamp: int, estimate: SlopeEstimate) -> Any:
    """Return a message with the fields that estimate and vote have in common."""
    message = kind()
    message.header = header_at(stamp, wheel)
    message.wheel = wheel
    message.h = estimate.h
    message.indicator = estimate.indicator
    message.delay = estimate.delay
    message.validity = validity(wheel, estimate.reason, estimate.text)
    return message
