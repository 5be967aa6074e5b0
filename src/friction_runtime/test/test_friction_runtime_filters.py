"""Debounce, low-pass and sliding windows, each against its definition over a whole history."""

from __future__ import annotations

from math import exp

import pytest
from hypothesis import given
from hypothesis import strategies as st

from friction_runtime.filters import Debounce, SlidingMaximum, SlidingWindow, first_order_gain

STEPS = st.lists(st.tuples(st.integers(1, 5), st.integers(-9, 9)), min_size=1, max_size=40)


def samples(steps: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Times that grow by the steps, and their values."""
    time, made = 0, []
    for step, value in steps:
        time += step
        made.append((time, value))
    return made


@given(STEPS)
def test_a_condition_counts_once_it_has_held_for_the_whole_duration(steps: list[tuple[int, int]]) -> None:
    debounce, begun = Debounce(7), None
    for time, value in samples(steps):
        begun = None if value < 0 else time if begun is None else begun
        assert debounce.update(time, value >= 0) == (begun is not None and time - begun >= 7)
        assert debounce.elapsed(time) == (0 if begun is None else time - begun)


def test_a_reset_debounce_begins_again() -> None:
    debounce = Debounce(1.0)
    debounce.update(0.0, True)
    debounce.reset()
    assert not debounce.update(1.0, True)
    assert debounce.update(2.0, True)


def test_a_step_through_the_low_pass_is_the_exponential_whatever_the_sample_times() -> None:
    value, time = 1.0, 0.0
    for dt in (0.01, 0.2, 0.005, 0.7):
        time += dt
        value += first_order_gain(dt, 0.5) * (3.0 - value)
        assert value == pytest.approx(3.0 - 2.0 * exp(-time / 0.5), rel=1e-12)


@given(STEPS)
def test_windows_hold_what_is_no_older_than_their_horizon(steps: list[tuple[int, int]]) -> None:
    window, largest = SlidingWindow[int](6), SlidingMaximum(6)
    history = samples(steps)
    for count, (time, value) in enumerate(history, 1):
        window.append(time, value)
        expected = [(then, each) for then, each in history[:count] if then >= time - 6]
        assert list(window) == expected
        assert len(window) == len(expected)
        assert largest.update(time, value) == max(each for _, each in expected)


def test_cleared_windows_are_empty() -> None:
    window, largest = SlidingWindow[float](10.0), SlidingMaximum(10.0)
    window.append(0.0, 5.0)
    largest.update(0.0, 5.0)
    window.clear()
    largest.clear()
    assert list(window) == []
    assert largest.update(1.0, 2.0) == 2.0
