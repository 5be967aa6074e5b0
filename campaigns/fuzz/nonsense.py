"""Bounds that a valid estimate of a car on a road must keep."""

from __future__ import annotations

from math import inf, isinf, isnan, pi
from typing import Any

from vehicle_models.physical_bounds import HIGHEST_SPEED, HIGHEST_WHEEL_SPEED

_WITHIN = {
    "WheelSlip": {
        "slip": (-1.5, 1.5),
        "slip_rate": (-inf, inf),
        "vehicle_speed": (-HIGHEST_SPEED, HIGHEST_SPEED),
        "wheel_speed": (-HIGHEST_WHEEL_SPEED, HIGHEST_WHEEL_SPEED),
        "slip_variance": (0.0, 1.0),
    },
    "FrictionSlope": {"sign": (-1, 1), "indicator": (-inf, inf)},
    "FrictionCurve": {"lambda_max": (0.0, 1.0), "mu_max": (0.0, 2.5)},
    "ContactPatch": {"length": (0.0, pi), "shift": (-pi, pi)},
    "TyreForce": {"fx": (-1e5, 1e5), "fz": (-1e4, 1e5)},
}
"""Fields of a valid message, with what they lie within; an infinite or missing value never does."""
_ALWAYS = {
    "FrictionSlope": {"slip_at_crossing": (-1.5, 1.5)},
    "FrictionCurve": {"probability_beyond_peak": (0.0, 1.0), "lambda_max": (0.0, 1.0)},
}
"""Fields that are NaN or lie within, valid or not."""


def nonsense(message: Any) -> str:
    """Return what is impossible in the answer of a processor, empty where all may be."""
    kind = type(message).__name__
    if getattr(message, "valid", False):
        for name, (low, high) in _WITHIN.get(kind, {}).items():
            value = getattr(message, name)
            if isnan(value) or isinf(value) or not low <= value <= high:
                return f"{kind}: valid with {name} = {value}"
    for name, (low, high) in _ALWAYS.get(kind, {}).items():
        value = getattr(message, name)
        if not isnan(value) and not low <= value <= high:
            return f"{kind}: {name} = {value}"
    return ""
