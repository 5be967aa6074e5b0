"""The report as one HTML file that opens offline: symbols, sections of text, tables and pictures."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from itertools import groupby
from pathlib import Path

from benchmarks.runner import Row, as_text, columns

SYMBOLS = {
    "slip, lambda": "1 - omega r / v: 0 for a rolling wheel, 1 for a locked one [-]",
    "mu(slip)": "friction coefficient over slip, Fx / Fz in braking; the curve rises to a peak and falls beyond it [-]",
    "lambda_max, mu_max": "slip and friction coefficient at the peak of that curve [-]",
    "mu_1": "slope of the curve: positive on the stable side of the peak, negative beyond it [-]",
    "omega, r, J": "speed [rad/s], radius [m] and moment of inertia [kg m^2] of the wheel",
    "v, T_b": "speed of the car [m/s], brake torque of a wheel [N m]",
    "H": "omega_ddot + T_b_dot / J, which has the sign of mu_1 times that of the slip rate [rad/s^3], (8.3)",
    "eta": "normalised wheel deceleration, -omega_dot r / g [-]; (8.5) takes its sign for that of the slip rate",
    "slip / no_slip": "sign of the slope with a known slip (8.4), and with wheel speed and pressure alone (8.5)",
    "H_inst, H_st": "thresholds of H at which stability counts as lost and as regained [rad/s^3]",
    "S0, S1, S21, S22": "supervisor: not braking; stable, pressure may rise; released, waiting; released",
    "theta_1, theta_2, theta_3": "parameters of the Burckhardt curve theta_1 (1 - exp(-theta_2 slip)) - theta_3 slip",
    "ML, RML, RML+ML": "maximum likelihood over all samples; recursive; recursive with a few batch iterations",
    "LS, RLS": "least squares on four fixed exponentials, a line and a constant (8.12); recursive",
    "lambda_init, ABS activation": "slip beyond which the methods start (0.07), and at which an ABS would act (0.15)",
    "Fx, Fz": "longitudinal and vertical force of a tyre on the road [N]",
    "alpha_1, alpha_2": "wheel angles at which a point of the tyre enters and leaves the contact patch",
    "delta phi, Delta phi": "shift of the middle of the patch, which follows Fx, and its length, which follows Fz",
    "beta": "share of the length's change that is in the shift by cross-talk (8.19) [-]",
    "RMSE, coverage_95": "root of the mean squared error; share of runs whose stated 95 % interval holds the truth [%]",
}


_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 1240px; margin: 2em auto; padding: 0 1em; color: #222; }
h1, h2, h3 { line-height: 1.2; } h2 { border-bottom: 1px solid #ccc; margin-top: 2.5em; }
.table { overflow-x: auto; margin: 0.7em 0; }
table { border-collapse: collapse; font-size: 12px; line-height: 1.35; }
th, td { border: 1px solid #ccc; padding: 2px 5px; text-align: right; vertical-align: top; }
th { background: #f2f2f2; } td:first-child, th:first-child, td.text { text-align: left; }
td.number { white-space: nowrap; } .wide table { font-size: 10.5px; } .wide th, .wide td { padding: 1px 3px; }
dd, dt { text-align: left; }
dl { display: grid; grid-template-columns: max-content auto; gap: 0 1em; } dt { font-style: italic; } dd { margin: 0; }
figure { margin: 1.2em 0; } img { max-width: 100%; height: auto; }
figcaption, caption { color: #555; text-align: left; font-size: 13px; } summary { cursor: pointer; margin: 0.5em 0; }
@media (max-width: 700px) {
  dl { display: block; }
}
@media print {
  @page { size: A4; margin: 12mm; }
  body { max-width: none; margin: 0; padding: 0; font-size: 10px; }
  .table { overflow: visible; } table, .wide table { width: 100%; font-size: 7px; }
  caption, figcaption { font-size: 9px; }
  .wide table { font-size: 5px; } .wide th, .wide td { overflow-wrap: anywhere; }
  th, td, td.number { white-space: normal; padding: 0 1px; }
  details::details-content { content-visibility: visible; display: block; }
  tr, figure { break-inside: avoid; } h2, h3, caption, summary { break-after: avoid; } img { max-height: 110mm; }
}
"""
_WIDE = 14
"""Columns from which a table is set smaller."""


