"""The step that the plants share: second order, stable however stiff; bad starts are refused."""

from math import inf, nan

import numpy as np
import pytest

from corner_sim.corner import GAMMA, Pair, check_start, inner_steps, two_stages


def decayed(rate: float, steps: int) -> float:
    """Wheel speed after 1 s of omega_dot = -rate omega from 1 rad/s; the body stands."""
    h = 1.0 / steps

    def derivative(v: np.ndarray, w: np.ndarray) -> Pair:
        return 0.0 * v, -rate * w

    def solve(b_v: np.ndarray, b_w: np.ndarray) -> Pair:
        return b_v, b_w / (1.0 + GAMMA * h * rate)

    state = np.zeros(1), np.ones(1)
    for _ in range(steps):
        state = two_stages(state, derivative(*state), np.zeros(1), h, solve, derivative)
    return float(state[1][0])


def test_error_falls_with_the_square_of_the_step() -> None:
    coarse, fine = (abs(decayed(1.0, steps) - np.exp(-1.0)) for steps in (20, 40))
    assert coarse / fine == pytest.approx(4.0, rel=0.1)


def test_a_step_far_longer_than_the_time_constant_decays() -> None:
    assert abs(decayed(1e6, 3)) < 1e-3


@pytest.mark.parametrize(("dt", "steps"), [(1e-4, 1), (1e-3, 1), (5e-3, 5), (5.1e-3, 6)])
def test_inner_steps_are_equal_and_no_longer_than_allowed(dt: float, steps: int) -> None:
    assert inner_steps(dt, 1e-3) == (steps, dt / steps)


@pytest.mark.parametrize("bad", [(-1.0, 0.0, 1e-3), (1.0, nan, 1e-3), (1.0, -inf, 1e-3), (1.0, 1.0, 0.0)])
def test_a_bad_start_is_refused(bad: tuple[float, float, float]) -> None:
    with pytest.raises(ValueError, match="must be"):
        check_start(np.array([bad[0]]), np.array([bad[1]]), bad[2])
