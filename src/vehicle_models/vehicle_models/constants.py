"""Constants of nature, as the chapter and its cars use them."""

from typing import Final

GRAVITY: Final = 9.81
"""Acceleration of free fall [m/s^2]."""
AIR_DENSITY: Final = 1.2
"""[kg/m^3]"""
