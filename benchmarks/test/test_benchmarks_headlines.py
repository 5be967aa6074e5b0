"""Headline numbers: the committed ones are those of README.md and of today's code, and a wrong one fails."""

from pathlib import Path

import pytest

from benchmarks import headlines, results
from benchmarks.headlines import Headline, Number, compared, load
from benchmarks.runner import failures, rows_of

README = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
ABS = Headline(
    "abs", "abs --seeds 2", [Number("dry", {"surface": "dry"}, "utilisation", 0.9, 0.01)], where={"seeds": 2}
)


@pytest.mark.parametrize("headline", load(), ids=lambda headline: headline.name)
def test_readme_shows_the_committed_numbers(headline: Headline) -> None:
    assert headline.line() in README.splitlines(), "python3 -m benchmarks headlines --table"


@pytest.mark.parametrize("headline", [each for each in load() if each.quick], ids=lambda headline: headline.name)
def test_todays_code_gives_the_committed_numbers(headline: Headline) -> None:
    rows = rows_of("benchmarks", *headline.quick.split())
    assert failures(list(compared(headline, rows, quick=True))) == []


@pytest.mark.parametrize(("today", "passed"), [(0.909, True), (0.889, False), (float("nan"), False)])
def test_a_number_that_is_missed_by_more_than_its_noise_fails(today: float, passed: bool) -> None:
    rows = [{"surface": "dry", "seeds": 2, "utilisation": today}, {"surface": "wet", "seeds": 2, "utilisation": 0.5}]
    (row,) = compared(ABS, rows)
    assert row["passed"] is passed


def test_a_number_that_no_row_gives_or_two_give_is_refused() -> None:
    row = {"surface": "dry", "seeds": 2, "utilisation": 0.9}
    for rows in ([], [row, row], [row | {"seeds": 3}]):
        with pytest.raises(ValueError, match="dry"):
            list(compared(ABS, rows))


def test_the_noise_is_smaller_than_the_number() -> None:
    numbers = [number for headline in load() for number in headline.numbers]
    assert all(0.0 < number.noise < 0.3 * abs(number.value) for number in numbers)
    assert headlines.FILE.name in (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")


def test_the_page_of_results_has_a_row_for_each_limit() -> None:
    rows = [
        {"quantity": "RMS", "value": 0.02, "limit": 0.08, "passed": True},
        {"quantity": "RMS", "value": 0.09, "limit": 0.08, "passed": False},
        {"surface": "dry", "value": 1.0, "limit": None, "passed": None},
    ]
    (row,) = results.limits("slip", rows)
    assert (row["values"], row["limits"], row["failed"]) == ("0.02 to 0.09", "0.08", 1)
    assert "| slip | RMS | 2 | 0.02 to 0.09 | 0.08 | 1 |" in results.page([row])
    with pytest.raises(ValueError, match="make bench"):
        results.page([])
