"""Loss of an input by its stamps against the clock: what is lost, within which time, and when it is back."""

from collections.abc import Callable, Iterable
from math import inf
from random import Random

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from friction_runtime.stamp_progress import LAG, StampProgress

MS = 1_000_000
START = 10_000_000 * MS
POLL = 0.01
BOOT = 4321.0
"""Reading of the steady clock [s] when the stamps begin."""
Message = tuple[float, int]
"""Time of arrival by a clock that starts with the test [s], and stamp [ns]."""


def sent(period: float, until: float, stamp: Callable[[float], float] = lambda t: t) -> list[Message]:
    """Messages whose stamps are `stamp` of the time they arrive at."""
    count = round(until / period)
    return [(k * period, START + round(stamp(k * period) * 1e9)) for k in range(count)]


def lost_times(messages: Iterable[Message], until: float, phase: float = 0.03) -> list[tuple[float, bool]]:
    """Return (time, lost) of each change, after the start has been passed."""
    progress = StampProgress()
    left = sorted(messages)
    arrived = -inf
    changes = [(0.0, True)]
    for k in range(1, round(until / POLL)):
        now = (k + phase) * POLL
        while left and left[0][0] <= now:
            arrived, stamp = left.pop(0)
            progress.note(stamp)
        lost = progress.poll(BOOT + now, now - arrived)
        if lost is not changes[-1][1]:
            changes.append((now, lost))
    return changes[1:]


def test_an_input_is_there_once_its_stamps_have_progressed_with_the_clock() -> None:
    ((since, lost),) = lost_times(sent(0.005, 2.0), 2.0)
    assert not lost
    assert since == pytest.approx(0.21, abs=0.011)
    assert lost_times([], 1.0) == []


@pytest.mark.parametrize("phase", [0.03, 0.25, 0.5, 0.75, 0.97])
@pytest.mark.parametrize("period", [0.005, 0.01, 0.02, 0.05])
def test_silence_is_a_loss_within_50_ms_and_the_period(period: float, phase: float) -> None:
    last = max(at for at, _ in sent(period, 2.0))
    _, (at, lost) = lost_times(sent(period, 2.0), 3.0, phase)
    assert lost
    assert period < at - last < 0.05 + period


@pytest.mark.parametrize("fault", ["repeats", "zero", "back by 50 ms", "back by 10 s"])
def test_stamps_that_stand_still_are_zero_or_go_back_are_a_loss_within_50_ms_and_the_period(fault: str) -> None:
    good = sent(0.005, 2.0)
    last = good[-1]
    if fault.startswith("back"):
        by = 50 * MS if fault == "back by 50 ms" else 10_000 * MS
        bad = [(at, stamp - by) for at, stamp in sent(0.005, 2.2) if at > last[0]]
    else:
        bad = [(2.0 + 0.005 * k, last[1] if fault == "repeats" else 0) for k in range(200)]
    changes = lost_times(good + bad, 2.2)
    assert changes[1][1]
    assert changes[1][0] - last[0] < 0.055


@pytest.mark.parametrize("rate", [0.0, 0.2, 0.5, 0.9])
def test_stamps_that_crawl_are_lost_when_they_lag_and_never_come_back(rate: float) -> None:
    crawl = sent(0.005, 8.0, lambda t: t if t < 2.0 else 2.0 + rate * (t - 2.0))
    _, (at, lost) = lost_times(crawl, 8.0)
    assert lost
    assert at - 2.0 < 0.045 / (1.0 - rate) + POLL


def test_a_single_late_stamp_is_no_loss_and_49_ms_is_no_new_run() -> None:
    late = [(0.005 * k + 0.001, START + round(0.005 * k * 1e9) - 49 * MS) for k in range(20, 400, 3)]
    assert [lost for _, lost in lost_times(sent(0.005, 2.0) + late, 2.0)] == [False]


@pytest.mark.parametrize("seconds", [-3600.0, -1.0, 1.0, 3600.0])
def test_a_clock_that_is_set_is_a_short_loss(seconds: float) -> None:
    changes = lost_times(sent(0.005, 6.0, lambda t: t if t < 3.0 else t + seconds), 6.0)
    assert [lost for _, lost in changes] == [False, True, False]
    assert changes[2][0] - changes[1][0] < 0.6


@pytest.mark.parametrize("drift", [-1e-4, 1e-4])
def test_clocks_that_drift_are_no_loss(drift: float) -> None:
    messages = sent(0.01, 1000.0, lambda t: t * (1.0 + drift))
    assert [lost for _, lost in lost_times(messages, 1000.0)] == [False]


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10**6), st.sampled_from([0.005, 0.02, 0.05]))
@example(6419, 0.05)  # the samples after the first 0.2 s came late
def test_jitter_of_arrival_of_15_ms_and_samples_lost_now_and_then_are_no_loss(seed: int, period: float) -> None:
    random = Random(seed)
    messages = [(at + random.uniform(0.0, 0.015), stamp) for at, stamp in sent(period, 10.0)]
    kept = [message for k, message in enumerate(messages) if k % 20 != 7 or period > 0.01]
    assert [lost for _, lost in lost_times(kept, 10.0)] == [False]


def test_after_a_stop_of_the_reader_old_stamps_are_old_and_the_input_is_back_within_a_fifth_of_a_second() -> None:
    progress = StampProgress()
    messages = sent(0.005, 6.0)
    stop, again = 2.0, 4.0
    left = list(messages)
    old: list[bool] = []
    back = None
    now, arrived = 0.0, -inf
    while now < 5.0:
        now = again if stop <= now < again else now + POLL
        lost = progress.poll(BOOT + now, now - arrived)  # a node looks at the clock before it reads what has waited
        if now >= again and not lost and back is None:
            back = now
        while left and left[0][0] <= now:
            arrived, (_, stamp) = now, left.pop(0)
            old.append(progress.is_old(stamp))
            progress.note(stamp)
    assert back is not None and back - again < 0.1
    times = [at for (at, _), is_old in zip(messages, old, strict=False) if is_old]
    assert times[0] == pytest.approx(stop + 0.005, abs=0.006)
    assert times[-1] == pytest.approx(again - LAG - 0.005, abs=0.011)
    assert len(times) == round((times[-1] - times[0]) / 0.005) + 1
