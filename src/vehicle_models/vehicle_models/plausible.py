"""Limits of plausibility: what is beyond is garbage, not a measurement of a car on a road. Every node uses them."""

from vehicle_models.nanoseconds import NANOSECONDS

HIGHEST_WHEEL_SPEED = 1000.0
"""[rad/s]"""
HIGHEST_SPEED = 200.0
"""Of a car [m/s]."""
HIGHEST_ACCELERATION = 200.0
"""Of a car, by an accelerometer on a body that kerbs shake [m/s^2]."""
HIGHEST_TORQUE = 1e5
"""Of a brake [N m]."""
HIGHEST_PRESSURE = 1e9
"""Of a brake line [Pa]."""
LATEST_STAMP = (2**31 - 2) * NANOSECONDS
"""[ns] A message stamp holds a second more."""
