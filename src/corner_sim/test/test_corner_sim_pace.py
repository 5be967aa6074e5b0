"""The schedule of samples."""

from hypothesis import given
from hypothesis import strategies as st

from corner_sim.ros.node import Pace


@given(st.lists(st.floats(0.0, 0.004), min_size=100, max_size=400), st.sampled_from([0.5, 1.0, 4.0]))
def test_a_jittery_timer_keeps_the_mean_rate(jitter: list[float], factor: float) -> None:
    period = 0.005 / factor
    pace = Pace(factor, 0.0)
    samples = 0
    for k, late in enumerate(jitter):
        now = k * period + late / factor
        while pace.due(now):
            pace.taken(now)
            samples += 1
    assert abs(samples - len(jitter)) <= 1


def test_after_a_stall_every_sample_follows_and_the_late_ones_are_counted() -> None:
    pace = Pace(1.0, 0.0)
    pace.taken(0.0)
    taken = 1
    while pace.due(0.1):
        pace.taken(0.1)
        taken += 1
    assert taken == 21
    assert pace.overruns == 18  # those of 5, 10, ..., 90 ms
    assert pace.worst_lateness == 0.1 - 0.005
    assert pace.shifted == 0.0


def test_a_stall_longer_than_the_queues_hold_shifts_the_schedule_and_says_by_how_much() -> None:
    pace = Pace(1.0, 0.0)
    pace.taken(0.0)
    taken = 0
    while pace.due(2.0):
        pace.taken(2.0)
        taken += 1
    assert taken == 1
    assert pace.shifted == 2.0 - 0.005
    assert not pace.due(2.002)
    assert pace.due(2.005)


def test_factor_zero_is_always_due() -> None:
    pace = Pace(0.0, 0.0)
    for _ in range(1000):
        assert pace.due(0.0)
        pace.taken(0.0)
    assert pace.overruns == 0
