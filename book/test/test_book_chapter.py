"""Tables 8.1 to 8.3 and Figures 8.5 to 8.8 hold what the chapter's hold."""

from pathlib import Path

import pytest

from benchmarks.runner import Row
from book.identification import by_number, figures, kept_rows, numbers
from book.tables import READINGS, chapter_tables, readings
from vehicle_models.surfaces import TABLE_8_1


@pytest.fixture(scope="module")
def table() -> dict[tuple[str, str], Row]:
    rows = chapter_tables(8)
    return {(str(row["method"]), str(row["quantity"])): row for row in rows}


@pytest.fixture(scope="module")
def read() -> list[Row]:
    return readings(2)


KEPT = [
    {"manoeuvre": manoeuvre, "method": method, "surface": road, "kept_10pct_from": 50.0, "kept_5pct_from": 60.0}
    for manoeuvre in "BC"
    for method in ("rml", "rls")
    for road in TABLE_8_1
]


def test_every_number_of_tables_8_2_and_8_3_stands_beside_ours(read: list[Row]) -> None:
    found = {row["quantity"]: row for row in numbers(read, kept_rows(KEPT))}
    assert len(found) == 12 + 3
    error = "|error| of lambda_max by rml on snow [%]"
    (ours,) = (row for row in read if (row["method"], row["surface"]) == ("rml", "snow") and "ours" in row["reading"])
    assert (found[error]["chapter"], found[error]["5 %"]) == (1.81, ours["p5_pct"])
    assert found["rls within 5 % on cobblestone, from sample"]["ours (median)"] == 60.0


def test_each_reading_stands_beside_the_number_and_is_named_where_its_runs_hold_it(read: list[Row]) -> None:
    wide = "C, dead reckoning"
    rows = by_number([row | ({"p5_pct": 0.0, "p95_pct": 100.0} if row["reading"] == wide else {}) for row in read])
    assert len(rows) == 16
    assert all(wide in row["given by"] and set(READINGS) <= set(row) for row in rows)


def test_recursive_ml_in_covariance_form_keeps_theta_2_near_its_start(table: dict[tuple[str, str], Row]) -> None:
    for surface in TABLE_8_1:
        assert table["rml_covariance", "theta_2 moved from its start [%]"][surface] < 2.0
        assert table["rml", "theta_2 moved from its start [%]"][surface] > 5.0
    # The fit itself is one: where the slip is near the peak it is right.
    assert table["rml_covariance", "mu_max"]["dry"] == pytest.approx(1.17, rel=0.03)


def test_the_errors_printed_for_the_chapter_follow_from_its_own_peaks(table: dict[tuple[str, str], Row]) -> None:
    for method in ("ml", "rml", "ls"):
        for surface in TABLE_8_1:
            truth = table["true values", "lambda_max"][surface]
            peak = table[method, "lambda_max"][f"{surface}_chapter"]
            error = table[method, "median |error| of lambda_max [%]"][f"{surface}_chapter"]
            assert abs(peak / truth - 1.0) * 100.0 == pytest.approx(error, abs=0.15)


@pytest.mark.parametrize("surface", ["dry", "wet", "cobblestone"])
def test_medians_lie_by_the_true_values(table: dict[tuple[str, str], Row], surface: str) -> None:
    for method in ("ml", "rml", "rml_ml", "ls", "rls"):
        assert table[method, "lambda_max"][surface] == pytest.approx(
            table["true values", "lambda_max"][surface], rel=0.06
        )
        assert table[method, "mu_max"][surface] == pytest.approx(table["true values", "mu_max"][surface], rel=0.02)
        assert table[method, "failures"][surface] == 0


def test_rls_equals_ls_from_its_first_estimate_on(table: dict[tuple[str, str], Row]) -> None:
    for surface in TABLE_8_1:
        assert table["rls", "largest |RLS - LS| of lambda_max"][surface] < 1e-6
        assert table["rls", "sample from which RLS equals LS"][surface] == 21.0


def test_a_figure_is_drawn_for_every_method_and_surface(tmp_path: Path) -> None:
    methods = ["rls", "ml"]
    rows = figures(tmp_path, methods)
    assert len(rows) == len(methods) * len(TABLE_8_1)
    for row in rows:
        assert Path(str(row["figure"])).stat().st_size > 10_000
