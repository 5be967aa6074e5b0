"""Faults of the accelerometer, which only wheel_slip reads."""

from typing import Any

from campaigns.faults.fault import Fault, Site
from campaigns.faults.signals import changed, silent

_TOPICS = ("imu/data",)
_BIAS = 1.0
"""[m/s^2]"""


def dead(site: Site) -> Fault:
    """Nothing comes."""
    return silent(_TOPICS)


def biased(site: Site) -> Fault:
    """It reads 1 m/s^2 too much."""

    def change(message: Any) -> None:
        message.linear_acceleration.x += _BIAS

    return changed(_TOPICS, change)


def stuck(site: Site) -> Fault:
    """It keeps the value that it had, under stamps that go on."""
    first: list[float] = []

    def change(message: Any) -> None:
        first.append(message.linear_acceleration.x)
        message.linear_acceleration.x = first[0]

    return changed(_TOPICS, change)
