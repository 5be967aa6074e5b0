"""The page of a drive: one HTML file that holds its data, rounded and thinned, its code and its style."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta, timezone
from html import escape
from importlib.resources import files
from math import isfinite
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from friction_bags.bag_io.bag_format import BagError
from friction_bags.results.braking_rows import BrakingRow, Part, braking_rows, main_reason
from friction_bags.results.recorded_run import VEHICLE, WHY, RecordedRun, Series
from friction_report.drive_series import (
    DRIVER,
    Line,
    curves_of,
    lines_of,
    strips_of,
    track_of,
)
from friction_report.encoding import TIME_DIGITS, Meanings, Thinning, short
from friction_report.signals import points_of, signals_of
from friction_runtime.reports import INTERVAL_95, plain_reason
from vehicle_models.nanoseconds import NANOSECONDS

_SHOWN_REASONS = 3
_ESTIMATED = ("estimate", "points")
"""Kinds of lines without which the truth alone makes no panel."""
_EARLIEST_DATE = 1e9
"""Stamp [s] from which on it is a date, of 2001: a simulation or a log of relative times begins near 0."""


@dataclass(frozen=True)
class Panel:
    """A plot of the page."""

    key: str
    title: str
    axis: str
    """Quantity with its unit, for lines."""
    holds: str
    """What it shows, by its topics."""
    digits: int = 0
    """Decimals of the values, for lines."""


_SCRIPTS = ("base", "view", "time_plots", "strips", "curve", "track", "own", "export", "tables", "page")
"""Files of the page's code in the order in which they run."""
PANELS = (
    Panel("speed", "Speeds of car and wheels", "speed [m/s]", "slip, vehicle_velocity", 3),
    Panel("slip", "Slip of each wheel", "slip λ [-]", "slip", 4),
    Panel("grip", "Friction used, proven and believed", "µ [-]", "grip", 3),
    Panel("wheel_grip", "Friction used by each wheel", "µ [-]", "grip", 3),
    Panel("mu_proven", "Track, coloured by the friction proven within 100 m", "µ proven", "sensor_msgs/NavSatFix"),
    Panel("mu_lower", "Track, coloured by the lower bound of friction", "µ, lower bound", "sensor_msgs/NavSatFix"),
    Panel("sign", "Sign of the slope of the friction curve", "", "friction_slope"),
    Panel("lambda_max", "Slip at the peak of the identified curve", "λ_max [-]", "friction_curve", 4),
    Panel("mu_max", "Friction at the peak of the identified curve", "µ_max [-]", "friction_curve", 3),
    Panel("curve", "Friction curve at the picked time", "", "friction_curve"),
    Panel("supervisor", "Supervisor", "", "abs_supervisor, brake_command"),
    Panel("pressure", "Brake pressure", "pressure [MPa]", "brake_pressure, brake_demand", 3),
    Panel("torque", "Brake torque", "torque [N m]", "abs_supervisor", 1),
    Panel("fx", "Longitudinal force of each tyre", "Fx, forward [kN]", "tyre_force", 3),
    Panel("fz", "Vertical force of each tyre", "Fz [kN]", "tyre_force", 3),
    Panel("own", "Signals of your choice", "", "any number", 0),
    Panel("validity", "Validity of the estimates, and the reasons", "", "estimate"),
)
"""In the order of the page."""


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
        script="".join(_file(f"{name}.js") for name in _SCRIPTS),
        licence=escape(_file("uPlot.LICENSE")),
        data=text,
    )


@np.errstate(over="ignore", invalid="ignore")  # what is no number, or absurd, becomes a gap
def page_data(run: RecordedRun, title: str, remarks: Sequence[str] = ()) -> dict[str, Any]:
    """Return what the page shows of a run, as JSON holds it.

    Args:
        run: the run.
        title: name of the drive.
        remarks: sentences on how the data came to be.
    """
    brakings = braking_rows(run)
    lines, strips, curves = list(lines_of(run)), list(strips_of(run)), list(curves_of(run))
    times = [series.time for series in run.series.values()]
    start, end = (min(t[0] for t in times), max(t[-1] for t in times)) if times else (0.0, 0.0)
    signals, track = list(signals_of(run)), track_of(run)
    thin = Thinning(start, end, [(row.start, row.end) for row in brakings], len(signals))
    drawn = [line for line in lines if np.any(np.isfinite(line.values))]
    never_valid = {line.panel for line in lines if line.kind in _ESTIMATED}
    never_valid -= {line.panel for line in drawn if line.kind in (*_ESTIMATED, "sensor", "bound")}
    drawn = [line for line in drawn if line.panel not in never_valid]
    meanings = Meanings(strips)
    filled = {line.panel for line in drawn} | {strip.panel for strip in strips}
    filled |= ({"curve"} if curves and "lambda_max" in filled else set()) | ({"own"} if signals else set())
    filled |= set(track.values) if track else set()
    shown = [panel for panel in PANELS if panel.key in filled]
    digits = {panel.key: panel.digits for panel in PANELS}
    encoded = [thin.line(line, digits[line.panel]) for line in drawn]
    return {
        "title": short(title),
        "facts": [*_facts(run, end - start), *([text, ""] for text in remarks)],
        "absent": [_absent(panel, run, brakings) for panel in PANELS if panel.key not in filled],
        "problems": [short(text) for text in run.problems],
        "not_drawn": [short(text) for text in run.not_read],
        "span": [round(start, TIME_DIGITS), round(end, TIME_DIGITS)],
        "wheels": [*run.wheels, *(of for of in (VEHICLE, DRIVER) if any(line.of == of for line in drawn))],
        "panels": [_panel(panel, run, lines, drawn, brakings) for panel in shown],
        "lines": encoded,
        "strips": [thin.strip(strip, meanings) for strip in strips],
        "meanings": meanings.listed,
        "signals": [thin.signal(each) for each in signals],
        "points": [thin.points(each) for each in points_of(run) if np.any(np.isfinite(each.slip + each.mu))],
        "curves": [thin.curves(each) for each in curves],
        "track": thin.track(track) if track else None,
        "times": thin.times,
        "interval": INTERVAL_95,
        "brakings": [_braking(row) for row in brakings],
        "topics": [_topic(topic, series) for topic, series in sorted(run.series.items())],
    }


