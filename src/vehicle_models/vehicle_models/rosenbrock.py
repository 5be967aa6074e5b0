"""Common integration of the plants: check of the start, sub-steps, stiff slip (Rosenbrock)."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Pair = tuple[Array, Array]
"""Something of the body and of the wheels."""

GAMMA = 1.0 - 1.0 / np.sqrt(2.0)
"""Makes the two-stage method of second order and L-stable."""


def check_start(speed: Array, wheel_speed: Array, max_step: float) -> None:
    """Refuse a state or an inner step [s] that no plant can start from.

    Raises:
        ValueError: a speed [m/s, rad/s] is negative or not finite, or max_step is not positive.
    """
    if not (np.all(speed >= 0.0) and np.all(wheel_speed >= 0.0)):
        raise ValueError("speed and wheel_speed must be finite and >= 0")
    if not max_step > 0.0:
        raise ValueError(f"max_step must be > 0, is {max_step}")


def inner_steps(dt: float, max_step: float) -> tuple[int, float]:
    """Number and length [s] of the equal inner steps, none above `max_step` [s], that make up `dt` [s]."""
    steps = max(1, int(np.ceil(dt / max_step - 1e-9)))
    return steps, dt / steps


def two_stages(
    state: Pair,
    derivative: Pair,
    time_term: Array,
    h: float,
    solve: Callable[[Array, Array], Pair],
    derivative_at_end: Callable[[Array, Array], Pair],
) -> Pair:
    """State after a step of the Rosenbrock method with GAMMA, before what stands or is locked is held at rest.

    Args:
        state: speed [m/s] and wheel speeds [rad/s].
        derivative: of the state [m/s^2, rad/s^2].
        time_term: GAMMA h times the derivative of the wheel accelerations by time [rad/s^2].
        h: length of the step [s].
        solve: of the linear system of a stage, for a right-hand side of body and wheels.
        derivative_at_end: of a state at the end of the step, as `derivative`; takes no wheel speed below 0.
    """
    v, w = state
    f_v, f_w = derivative
    k1_v, k1_w = solve(f_v, f_w + time_term)
    f_v, f_w = derivative_at_end(v + h * k1_v, np.maximum(w + h * k1_w, 0.0))
    k2_v, k2_w = solve(f_v - 2.0 * k1_v, f_w - 2.0 * k1_w - time_term)
    return v + h * (1.5 * k1_v + 0.5 * k2_v), w + h * (1.5 * k1_w + 0.5 * k2_w)
