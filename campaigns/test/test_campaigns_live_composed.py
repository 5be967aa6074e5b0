"""Rows of the comparison of separate nodes and one process, from runs made by hand."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest
from friction_msgs.msg import BrakeCommand, WheelSlip
from sensor_msgs.msg import JointState

from campaigns.live.composed import judged_rows, over_relays, run_row
from campaigns.live.recorded_run import Answers, Measured
from campaigns.live.relay import Relay
from friction_runtime.messages import header_at

MILLISECOND = 1_000_000


def measured(delays: list[float | None]) -> Measured:
    """A run of two cars whose slips come so late [ms] or not at all."""
    sent = {k * 5 * MILLISECOND: 10**15 + k for k in range(len(delays))}
    slips = {
        stamp: at + round(delay * MILLISECOND)
        for (stamp, at), delay in zip(sent.items(), delays, strict=True)
        if delay is not None
    }
    answers = {"/a/wheel_states": Answers(sent), "/b/wheel_states": Answers(dict(sent))}
    answers |= {"/a/front_left/slip": Answers(slips), "/b/front_left/slip": Answers(dict(slips))}
    return Measured({"awheel_slip": 0.1, "bwheel_slip": 0.2, "abs_supervisor": 0.5, "player": 0.9}, answers)


def test_a_row_counts_the_estimators_alone_and_what_is_missing_of_each_car() -> None:
    row = run_row(measured([1.0, None, 2.0, 3.0]), ["slip"])
    assert row["cpu_percent"] == pytest.approx(30.0)
    assert row["supervisor_percent"] == pytest.approx(50.0)
    assert (row["samples"], row["slip_lost"]) == (8, 2)
    assert row["slip_median_ms"] == pytest.approx(2.0)
    assert row["slip_max_ms"] == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("composed", "relays", "late", "lost", "passed"),
    [
        (54.0, 10.0, 6.9, 0, [True, True, True]),
        (80.0, 62.0, 6.9, 0, [True, True, True]),
        (56.0, 43.0, 7.1, 1, [False, False, False]),
    ],
)
def test_either_ratio_of_processor_time_is_enough_but_late_or_lost_answers_are_not(
    composed: float, relays: float, late: float, lost: int, passed: list[bool]
) -> None:
    cpu = {"separate": 100.0, "composed": composed, "relays": relays}
    delays = {"separate": 10.0, "composed": late, "relays": 1.0}
    found = {
        form: [{"cpu_percent": cpu[form], "brake_command_p99_ms": delays[form], "slip_lost": lost}] * 3 for form in cpu
    }
    assert [row["passed"] for row in judged_rows(found) if row["passed"] is not None] == passed


@pytest.mark.parametrize(("nodes", "passed"), [(6.0, True), (6.1, False)])
def test_the_delay_of_nodes_is_judged_by_that_of_relays(nodes: float, passed: bool) -> None:
    assert over_relays(nodes, 2.0)["passed"] is passed


class _Hop:
    """Where a node stands in the chain."""

    sensors: Mapping[str, type] = {"wheel_states": JointState}
    optional = ()
    outputs: Mapping[str, type] = {"front_left/answer": BrakeCommand}

    def __init__(self, *estimates: str) -> None:
        self.estimates = dict.fromkeys((f"front_left/{each}" for each in estimates), WheelSlip)


@pytest.mark.parametrize(
    ("estimates", "fires_on"),
    [((), "wheel_states"), (("slip",), "front_left/slip"), (("slip", "slope_vote"), "front_left/slope_vote")],
)
def test_a_relay_answers_once_to_what_its_node_waits_for(estimates: tuple[str, ...], fires_on: str) -> None:
    hop: Any = _Hop(*estimates)
    relay = Relay(hop)
    message = JointState(header=header_at(7 * 10**9, ""))
    chain = ("wheel_states", "front_left/slip", "front_left/slope_vote")
    answered = {topic: list(relay.process(topic, message)) for topic in chain[: len(estimates) + 1]}
    assert [topic for topic, answers in answered.items() if answers] == [fires_on]
    ((_, answer),) = answered[fires_on]
    assert answer.header.stamp.sec == 7
