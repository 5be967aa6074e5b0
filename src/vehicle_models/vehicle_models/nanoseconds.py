"""The unit of stamps. Estimators know no other time than integer nanoseconds: exact, ordered, and without ROS."""

from typing import Final

NANOSECONDS: Final = 1_000_000_000
"""Nanoseconds in a second."""
NANOSECOND: Final = 1e-9
"""[s] The product with it differs in the last bit from the quotient by NANOSECONDS."""
