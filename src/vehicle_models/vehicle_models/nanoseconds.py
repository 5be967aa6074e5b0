"""The unit of stamps. Estimators use integer nanoseconds only: exact, ordered, and without ROS."""

from typing import Final

NANOSECONDS: Final = 1_000_000_000
"""Nanoseconds in a second."""
NANOSECOND: Final = 1e-9
"""A nanosecond in seconds [s]. The product with it and the quotient by NANOSECONDS differ in the last bit."""
