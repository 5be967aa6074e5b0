"""Parts of the dynamic drive of Figure 8.20, without the changes between them."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PHASES: Mapping[str, tuple[float, float]] = MappingProxyType(
    {
        "low speed": (6.0, 13.5),
        "acceleration": (15.0, 18.5),
        "cruise": (21.0, 41.0),
        "braking": (42.4, 43.5),
        "low speed again": (46.0, 59.0),
    }
)
"""Begin and end [s]."""
STEADY = ("low speed", "cruise", "low speed again")
"""Those of constant speed."""


def means(time: Array, values: Array) -> dict[str, float]:
    """Mean of `values` at `time` [s] in each phase, shapes (n,)."""
    return {phase: float(np.mean(values[(time > begin) & (time < end)])) for phase, (begin, end) in PHASES.items()}
