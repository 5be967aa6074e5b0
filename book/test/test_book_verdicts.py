"""A verdict follows from numbers: a wrong one turns it, and none is without place, statement, result and reason."""

from math import nan

import pytest

from book.verdicts import (
    Judgement,
    Spread,
    Verdict,
    claim,
    close,
    counts,
    not_public,
    rows,
    single_run,
)

RUNS = Spread(0.5, 5.0, 9.5)


@pytest.mark.parametrize(("number", "judgement"), [(5.0, Judgement.AGREES), (9.9, Judgement.DIFFERS)])
def test_a_single_run_agrees_only_among_the_middle_of_our_runs(number: float, judgement: Judgement) -> None:
    assert single_run("Table 8.2", "error", [number], [RUNS], "noise").judgement is judgement


def test_one_number_of_several_that_lies_outside_turns_the_verdict() -> None:
    assert single_run("Table 8.4", "errors", [5.0, 5.0], [RUNS, RUNS], "drives").judgement is Judgement.AGREES
    turned = single_run("Table 8.4", "errors", [5.0, 5.0], [RUNS, Spread(20.5, 25.0, 29.5)], "drives")
    assert (turned.judgement, turned.because) == (Judgement.DIFFERS, "drives")
    assert turned.ours == "5 (0.5 to 9.5); 25 (20.5 to 29.5)"


def test_runs_that_gave_nothing_bear_nothing_out() -> None:
    none = single_run("Table 8.2", "error", [5.0], [Spread(nan, nan, nan)], "all failed")
    assert (none.judgement, none.ours) == (Judgement.DIFFERS, "– (– to –)")


@pytest.mark.parametrize(("ours", "judgement"), [(104.0, Judgement.AGREES), (106.0, Judgement.DIFFERS)])
def test_a_number_beyond_its_tolerance_or_unknown_differs(ours: float, judgement: Judgement) -> None:
    assert close("8.2.3", "slip", 100.0, ours, 0.05, "cause").judgement is judgement
    assert close("8.2.3", "slip", 100.0, float("nan"), 0.05, "cause").judgement is Judgement.DIFFERS


def test_a_claim_is_as_its_numbers_are() -> None:
    assert claim("8.3.2", "RLS ends at LS", True, "1e-9", "cause").because == ""
    assert claim("8.3.2", "RLS ends at LS", False, "0.1", "cause").judgement is Judgement.DIFFERS


@pytest.mark.parametrize(
    "values",
    [
        ("", "statement", "1", "1", Judgement.AGREES, ""),
        ("8.2.3", "", "1", "1", Judgement.AGREES, ""),
        ("8.2.3", "statement", "1", "", Judgement.AGREES, ""),
        ("8.2.3", "statement", "1", "2", Judgement.DIFFERS, ""),
        ("8.2.3", "statement", "1", "2", Judgement.AGREES, "but"),
    ],
)
def test_a_verdict_that_leaves_a_question_open_is_refused(values: tuple[str, str, str, str, Judgement, str]) -> None:
    with pytest.raises(ValueError, match="verdict"):
        Verdict(*values)


def test_verdicts_are_counted_by_kind_and_given_as_rows() -> None:
    found = [not_public("8.2.3", "drives", "no data"), close("8.2.3", "slip", 1.0, 1.0, 0.1, "cause")]
    assert counts(found) == "1 agree, 0 differ, 1 not public"
    assert [row["verdict"] for row in rows(found)] == ["not public", "agrees"]
