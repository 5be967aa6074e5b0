"""The report: one page that opens offline, and the figures that only it draws."""

import json
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from benchmarks.rows import Row
from benchmarks.slip.stops import shipped
from book import friction_samples, smart_tyre, speed, speed_verdicts
from book import part as report
from book.page import Picture, Section, Table, page
from book.parts import rows_of
from book.speed_tables import tables
from book.stop_run import ROADS, stop_run
from book.verdicts import Judgement, close
from friction_parameters.parameter import ParameterError


def test_page_holds_its_pictures_and_needs_no_network(tmp_path: Path) -> None:
    file = tmp_path / "a.png"
    figure = Figure()
    figure.subplots().plot([0, 1])
    figure.savefig(file)
    table = Table("numbers & <units>", [{"a": 1.23456, "b": float("nan")}, {"a": 2, "c": "x"}])
    html = page("Title", "one\n\ntwo", [Section("key", "Part", "text", [table], [Picture("seen", file)])], {})
    file.unlink()
    assert 'src="data:image/png;base64,' in html
    assert "http" not in html
    assert "<p>one</p><p>two</p>" in html
    assert "numbers &amp; &lt;units&gt;" in html
    cells = [f'<td class="number">{text}</td>' for text in ("1.235", "–", "")]
    assert "".join(cells) in html


def test_pictures_of_one_fold_and_folded_tables_open_on_request(tmp_path: Path) -> None:
    file = tmp_path / "a.png"
    file.write_bytes(b"picture")
    pictures = [Picture("first", file), Picture("second", file, "other roads"), Picture("third", file, "other roads")]
    html = page("Title", "", [Section("key", "Part", "", [Table("rows", [{"a": 1}], folded=True)], pictures)], {})
    assert html.count("<details>") == 2
    assert "<details><summary>rows</summary>" in html
    assert html.index("other roads") > html.index("first")
    assert html.count("other roads") == 1


def test_page_begins_with_the_verdicts_of_all_sections_and_their_count(tmp_path: Path) -> None:
    verdicts = [close("Table 8.2", "slip of the peak", 0.17, 0.5, 0.05, "the road is another")]
    html = page("Title", "", [Section("a", "A", "", verdicts=verdicts), Section("b", "B", "text")], {"v": "speed"})
    assert (
        html.index("differs</b> because the road is another")
        < html.index("<dt>v</dt><dd>speed")
        < html.index(">A</h2>")
    )
    assert "0 agree, 1 differ, 0 not public" in html


def test_friction_samples_overshoot_the_curve_and_are_highest_near_its_peak_only_at_the_load_as_it_is() -> None:
    high, low = friction_samples.abscissas()
    assert high["overshoot [%]"] > 5.0
    assert low["overshoot [%]"] > 0.0
    assert high["abscissa moved, load at rest [%]"] == pytest.approx(80.7, abs=2.0)
    assert high["abscissa moved, load as it is [%]"] == pytest.approx(11.1, abs=2.0)
    assert abs(low["abscissa moved, load as it is [%]"]) < 5.0
    overshoot, moved = friction_samples.verdicts([high, low])
    assert (overshoot.judgement, moved.judgement) == (Judgement.AGREES, Judgement.DIFFERS)
    still = [row | {"abscissa moved, load at rest [%]": 2.0} for row in (high, low)]
    assert friction_samples.verdicts(still)[1].judgement is Judgement.AGREES


@pytest.mark.parametrize("name", ROADS.values())
def test_stop_is_followed_to_its_largest_slip_by_samples_of_its_own_friction(name: str) -> None:
    run = stop_run(name, 7)
    samples = run.friction_samples(estimated=False, moving_load=True)
    numbers = np.array([number for number, _ in samples])
    assert run.onset < numbers[-1] < run.end <= run.onset + 160
    true = run.history("friction")[numbers]
    found = np.array([point.mu for _, point in samples])
    assert float(np.sqrt(np.mean((found - true) ** 2))) < 0.06
    lost = run.signs[:, 0] < 0
    assert 0.0 < run.truth.time[np.argmax(lost)] - run.truth.up < 0.15


def test_rows_of_the_smart_tyre_stand_by_axle_and_are_folded_by_case_but_for_what_has_to_hold() -> None:
    head = {"case": "2.0 bar", "quantity": "Fx RMSE [%]", "limit": 6.0}
    rows: list[Row] = [head | {"axle": "front", "value": 4.0, "passed": True}]
    rows.append(head | {"axle": "rear", "value": 7.0, "passed": False})
    rows.append({"case": "noise", "quantity": "bias", "limit": None, "axle": "front", "value": 1.0, "passed": None})
    judged, *others = smart_tyre.tables(rows)
    assert judged.rows == [head | {"front": 4.0, "rear": 7.0, "passed": False}]
    assert [(table.folded, len(table.rows)) for table in others] == [(True, 1), (True, 1)]


def test_errors_of_tables_8_4_and_8_5_are_judged_and_a_wrong_one_turns_the_verdict() -> None:
    rows, stops = tables(range(41_000, 41_002), shipped()), speed.stop_rows(1)
    found = {verdict.statement: verdict for verdict in speed_verdicts.verdicts(rows, stops)}
    errors = [statement for statement in found if statement.startswith("Error of lambda_max")]
    assert len(errors) == 6
    wide = [row | {"p5_percent": -30.0, "p95_percent": 30.0} for row in rows]
    turned = {verdict.statement: verdict for verdict in speed_verdicts.verdicts(wide, stops)}
    assert {turned[statement].judgement for statement in errors} == {Judgement.AGREES}
    off = [row | {"p5_percent": 31.0, "p95_percent": 32.0} for row in rows]
    turned = {verdict.statement: verdict for verdict in speed_verdicts.verdicts(off, stops)}
    assert {turned[statement].judgement for statement in errors} == {Judgement.DIFFERS}
    few = found["The same where only samples beyond lambda_init are fitted"]
    assert few.judgement is Judgement.AGREES


def test_sections_go_to_the_page_and_their_rows_to_results(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    section = Section("slope", "Slope", "text", [Table("delay", [{"delay": float("inf")}])])
    monkeypatch.setattr(report, "_sections", lambda *_arguments, **_options: [lambda: section])
    (row,) = rows_of("report", "--out", str(tmp_path), "--effort", "0.01")
    assert row == {"section": "Slope", "tables": 1, "rows": 1, "figures": 0}
    results = json.loads((tmp_path / "results.json").read_text())
    assert results == {"verdicts": [], "slope": {"delay": [{"delay": "inf"}]}}
    assert "Slope" in (tmp_path / "index.html").read_text()


def test_page_holds_the_sections_made_before_one_that_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail() -> Section:
        raise RuntimeError

    first = Section("first", "The first", "text")
    monkeypatch.setattr(report, "_sections", lambda *_arguments, **_options: [lambda: first, fail])
    with pytest.raises(RuntimeError):
        rows_of("report", "--out", str(tmp_path))
    assert "The first" in (tmp_path / "index.html").read_text()


def test_absent_measured_data_are_a_note_on_the_page(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[str, ...]] = []

    def answer(*arguments: str) -> list[Row]:
        asked.append(arguments)
        if arguments[0] == "measured":
            raise ParameterError("measured data are absent: bmw.csv")
        return [{"seeds": 1}]

    monkeypatch.setattr(report, "rows_of", answer)
    section = report._measured(str)
    assert "measured data are absent: bmw.csv" in section.text
    assert asked[-1] == ("slip", "--cases", "stops", "--seeds", "100")
