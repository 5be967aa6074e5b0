"""Tables 8.1 to 8.3 and Figures 8.5 to 8.8 hold what the chapter's hold."""

import argparse
from pathlib import Path

import pytest

from friction_evaluation.identification.chapter_tables import chapter_tables
from friction_evaluation.identification.figures import figures
from friction_evaluation.rows import Row
from vehicle_models.surfaces import TABLE_8_1


@pytest.fixture(scope="module")
def table() -> dict[tuple[str, str], Row]:
    rows = chapter_tables(argparse.Namespace(manoeuvre="B", source="dead_reckoned", seeds=8))
    return {(str(row["method"]), str(row["quantity"])): row for row in rows}


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
    methods = ["rls", "default"]
    rows = figures(argparse.Namespace(manoeuvre="B", source="dead_reckoned", methods=methods, figures=tmp_path))
    assert len(rows) == len(methods) * len(TABLE_8_1)
    for row in rows:
        assert Path(str(row["figure"])).stat().st_size > 10_000
