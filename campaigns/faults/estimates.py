"""Faults inside the graph: a node that is gone, and one whose answers are invalid."""

from typing import Any

from friction_msgs.msg import FrictionSlope

from campaigns.faults.fault import Fault, Site
from campaigns.faults.signals import changed, silent

_WORST_INDICATOR = -1e5
"""[rad/s^3] Calls for a release wherever validity is not looked at."""


def lost(site: Site, name: str) -> Fault:
    """The topic `name` of every wheel does not come."""
    return silent([f"{wheel}/{name}" for wheel in site.vehicle.wheel_names])


def invalid_slope(site: Site) -> Fault:
    """The vote of the first wheel says that it does not count, beside an indicator that calls for a release."""

    def change(message: Any) -> None:
        message.reason, message.reason_text = FrictionSlope.BAD_INPUT, "injected"
        message.indicator = _WORST_INDICATOR

    return changed((f"{site.wheel}/slope_vote",), change)
