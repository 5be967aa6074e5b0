"""Burckhardt parameters of the roads of the chapter.

dry, wet, cobblestone and snow are the true values of Table 8.1. high_grip and off_road stand for the test roads of
Tables 8.4 and 8.5, of which the chapter gives only lambda_max (0.1 and 0.13).
"""

from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from vehicle_models import burckhardt

SURFACES: MappingProxyType[str, NDArray[np.float64]] = MappingProxyType(
    {
        "dry": np.array([1.28, 23.99, 0.52]),
        "wet": np.array([0.86, 33.82, 0.35]),
        "cobblestone": np.array([1.37, 6.46, 0.67]),
        "snow": np.array([0.19, 94.13, 0.06]),
        "high_grip": np.array([1.2, 47.9, 0.48]),
        "off_road": np.array([0.55, 34.2, 0.22]),
    }
)
TABLE_8_1 = ("dry", "wet", "cobblestone", "snow")


def surface(name: str) -> NDArray[np.float64]:
    """Return theta, shape (3,), of the road `name`: one of SURFACES, or three numbers such as "1.28,24,0.52".

    Raises:
        ValueError: the name is neither, or the numbers have no peak at a slip in (0, 1).
    """
    if name in SURFACES:
        return SURFACES[name].copy()
    try:
        theta = np.array([float(number) for number in name.split(",")])
        peaked = theta.shape == (3,) and bool(0.0 < burckhardt.peak(theta)[0] < 1.0)
    except ValueError:
        raise ValueError(f"unknown surface '{name}': one of {', '.join(SURFACES)}, or theta as 1.28,24,0.52") from None
    if not peaked:
        raise ValueError(f"surface '{name}': theta_1,theta_2,theta_3 with a peak at a slip in (0, 1) are needed")
    return theta
