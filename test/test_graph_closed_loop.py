"""Plant, estimators and supervisor as real processes in a closed loop over DDS."""

from __future__ import annotations

import pytest

from friction_bags.bag_io.cdr import encode
from friction_bringup import graph
from friction_evaluation.live import part as live
from friction_evaluation.live.graph import run_graph

PLANT: dict[str, graph.ParameterValue] = {
    "surfaces": ["dry", "wet"],
    "surface_distances": [0.0, 12.0],
    "start_stamp": 1_000_000_000,
    "demand_start": 0.2,
    "end_time": 1.5,
    "lock_step": True,
    "lock_step_timeout": 60.0,
    "real_time_factor": 0.0,
}


def closed_loop() -> dict[str, list[bytes]]:
    overrides: dict[str, dict[str, graph.ParameterValue]] = {graph.PLANT: PLANT}
    overrides |= {node: {"vehicle_file": graph.DEMO_VEHICLE} for node in live.LOOP}
    overrides[graph.SUPERVISOR] |= {"shadow": False, "stale_after": 5.0}
    found = run_graph(live.LOOP, live.CHAIN, overrides, 300.0, lambda _: None)
    return {topic: [encode(message) for message in observed.messages] for topic, observed in found.items()}


def test_a_closed_loop_in_lock_step_repeats_bit_for_bit() -> None:
    first, second = closed_loop(), closed_loop()
    for topic in live.CHAIN:
        assert len(first[topic]) == 301, topic
        assert first[topic] == second[topic], topic


@pytest.mark.parametrize("surface", ["cobblestone"])
def test_what_runs_live_is_what_the_processors_give_offline_bit_for_bit(surface: str) -> None:
    rows = live.agreement_rows(surface, seed=3)
    assert {row["topic"] for row in rows} == set(live.CHAIN)
    for row in rows:
        assert row["samples"] > 300, row
        assert row["received"] == row["samples"], row
        assert row["differing"] == 0, row
