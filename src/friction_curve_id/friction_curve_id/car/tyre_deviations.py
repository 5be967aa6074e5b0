"""Tyre tolerance: deviation of a single tyre from the common curve."""

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.car.car_model import Motion

Array = NDArray[np.float64]

LAMBDA_MAX = 0.05
"""Relative deviation of lambda_max of a tyre from both formulas.

A brush model whose friction falls with its sliding has a kink at its peak: both formulas put that 10 % too high.
"""
_MU_MAX = 0.03
"""Relative deviation of mu_max of a tyre from that of the others: wear, inflation, temperature, make."""
_LOAD_SENSITIVITY = 0.1
"""Share of its friction that a tyre loses with twice its load at rest; of published tyres (p_Dx2 of the magic formula,
Pacejka, Tire and Vehicle Dynamics) 0.03 to 0.15."""


def mu_max_deviations(moved: Motion) -> Array:
    """Relative deviations of mu_max of each wheel by what its tyre has of its own, shape (W,).

    One wheel alone has the curve that is told. The load counts where it was furthest from that at rest.
    """
    wheels = moved.load.shape[0]
    if wheels == 1:
        return np.zeros(1)
    transferred = moved.load_by_height / (moved.load - moved.load_by_height)
    deviations: Array = np.hypot(_MU_MAX, _LOAD_SENSITIVITY * np.abs(transferred).max(axis=1))
    return deviations
