"""Tables 8.4 and 8.5: their manoeuvre has the chapter's numbers of samples, and either speed gives the same peak."""

import pytest

from benchmarks.protocol import CORNER
from benchmarks.slip.stops import shipped
from book.chapter_numbers import ERRORS_ON_ROADS
from book.speed import numbers
from book.speed_tables import ACTIVATION_SLIP, LAMBDA_INIT, ROADS, Road, braking, tables


@pytest.mark.parametrize("road", ROADS, ids=lambda road: road.name)
def test_manoeuvre_takes_the_chapters_samples_from_init_to_activation(road: Road) -> None:
    truth = braking(road)
    slips = 1.0 - truth.wheel_speed * CORNER.radius / truth.speed
    assert slips[truth.begin - 1] <= LAMBDA_INIT < slips[truth.begin]
    assert slips[truth.begin + road.activation] == pytest.approx(ACTIVATION_SLIP, abs=1e-3)


def test_tables_with_estimated_speed_are_as_good_as_with_measured_speed() -> None:
    rows = tables(range(1), shipped())
    ends = [row for row in rows if row["start"] == "all" and row["instant"] == "end"]
    pairs = list(zip(ends[::2], ends[1::2], strict=True))
    assert {(one["speed"], other["speed"]) for one, other in pairs} == {("measured", "estimated")}
    for measured, estimated in pairs:
        assert measured["failures"] == estimated["failures"] == 0
        assert estimated["bias_percent"] == pytest.approx(measured["bias_percent"], abs=1.0)


def test_each_error_of_tables_8_4_and_8_5_stands_beside_ours() -> None:
    found = numbers(tables(range(2), shipped()))
    assert sorted(row["chapter"] for row in found) == sorted(e for errors in ERRORS_ON_ROADS.values() for e in errors)