def _panel(
    panel: Panel, run: RecordedRun, lines: Sequence[Line], drawn: Sequence[Line], brakings: Sequence[BrakingRow]
) -> dict[str, Any]:
    empty = [line for line in lines if line.panel == panel.key and not any(line is each for each in drawn)]
    remarks = [
        f"{line.label}: {_why_empty(run.series[line.topic], line.of, brakings)}" for line in empty if line.kind != "aim"
    ]
    made: dict[str, Any] = {"key": panel.key, "title": panel.title, "axis": panel.axis}
    return made | {"remarks": [short(text) for text in remarks]}


def _absent(panel: Panel, run: RecordedRun, brakings: Sequence[BrakingRow]) -> str:
    """Return a panel's title, and why there is nothing to show: the reason of its first estimate, in brakings."""
    held = panel.holds.split(", ")
    for topic, series in run.series.items():
        of, _, name = topic.rpartition("/")
        if name in held and not topic.startswith("truth/"):
            return short(f"{panel.title} ({_why_empty(series, of, brakings)})")
    return f"{panel.title} (no {panel.holds})"


def _why_empty(series: Series, of: str, brakings: Sequence[BrakingRow]) -> str:
    if not series.reasons:
        return "no value"
    inside = np.zeros(series.time.shape, dtype=np.bool_)
    for row in brakings:
        inside |= (series.time >= row.start) & (series.time < row.end)
    return f"never valid: {main_reason(series, of, inside)}"


def _facts(run: RecordedRun, duration: float) -> list[list[str]]:
    begin = f"stamp {run.start / NANOSECONDS:.3f} s, no date"
    if run.start > _EARLIEST_DATE * NANOSECONDS:
        begun = datetime(1970, 1, 1, tzinfo=timezone.utc) + timedelta(microseconds=run.start // 1000)
        begin = f"{begun:%Y-%m-%d %H:%M:%S} UTC"
    facts = [["begin", begin], ["duration", f"{duration:.1f} s"]]
    facts += [["wheels", ", ".join(run.wheels) or "none"]]
    return [[short(name), short(text)] for name, text in [*facts, *run.notes.items()]]


def _braking(row: BrakingRow) -> dict[str, Any]:
    parts = [
        {"of": part.of, "valid": _number(part.valid, 3), "reason": short(part.reason)}
        | {name: _with_reach(part, name) for name in ("mu_used", "mu_max", "lambda_max")}
        for part in row.parts
    ]
    return {
        "start": _number(row.start, 3),
        "end": _number(row.end, 3),
        "from": _number(row.from_speed, 2),
        "to": _number(row.to_speed, 2),
        "deceleration": _number(row.mean_deceleration, 2),
        "hardest": _number(row.largest_deceleration, 2),
        "slip": _number(row.largest_slip, 3),
        "slip_of": row.slip_of,
        "parts": parts,
    }


def _with_reach(part: Part, name: str) -> list[float | None]:
    """Return a value and half the width of its 95 % interval."""
    return [_number(getattr(part, name), 4), _number(INTERVAL_95 * getattr(part, f"{name}_stddev"), 4)]


def _topic(topic: str, series: Series) -> dict[str, Any]:
    wheel = topic.partition("/")[0]
    reasons = [f"{plain_reason(text, wheel)} ({n})" for text, n in series.reasons.most_common(_SHOWN_REASONS)]
    share = float(np.mean(series["valid"])) if WHY in series.columns else None
    made: dict[str, Any] = {"name": short(topic), "messages": int(series.time.size)}
    return made | {"valid": share if share is None else round(share, 4), "reasons": [short(text) for text in reasons]}


def _number(value: float, digits: int) -> float | None:
    return round(value, digits) if isfinite(value) else None


def _file(name: str) -> str:
    return files("friction_report").joinpath("web", name).read_text(encoding="utf-8")
