"""Tables 8.1 to 8.3 and Figures 8.5 to 8.8, and which reading of the chapter gives which of its numbers."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from benchmarks.rows import Row, as_text
from book import identification_verdicts, texts
from book.identification_figures import figures
from book.page import Picture, Section, Table
from book.parts import FEWEST, Seeds, rows_of
from book.tables import READINGS, chapter_tables
from book.tables import readings as readings_of

_FIRST = "cobblestone"
"""The chapter's figures are of this road."""
_FIGURES = {"rml": "Figures 8.5, 8.6", "rls": "Figures 8.7, 8.8"}
_METHODS = ("rml", "rls", "ml", "rml_ml", "default")
CHAPTER_KEPT = {("rml", "cobblestone", 10): 30.0, ("rls", "cobblestone", 10): 40.0, ("rls", "cobblestone", 5): 70.0}
"""Samples from which the chapter's lambda_max stays within the limit [%], by method and road."""


def section(pictures: Path, seeds: Seeds) -> Section:
    """Make the runs and draw into `pictures`."""
    drawn = figures(pictures, _METHODS)
    numbers = chapter_tables(int(seeds(500)))
    readings = readings_of(max(int(seeds(300)), FEWEST))
    in_c = ("--manoeuvre", "C", "--methods", "rml", "rls")
    kept = kept_rows(
        [
            *rows_of("identification", "--study", "methods", "--seeds", seeds(500)),
            *rows_of("identification", "--study", "methods", "--seeds", seeds(500), *in_c),
        ]
    )
    shown = [
        Table("Which reading gives which number: |error| of lambda_max [%], median (5 to 95 %)", by_number(readings)),
        Table("Sample from which the error of lambda_max stays within 10 % and 5 % (median of the runs)", kept),
        Table("Tables 8.1 to 8.3, medians over the runs beside the chapter's single runs", numbers),
    ]
    shown_figures = sorted((_picture(row) for row in drawn), key=lambda picture: bool(picture.fold))
    title = "Identification of the friction curve, Tables 8.1 to 8.3, Figures 8.5 to 8.8"
    verdicts = identification_verdicts.verdicts(numbers, readings, kept)
    return Section("identification", title, texts.IDENTIFICATION, shown, shown_figures, verdicts)


def by_number(rows: Sequence[Row]) -> list[Row]:
    """Rows of the study `readings` with the readings side by side, and those whose runs hold the chapter's number."""
    found: dict[tuple[str, str], Row] = {}
    for row in rows:
        number = found.setdefault(
            (row["method"], row["surface"]),
            {"method": row["method"], "road": row["surface"], "chapter": row["chapter_pct"]},
        )
        low, median, high = (row[name] for name in ("p5_pct", "median_pct", "p95_pct"))
        number[row["reading"]] = f"{as_text(median)} ({as_text(low)} to {as_text(high)})"
        gives = str(number.get("given by", ""))
        if low <= row["chapter_pct"] <= high:
            gives = f"{gives}; {row['reading']}" if gives else row["reading"]
        number["given by"] = gives
    order = ["method", "road", "chapter", *READINGS, "given by"]
    return [{name: row.get(name) for name in order} for row in found.values()]


def kept_rows(rows: Sequence[Row]) -> list[Row]:
    """Rows by method with the roads side by side, from those of the study `methods`, and the chapter's numbers."""
    found: dict[tuple[str, str, int], Row] = {}
    for row in rows:
        for limit in (10, 5):
            head = {"method": row["method"], "manoeuvre": row["manoeuvre"], "within [%]": limit}
            line = found.setdefault((row["method"], row["manoeuvre"], limit), head)
            line[row["surface"]] = row[f"kept_{limit}pct_from"]
            chapter = CHAPTER_KEPT.get((row["method"], row["surface"], limit))
            if chapter is not None:
                line["the chapter's, cobblestone"] = chapter
    return list(found.values())


def _picture(row: Row) -> Picture:
    method, road = row["method"], row["surface"]
    number = f"{_FIGURES[method]}: " if method in _FIGURES else ""
    error = row["error_pct"]
    ends = "gives no peak" if error != error else f"ends {error:+.1f} % from the true lambda_max"
    caption = f"{number}{method} on {road}: fit to the samples (left), lambda_max against samples (right); {ends}"
    shown_first = road == _FIRST and method in _FIGURES
    return Picture(caption, Path(row["figure"]), "" if shown_first else "Other methods and roads")
