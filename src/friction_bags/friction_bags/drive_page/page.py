"""The page of a drive: one HTML file that holds its data, its code and its style."""

from __future__ import annotations

import json
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

from friction_bags.bag_io.bag_format import BagError
from friction_bags.drive_page.page_data import page_data
from friction_bags.drive_page.recorded_run import RecordedRun


def write_page(run: RecordedRun, out: Path, title: str, remarks: Sequence[str] = ()) -> None:
    """Write the page of a run; it opens without a network.

    Args:
        run: the run.
        out: HTML file, which must not exist.
        title: name of the drive.
        remarks: sentences on how the data came to be.

    Raises:
        BagError: the file exists.
        OSError: it cannot be written.
    """
    refuse_existing(out)
    out.parent.mkdir(parents=True, exist_ok=True)
    # A name of a file may hold bytes that are no text.
    out.write_text(html_page(page_data(run, title, remarks)), encoding="utf-8", errors="replace")


def refuse_existing(out: Path) -> None:
    """Refuse a file that exists.

    Raises:
        BagError: it does.
    """
    if out.exists():
        raise BagError(f"{out} exists")


def html_page(data: dict[str, Any]) -> str:
    """Return the page that shows the data of page_data."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    for letter in "<>&":  # the data end where the browser sees a tag, whatever a bag names a wheel
        text = text.replace(letter, f"\\u{ord(letter):04x}")
    return Template(_file("drive.html")).substitute(
        title=escape(data["title"]),
        style=_file("uPlot.min.css") + _file("drive.css"),
        plotting=_file("uPlot.iife.min.js"),
        script=_file("drive.js"),
        licence=escape(_file("uPlot.LICENSE")),
        data=text,
    )


def _file(name: str) -> str:
    return files("friction_bags.drive_page").joinpath("web", name).read_text(encoding="utf-8")
