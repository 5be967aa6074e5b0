"""The report: every table and every figure with data of the chapter beside its own numbers, and what goes beyond it.

Writes `index.html` (one file, opens offline) and `results.json` (every row, by section). `--effort` scales the numbers
of seeds: 1 is the full evaluation.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from rich.console import Console

from benchmarks.rows import Row, plain
from benchmarks.slip.stops import shipped
from book import (
    friction_samples,
    identification,
    slope,
    slope_verdicts,
    smart_tyre,
    speed,
    speed_verdicts,
    state_machine_figure,
    texts,
)
from book.page import SYMBOLS, Picture, Section, Table, page
from book.parts import FEWEST, Seeds, rows_of
from book.speed_tables import tables
from book.verdicts import rows as verdict_rows
from friction_parameters.command_line import positive
from friction_parameters.parameter import ParameterError

_SLOPE_SEEDS = 200
"""For each of the roads of Figures 8.2 and 8.3."""


_LIVE_SECONDS = (10.0, 60.0)
"""Shortest and full length of the live run in real time [s]."""
_SPEED_SEED = 30_000
_STOPS = 20
"""Driver's stops of each road for the methods of section 8.3."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this part."""
    parser.add_argument("--out", type=Path, default=Path("build/report"), help="directory (default: build/report)")
    parser.add_argument("--effort", type=positive, default=1.0, help="share of the seeds of the full evaluation")
    parser.add_argument("--no-live", action="store_true", help="leave out what runs over DDS in real time")


def run(options: argparse.Namespace) -> list[Row]:
    """Write the report; return what it holds."""
    out: Path = options.out
    pictures = out / "figures"
    pictures.mkdir(parents=True, exist_ok=True)
    console = Console()
    made: list[Section] = []
    for make in _sections(pictures, options.effort, live=not options.no_live):
        made.append(make())
        _write(out, made)  # after each section: a run that is ended early leaves what it has made
        console.print(f"{made[-1].title}: done")
    console.print(f"report {out / 'index.html'}", soft_wrap=True)
    return [
        {
            "section": s.title,
            "tables": len(s.tables),
            "rows": sum(len(t.rows) for t in s.tables),
            "figures": len(s.pictures),
        }
        for s in made
    ]


def _write(out: Path, made: Sequence[Section]) -> None:
    (out / "index.html").write_text(page(texts.TITLE, texts.INTRODUCTION, made, SYMBOLS), encoding="utf-8")
    results: dict[str, object] = {"verdicts": verdict_rows([verdict for s in made for verdict in s.verdicts])}
    results |= {s.key: {table.caption: [plain(row) for row in table.rows] for table in s.tables} for s in made}
    (out / "results.json").write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")


def _sections(pictures: Path, effort: float, live: bool) -> list[Callable[[], Section]]:
    def seeds(full: int) -> str:
        return str(max(2, round(effort * full)))

    sections: list[Callable[[], Section]] = [
        partial(slope.section, pictures, int(seeds(_SLOPE_SEEDS))),
        partial(_detection, pictures, seeds),
        partial(identification.section, pictures, seeds),
        partial(friction_samples.section, pictures),
        partial(_speed, pictures, seeds),
        partial(smart_tyre.section, pictures, seeds, live),
        partial(_beyond, seeds),
        partial(_measured, seeds),
    ]
    return [*sections, partial(_live, effort)] if live else sections


def _detection(pictures: Path, seeds: Seeds) -> Section:
    detected, closed = rows_of("slope", "--seeds", seeds(300)), rows_of("abs", "--seeds", seeds(100))
    corners, cars = ([row for row in detected if ("value" in row) is judged] for judged in (False, True))
    tables = [
        Table("One corner through the peak and back: delay, false alarms, slip at detection", corners),
        Table("Cars with load transfer: the driver's stops and ordinary braking", cars, folded=True),
        Table("Closed loop from 30 to 5 m/s", [row for row in closed if "value" not in row]),
        Table("Closed loop: what has to hold", [row for row in closed if "value" in row], folded=True),
    ]
    machine = pictures / "figure_8_1.png"
    state_machine_figure.draw(machine)
    figures = [Picture("Figure 8.1: states and transitions, found by trying every class of input", machine)]
    title = "Detection delay and adhesion utilisation, Figure 8.1"
    return Section("closed_loop", title, texts.CLOSED_LOOP, tables, figures, slope_verdicts.detection(detected))


def _speed(pictures: Path, seeds: Seeds) -> Section:
    runs = max(int(seeds(100)), FEWEST)
    rows, stops = tables(range(_SPEED_SEED, _SPEED_SEED + runs), shipped()), speed.stop_rows(min(runs, _STOPS))
    shown = [
        Table("Tables 8.4 and 8.5 in simulation, errors of lambda_max", rows),
        Table("The same on the driver's stops, of which Figures 8.10 to 8.13 show one each", stops),
    ]
    title = "With and without a speed sensor, Tables 8.4 and 8.5, Figures 8.10 to 8.13"
    drawn, verdicts = speed.pictures(pictures), speed_verdicts.verdicts(rows, stops)
    return Section("speed", title, texts.SPEED, shown, drawn, verdicts)


def _beyond(seeds: Seeds) -> Section:
    studies = {
        "All methods beside the Cramer-Rao bound": ("methods", 500),
        "500 random curves": ("random", 500),
        "P(beyond the peak) against the true crossing": ("alarms", 750),
        "Bias by wrong parameters": ("model_error", 100),
        "Outliers": ("outliers", 50),
        "Change of road": ("surface_change", 100),
        "Cost of an update": ("cost", 20),
    }
    tables = [
        Table(caption, rows_of("identification", "--study", study, "--seeds", seeds(full)))
        for caption, (study, full) in studies.items()
    ]
    return Section("default", "Beyond the chapter: the default estimator at its bound", texts.DEFAULT, tables)


def _measured(seeds: Seeds) -> Section:
    tables: list[Table] = []
    text, cases = texts.MEASURED, ["stops", "measured"]
    try:
        tables.append(Table("Whole-vehicle fits and tyre rig", rows_of("measured")))
    except ParameterError as absent:
        text, cases = f"There are no rows of measured cars and tyres here: {absent}.", ["stops"]
    rows = rows_of("slip", "--cases", *cases, "--seeds", seeds(100))
    tables.append(Table("Speed and slip without a speed sensor", rows))
    return Section("measured", "Measured data, and slip without a speed sensor", text, tables)


def _live(effort: float) -> Section:
    seconds = max(_LIVE_SECONDS[0], min(effort, 1.0) * _LIVE_SECONDS[1])
    rows = rows_of("live", "--seconds", f"{seconds:.0f}")
    tables = [Table(f"{seconds:.0f} s at 200 Hz, and one lock-step run", rows)]
    return Section("live", "The live graph", texts.LIVE, tables)
