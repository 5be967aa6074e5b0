"""The report: one page that opens offline, and the figures that only it draws."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from benchmarks.runner import Row, rows_of
from book import report, smart_tyre
from book.chapter_numbers import Spread, compared
from book.driver_stop import ROADS, abscissas, stop_run
from book.page import Picture, Section, Table, page
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


def test_friction_samples_overshoot_the_curve_and_are_highest_near_its_peak_only_at_the_load_as_it_is() -> None:
    high, low = abscissas()
    assert high["overshoot [%]"] > 5.0
    assert low["overshoot [%]"] > 0.0
    assert high["abscissa moved, load at rest [%]"] == pytest.approx(80.7, abs=2.0)
    assert high["abscissa moved, load as it is [%]"] == pytest.approx(11.1, abs=2.0)
    assert abs(low["abscissa moved, load as it is [%]"]) < 5.0


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


def test_the_page_begins_with_the_numbers_of_all_sections() -> None:
    numbers = [compared("Table 8.2", "slip of the peak", 0.17, Spread(0.4, 0.5, 0.6))]
    html = page("Title", "", [Section("a", "A", "", numbers=numbers), Section("b", "B", "text")], {"v": "speed"})
    assert html.index("slip of the peak") < html.index("<dt>v</dt><dd>speed") < html.index(">A</h2>")


def made(key: str) -> Callable[[Path, Callable[[int], int]], Section]:
    numbers = [compared("Table 8.2", key, 0.17, Spread(0.4, 0.5, 0.6))]
    return lambda _pictures, seeds: Section(key, key, "text", [Table("delay", [{"seeds": seeds(50)}])], (), numbers)


def test_a_section_goes_to_the_page_and_its_rows_to_results(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(report, "SECTIONS", {key: made(key) for key in ("8.2", "8.3.2", "8.3.3")})
    (first, second) = rows_of("book", "report", "--out", str(tmp_path), "--effort", "0.1", "--section", "8.3")
    assert (first["quantity"], second["quantity"]) == ("8.3.2", "8.3.3")
    results = json.loads((tmp_path / "results.json").read_text())
    assert results["8.3.2"] == {"delay": [{"seeds": 5}]}
    assert len(results["numbers"]) == 2
    assert "8.3.3" in (tmp_path / "index.html").read_text()


def test_a_section_that_the_chapter_does_not_have_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match=r"8\.3\.2"):
        rows_of("book", "report", "--out", str(tmp_path), "--section", "8.31")


def test_the_page_holds_the_sections_made_before_one_that_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_pictures: Path, _seeds: Callable[[int], int]) -> Section:
        raise RuntimeError

    monkeypatch.setattr(report, "SECTIONS", {"8.2": made("The first"), "8.4": fail})
    with pytest.raises(RuntimeError):
        rows_of("book", "report", "--out", str(tmp_path))
    assert "The first" in (tmp_path / "index.html").read_text()
