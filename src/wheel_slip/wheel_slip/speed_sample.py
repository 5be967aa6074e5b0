"""A sample of the speed sensor."""

from dataclasses import dataclass


@dataclass(frozen=True)
class SpeedSample:
    """A measured vehicle speed."""

    stamp: int
    """When it was measured [ns]."""
    speed: float
    """[m/s], forward positive"""
    variance: float
    """[m^2/s^2], > 0"""
