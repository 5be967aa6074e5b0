"""Burckhardt friction curve, equation (2.13): mu(slip) = th1 (1 - exp(-th2 slip)) - th3 slip.

`theta` has shape (..., 3) and holds (th1, th2, th3), all dimensionless and positive for a real tyre. `slip` broadcasts
against the leading dimensions of `theta`. The curve is odd: in traction (slip < 0) friction is minus that of -slip.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def _parts(theta: ArrayLike, slip: ArrayLike) -> tuple[Array, Array, Array, Array]:
    curve = np.asarray(theta, dtype=np.float64)
    if curve.shape[-1:] != (3,):
        raise ValueError(f"theta has shape {curve.shape}, its last dimension must be 3")
    return curve[..., 0], curve[..., 1], curve[..., 2], np.asarray(slip, dtype=np.float64)


def friction(theta: ArrayLike, slip: ArrayLike) -> Array:
    """Friction coefficient mu [-] at `slip` [-], equation (2.13).

    Raises:
        ValueError: the last dimension of theta is not 3.
    """
    th1, th2, th3, slip = _parts(theta, slip)
    magnitude = np.abs(slip)
    return np.asarray(np.sign(slip) * (-th1 * np.expm1(-th2 * magnitude) - th3 * magnitude))


def slope(theta: ArrayLike, slip: ArrayLike) -> Array:
    """Slope mu_1 = d mu / d slip [-] at `slip` [-], equation (2.37).

    Raises:
        ValueError: the last dimension of theta is not 3.
    """
    th1, th2, th3, slip = _parts(theta, slip)
    return np.asarray(th1 * th2 * np.exp(-th2 * np.abs(slip)) - th3)


def gradient(theta: ArrayLike, slip: ArrayLike) -> Array:
    """Gradient of mu with respect to theta, the xi of (8.10), shape (..., 3).

    Raises:
        ValueError: the last dimension of theta is not 3.
    """
    th1, th2, _, slip = _parts(theta, slip)
    magnitude = np.abs(slip)
    decay = np.exp(-th2 * magnitude)
    columns = np.broadcast_arrays(1.0 - decay, th1 * magnitude * decay, -magnitude)
    return np.asarray(np.sign(slip)[..., np.newaxis] * np.stack(columns, axis=-1))


def peak_exponent(theta: ArrayLike) -> Array:
    """Decay th2 lambda_max = ln(th1 th2 / th3) at the peak [-], from slope = 0.

    NaN where the curve has no maximum at a positive slip (a theta that is not positive, or th1 th2 <= th3).

    Raises:
        ValueError: the last dimension of theta is not 3.
    """
    th1, th2, th3, _ = _parts(theta, 0.0)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ratio = th1 * th2 / th3
        exists = (th1 > 0.0) & (th2 > 0.0) & (th3 > 0.0) & (ratio > 1.0) & np.isfinite(ratio)
        return np.where(exists, np.log(np.where(exists, ratio, 1.0)), np.nan)


def friction_at_peak(theta: Array, exponent: ArrayLike) -> Array:
    """mu_max = th1 - (th3 / th2)(1 + th2 lambda_max) [-], `exponent` being th2 lambda_max."""
    return np.asarray(theta[..., 0] - theta[..., 2] / theta[..., 1] * (1.0 + np.asarray(exponent)))


def peak(theta: ArrayLike) -> tuple[Array, Array]:
    """Peak of the curve, (lambda_max, mu_max), both [-].

    Both are NaN where the curve has no maximum at a positive slip (see `peak_exponent`).
    The peak may lie above slip 1; the caller decides whether that counts.

    Raises:
        ValueError: the last dimension of theta is not 3.
    """
    curve, exponent = np.asarray(theta, dtype=np.float64), peak_exponent(theta)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.asarray(exponent / curve[..., 1]), friction_at_peak(curve, exponent)