@dataclass(frozen=True)
class Table:
    """Rows under a caption; every row may have its own columns."""

    caption: str
    rows: Sequence[Row]
    folded: bool = False
    """Whether only its caption is seen until it is opened."""


@dataclass(frozen=True)
class Picture:
    """A PNG file under a caption."""

    caption: str
    file: Path
    fold: str = ""
    """Pictures in a row with the same text here are folded under it."""


@dataclass(frozen=True)
class Section:
    """A part of the report. `key` names its rows in results.json."""

    key: str
    title: str
    text: str
    """How the runs were made."""
    tables: Sequence[Table] = field(default_factory=tuple)
    pictures: Sequence[Picture] = field(default_factory=tuple)
    numbers: Sequence[Row] = field(default_factory=tuple)
    """Numbers of the chapter beside ours, which stand at the top of the page."""


def page(title: str, introduction: str, sections: Sequence[Section], symbols: Mapping[str, str]) -> str:
    """Return the HTML of the report, pictures embedded.

    Raises:
        OSError: a picture cannot be read.
    """
    contents = "".join(f'<li><a href="#{escape(s.key)}">{escape(s.title)}</a></li>' for s in sections)
    body = "".join(_section(section) for section in sections)
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8">'
        f'<meta name="viewport" content="width=device-width, initial-scale=1"><title>{escape(title)}</title>'
        f"<style>{_STYLE}</style></head><body><h1>{escape(title)}</h1>{_paragraphs(introduction)}"
        f"{_numbers(sections)}<h2>Symbols</h2>{_symbols(symbols)}<h2>Contents</h2>"
        f"<ol>{contents}</ol>{body}</body></html>\n"
    )


def _numbers(sections: Sequence[Section]) -> str:
    rows = [row for section in sections for row in section.numbers]
    caption = "Numbers of the chapter beside the median and the middle 90 % of our runs"
    return f"<h2>The chapter's numbers</h2>{_table(Table(caption, rows))}" if rows else ""


def _symbols(symbols: Mapping[str, str]) -> str:
    return "<dl>" + "".join(f"<dt>{escape(k)}</dt><dd>{escape(v)}</dd>" for k, v in symbols.items()) + "</dl>"


def _section(section: Section) -> str:
    tables = "".join(_table(table) for table in section.tables)
    pictures = ""
    for fold, group in groupby(section.pictures, key=lambda picture: picture.fold):
        shown = "".join(_picture(picture) for picture in group)
        pictures += _folded(fold, shown) if fold else shown
    return f'<h2 id="{escape(section.key)}">{escape(section.title)}</h2>{_paragraphs(section.text)}{tables}{pictures}'


def _paragraphs(text: str) -> str:
    return "".join(f"<p>{escape(' '.join(part.split()))}</p>" for part in text.split("\n\n") if part.strip())


def _folded(summary: str, html: str) -> str:
    return f"<details><summary>{escape(summary)}</summary>{html}</details>"


def _table(table: Table) -> str:
    names = columns(table.rows)
    # A name of many parts may be broken at its underscores, or a table of many columns does not fit a page.
    head = "".join(f"<th>{escape(name).replace('_', '_<wbr>')}</th>" for name in names)
    lines = "".join("<tr>" + "".join(_cell(row.get(name, "")) for name in names) + "</tr>" for row in table.rows)
    caption = "" if table.folded else f"<caption>{escape(table.caption)}</caption>"
    wide = " wide" if len(names) >= _WIDE else ""
    html = f'<div class="table{wide}"><table>{caption}<tr>{head}</tr>{lines}</table></div>'
    return _folded(table.caption, html) if table.folded else html


def _cell(value: object) -> str:
    text = escape(as_text(value))
    return f'<td class="{"text" if isinstance(value, str) and value else "number"}">{text}</td>'


def _picture(picture: Picture) -> str:
    data = base64.b64encode(picture.file.read_bytes()).decode("ascii")
    caption = escape(picture.caption)
    return (
        f'<figure><img alt="{caption}" src="data:image/png;base64,{data}"><figcaption>{caption}</figcaption></figure>'
    )
