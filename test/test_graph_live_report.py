"""Lost samples and delays in the live evaluation, on observations made by hand."""

from __future__ import annotations

import pytest
from friction_msgs.msg import BrakeCommand
from std_msgs.msg import Header

from campaigns.live.graph import Observation
from campaigns.live.part import real_time_row
from friction_runtime.messages import from_nanoseconds

START = 1_000_000_000
PERIOD = 5_000_000
MILLISECOND = 1_000_000


def observed(samples: list[int], delays: list[float]) -> Observation:
    """Samples by number, each published so many milliseconds after its stamp."""
    messages = [BrakeCommand(header=Header(stamp=from_nanoseconds(START + k * PERIOD))) for k in samples]
    published = [START + k * PERIOD + round(ms * MILLISECOND) for k, ms in zip(samples, delays, strict=True)]
    return Observation(messages, published)


def test_delays_are_from_the_sample_to_its_answer() -> None:
    source = observed(list(range(101)), [1.0] * 101)
    answers = observed(list(range(101)), [2.0] * 60 + [4.0] * 40 + [51.0])
    row = real_time_row("front_left/brake_command", answers, source, 101, "dry")
    assert (row["samples"], row["received"], row["irregular_steps"]) == (101, 101, 0)
    assert (row["quantity"], row["value"], row["passed"]) == ("lost", 0, True)
    assert row["delay_median_ms"] == pytest.approx(1.0)
    assert row["delay_p99_ms"] == pytest.approx(3.0)
    assert row["delay_max_ms"] == pytest.approx(50.0)
    assert row["duration_s"] == pytest.approx(0.5)


def test_lost_samples_are_counted_and_a_heartbeat_neither_hides_them_nor_counts_as_a_late_answer() -> None:
    source = observed(list(range(11)), [0.0] * 11)
    answers = observed([0, 1, 2, 2, 2, 5, 6, 7, 8, 9, 10], [1.0] * 3 + [9.0, 14.0] + [1.0] * 6)
    row = real_time_row("front_left/brake_command", answers, source, 11, "dry")
    assert row["received"] == 9
    assert (row["quantity"], row["value"], row["limit"], row["passed"]) == ("lost", 2, 0, False)
    assert row["irregular_steps"] == 1
    assert row["delay_max_ms"] == pytest.approx(1.0)
