import argparse

import numpy as np
import pytest

from benchmarks.slope_position import part
from benchmarks.slope_position.loop import loop_cases
from benchmarks.slope_position.stops import CASES, Stop


def stop(sign: float) -> Stop:
    """Two wheels that pass their peak at once, of which the same is told all the time."""
    time = np.linspace(0.0, 0.995, 200)
    beyond = np.zeros((200, 2), dtype=np.bool_)
    beyond[100:150] = True
    told = np.full((200, 2), sign)
    return Stop(time, beyond, np.ones(200, dtype=np.bool_), told, told)


def test_signs_are_counted_where_they_are_right_and_where_they_are_not() -> None:
    rows = {row["sign"]: row for row in part.case_rows(CASES["dry"], [stop(-1.0)])}
    assert rows["beyond the peak"]["told [% of samples]"] == pytest.approx(100.0)
    assert rows["beyond the peak"]["value"] == pytest.approx(25.0)
    assert rows["beyond the peak"]["delay, median [ms]"] == pytest.approx(0.0)
    assert not rows["beyond the peak"]["passed"]
    assert rows["stable"]["told [% of samples]"] == 0.0
    assert rows["stable"]["passed"], "where nothing is told nothing is wrong"


def test_the_part_makes_its_stops_in_and_out_of_the_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(part, "LAWS", ("curve",))
    monkeypatch.setattr(part, "ROADS", ("dry",))
    parser = argparse.ArgumentParser()
    part.add_arguments(parser)
    arguments = ["--seeds", "1", "--cases", "wet", "--drives", "0", "--loops", "1"]
    rows = part.run(parser.parse_args(arguments))
    front, rear = loop_cases("curve", "dry")
    assert [row["case"] for row in rows] == [name for name in ("wet", front.name, rear.name) for _ in range(2)]
    assert all(row["passed"] for row in rows)
