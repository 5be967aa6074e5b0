"""The report as one HTML file that opens offline: sections of text, tables and pictures."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path

from friction_evaluation.rows import Row, as_text, columns

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 1240px; margin: 2em auto; padding: 0 1em; color: #222; }
h1, h2, h3 { line-height: 1.2; } h2 { border-bottom: 1px solid #ccc; margin-top: 2.5em; }
table { border-collapse: collapse; font-size: 12px; margin: 0.7em 0; display: block; overflow-x: auto; }
th, td { border: 1px solid #ccc; padding: 2px 6px; text-align: right; white-space: nowrap; }
th { white-space: normal; background: #f2f2f2; } td:first-child, th:first-child { text-align: left; }
figure { margin: 1.2em 0; } img { max-width: 100%; } figcaption, caption { color: #555; text-align: left; }
@media print {
  @page { size: A4; margin: 12mm; }
  body { max-width: none; margin: 0; padding: 0; font-size: 10px; }
  table { display: table; width: 100%; font-size: 6px; } td, th { white-space: normal; padding: 1px 2px; }
  figure { break-inside: avoid; } h2, h3 { break-after: avoid; }
}
"""


@dataclass(frozen=True)
class Table:
    """Rows under a caption; every row may have its own columns."""

    caption: str
    rows: Sequence[Row]


@dataclass(frozen=True)
class Picture:
    """A PNG file under a caption."""

    caption: str
    file: Path


@dataclass(frozen=True)
class Section:
    """A part of the report. `key` names its rows in results.json."""

    key: str
    title: str
    text: str
    """What was done, what agrees with the chapter and what does not, and why."""
    tables: Sequence[Table] = field(default_factory=tuple)
    pictures: Sequence[Picture] = field(default_factory=tuple)


def page(title: str, introduction: str, sections: Sequence[Section]) -> str:
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
        f"<ol>{contents}</ol>{body}</body></html>\n"
    )


def _section(section: Section) -> str:
    tables = "".join(_table(table) for table in section.tables)
    pictures = "".join(_picture(picture) for picture in section.pictures)
    return f'<h2 id="{escape(section.key)}">{escape(section.title)}</h2>{_paragraphs(section.text)}{tables}{pictures}'


def _paragraphs(text: str) -> str:
    return "".join(f"<p>{escape(' '.join(part.split()))}</p>" for part in text.split("\n\n") if part.strip())


def _table(table: Table) -> str:
    names = columns(table.rows)
    head = "".join(f"<th>{escape(name)}</th>" for name in names)
    lines = "".join(
        "<tr>" + "".join(f"<td>{escape(as_text(row.get(name, '')))}</td>" for name in names) + "</tr>"
        for row in table.rows
    )
    return f"<table><caption>{escape(table.caption)}</caption><tr>{head}</tr>{lines}</table>"


def _picture(picture: Picture) -> str:
    data = base64.b64encode(picture.file.read_bytes()).decode("ascii")
    caption = escape(picture.caption)
    return (
        f'<figure><img alt="{caption}" src="data:image/png;base64,{data}"><figcaption>{caption}</figcaption></figure>'
    )
