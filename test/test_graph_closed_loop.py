"""Plant, estimators and supervisor as real processes in a closed loop over DDS."""

from __future__ import annotations

from campaigns.live import part as live


def test_what_runs_live_is_what_the_processors_give_offline_bit_for_bit() -> None:
    rows = live.agreement_rows("cobblestone", seed=3)
    assert {row["topic"] for row in rows} == set(live.CHAIN)
    for row in rows:
        assert row["samples"] > 300, row
        assert row["received"] == row["samples"], row
        assert row["passed"], row
