"""Tyre tolerance: deviation of a single tyre from the common curve."""

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.car.car_model import Motion
from friction_curve_id.car.combined_slip import TyreSlips

Array = NDArray[np.float64]

LAMBDA_MAX = 0.05
"""Relative deviation of lambda_max of a tyre from both formulas.

A brush model whose friction falls with its sliding has a kink at its peak: both formulas put that 10 % too high.
"""
MU_MAX = 0.03
"""Relative deviation of mu_max of a tyre from that of the others: wear, inflation, temperature, make."""
_ACROSS = 0.05
"""Relative deviation of the friction of a tyre across over that along from that of the others."""
_NEAR_PEAK = 0.9
"""Least share of its friction that a tyre uses near the peak."""
_LOAD_SENSITIVITY = 0.1
"""Share of its friction that a tyre loses with twice its load at rest; of published tyres (p_Dx2 of the magic formula,
Pacejka, Tire and Vehicle Dynamics) 0.03 to 0.15."""


def mu_max_deviations(moved: Motion, tyres: TyreSlips) -> Array:
    """Relative deviations of mu_max of each wheel by what its tyre has of its own, shape (W,).

    One wheel alone has the curve that is told. The load counts where it was furthest from that at rest, friction across
    by the share of the squared force that it has near the peak.
    """
    if moved.load.shape[0] == 1:
        return np.zeros(1)
    deviations: Array = np.hypot(MU_MAX, _LOAD_SENSITIVITY * np.abs(_transferred(moved)).max(axis=1))
    if tyres.across is None:
        return deviations
    near = tyres.curve.value > _NEAR_PEAK
    across = ((tyres.across / tyres.size) ** 2 * near).sum(axis=1) / np.maximum(near.sum(axis=1), 1)
    return np.hypot(deviations, _ACROSS * across)


def side_deviations(moved: Motion) -> Array:
    """Deviations of the friction of each wheel by its tyre and by its load, see difference_by_tyres, shape (2, W)."""
    by_load = _LOAD_SENSITIVITY * _transferred(moved).mean(axis=1)
    return np.stack([np.full_like(by_load, MU_MAX), by_load])


def _transferred(moved: Motion) -> Array:
    return np.asarray(moved.load_by_height / (moved.load - moved.load_by_height))
