"""A result as a page of Markdown: the whole page of a few rows, and how wide and long tables are divided."""

import re
from math import nan

import pytest

from benchmarks.markdown_page import label, page
from benchmarks.rows import Row


def tables(rows: list[Row]) -> str:
    """What stands below title, description and command."""
    return page("Title", "text", "command", rows).split("    command\n\n")[1]


def test_the_page_of_a_few_rows() -> None:
    rows: list[Row] = [
        {"surface": "dry", "method": "slip", "seeds": 500, "delay_median_ms": 78.1234, "lambda_max": 0.17},
        {"surface": "wet", "method": "slip", "seeds": 500, "delay_median_ms": nan, "lambda_max": 0.1314},
        {"surface": "all", "quantity": "|error| [%]", "limit": None},
    ]
    assert page("Results: slope", "delay of the sign", "python3 -m benchmarks slope", rows) == (
        "# Results: slope\n"
        "\n"
        "Delay of the sign.\n"
        "\n"
        "    python3 -m benchmarks slope\n"
        "\n"
        "method: slip; seeds: 500\n"
        "\n"
        "| surface | delay median [ms] | lambda_max |\n"
        "| --- | ---: | ---: |\n"
        "| dry | 78.12 | 0.17 |\n"
        "| wet | – | 0.1314 |\n"
        "\n"
        "| surface | quantity | limit |\n"
        "| --- | ---: | ---: |\n"
        "| all | \\|error\\| [%] |  |\n"
    )


def test_a_wide_table_lies_on_its_side() -> None:
    values = {f"value_{number}": number for number in range(8)}
    rows = [{"surface": name, "method": method} | values for name in ("dry", "wet") for method in ("ml", "ls")]
    lines = tables(rows).splitlines()
    assert lines[0] == "| surface, method | dry, ml | dry, ls | wet, ml | wet, ls |"
    assert lines[-1] == "| value 7 | 7 | 7 | 7 | 7 |"
    assert len(lines) == 2 + len(values)


def test_a_wide_and_long_table_is_divided_by_the_column_that_takes_the_fewest_values() -> None:
    values = dict.fromkeys((f"value_{number}" for number in range(8)), 1.5)
    rows: list[Row] = [
        {"surface": name, "method": method, "samples": count} | values
        for name in ("dry", "wet", "snow")
        for method in ("ml", "rml", "ls", "rls")
        for count in (40, 100)
    ]
    text = tables(rows)
    assert re.findall("^#.*", text, re.MULTILINE) == [
        heading
        for count in (40, 100)
        for heading in (f"## samples: {count}", "### surface: dry", "### surface: wet", "### surface: snow")
    ]
    assert text.count("| method | ml | rml | ls | rls |") == 6


def test_a_long_table_is_divided_too() -> None:
    rows = [{"axle": axle, "quantity": f"q {k}", "value": k} for axle in ("front", "rear") for k in range(20)]
    assert re.findall("^#.*|^.*quantity.*", tables(rows), re.MULTILINE) == [
        "## axle: front",
        "| quantity | value |",
        "## axle: rear",
        "| quantity | value |",
    ]


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("distance_m", "distance [m]"),
        ("mu_max_bias_pct", "mu_max bias [%]"),
        ("seconds", "time [s]"),
        ("largest_memory_mb", "largest memory [MB]"),
        ("speed_rms", "speed rms [m/s]"),
        ("kept_10pct_from", "kept 10 % from"),
        ("theta_1", "theta_1"),
    ],
)
def test_names_of_columns_are_words_with_the_unit_behind(name: str, words: str) -> None:
    assert label(name) == words


def test_without_rows_there_is_no_table() -> None:
    assert page("Title", "text", "command", []) == "# Title\n\nText.\n\n    command\n"
