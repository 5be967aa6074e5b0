"""The page of a drive: one HTML file that holds its data, rounded and thinned, its code and its style."""

from __future__ import annotations

import json
from collections import Counter
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
from numpy.typing import NDArray

from friction_bags.bag_io.bag_format import BagError
from friction_bags.results.braking_rows import BrakingRow, Part, braking_rows, main_reason
from friction_bags.results.recorded_run import VEHICLE, WHY, Array, RecordedRun, Series
from friction_report.drive_series import (
    DRIVER,
    Curves,
    Line,
    Strip,
    curves_of,
    lines_of,
    strips_of,
)
from friction_report.thinning import bucket_edges, decimate, last_of_buckets
from friction_runtime.reports import INTERVAL_95, plain_reason, report_kind
from vehicle_models.nanoseconds import NANOSECONDS

_COARSE, _FINE = 2000, 6000
"""Buckets over the whole drive, and in its brakings: with both, an hour of four wheels stays below 20 MB."""
_MOST_POINTS = 2 * (_COARSE + _FINE)
"""Points of a line that are kept as they are."""
_MOST_RUNS = 6000
"""Changes of a strip that are kept as they are."""
_TIME_DIGITS = 4
_LONGEST_STEP = 1.0
"""Time [s] without a message that breaks a line, if it is also long beside the usual step."""
_USUAL_STEPS = 10.0
_LARGEST = 2.0**53
"""Beyond it JSON's readers know no whole numbers; nothing that is measured comes near."""
_SHOWN_REASONS = 3
_ESTIMATED = ("estimate", "points")
"""Kinds of lines without which the truth alone makes no panel."""
_EARLIEST_DATE = 1e9
"""Stamp [s] from which on it is a date, of 2001: a simulation or a log of relative times begins near 0."""
_LONGEST_TEXT = 200
_REASON_TONES = 8
_CURVE_DIGITS = {
    **{"theta_1": 4, "theta_2": 3, "theta_3": 4, "lambda_max": 5, "mu_max": 4},
    **{"lambda_max_stddev": 5, "mu_max_stddev": 4},
}
_TONES = {
    **{"stable side": "good", "beyond the peak": "bad", "not known": "none"},
    **{"slope sign": "reason1", "curve": "good"},
    **{"increase": "good", "hold": "middle", "decrease": "bad"},
    **{"no release asked for": "none", "release allowed": "good", "release refused": "middle", "limit": "bad"},
    **{"standby": "none", "active": "good", "return": "bad"},
    "valid": "good",
}
_STATE_TONES = {"S0": "none", "S1": "good", "S21": "middle", "S22": "bad"}


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


PANELS = (
    Panel("speed", "Speeds of car and wheels", "speed [m/s]", "slip, vehicle_velocity", 3),
    Panel("slip", "Slip of each wheel", "slip λ [-]", "slip", 4),
    Panel("grip", "Friction used, proven and believed", "µ [-]", "grip", 3),
    Panel("sign", "Sign of the slope of the friction curve", "", "friction_slope"),
    Panel("lambda_max", "Slip at the peak of the identified curve", "λ_max [-]", "friction_curve", 4),
    Panel("mu_max", "Friction at the peak of the identified curve", "µ_max [-]", "friction_curve", 3),
    Panel("curve", "Friction curve at the picked time", "", "friction_curve"),
    Panel("supervisor", "Supervisor", "", "abs_supervisor, brake_command"),
    Panel("pressure", "Brake pressure", "pressure [MPa]", "brake_pressure, brake_demand", 3),
    Panel("torque", "Brake torque", "torque [N m]", "abs_supervisor", 1),
    Panel("fx", "Longitudinal force of each tyre", "Fx, forward [kN]", "tyre_force", 3),
    Panel("fz", "Vertical force of each tyre", "Fz [kN]", "tyre_force", 3),
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
        script=_file("drive.js"),
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
    thin = _Thinning(bucket_edges(start, end, [(row.start, row.end) for row in brakings], _COARSE, _FINE))
    drawn = [line for line in lines if np.any(np.isfinite(line.values))]
    never_valid = {line.panel for line in lines if line.kind in _ESTIMATED}
    never_valid -= {line.panel for line in drawn if line.kind in (*_ESTIMATED, "sensor", "bound")}
    drawn = [line for line in drawn if line.panel not in never_valid]
    meanings = _Meanings(strips)
    filled = {line.panel for line in drawn} | {strip.panel for strip in strips}
    filled |= {"curve"} if curves and "lambda_max" in filled else set()
    shown = [panel for panel in PANELS if panel.key in filled]
    encoded = [thin.line(line) for line in drawn]
    return {
        "title": _short(title),
        "facts": [*_facts(run, end - start), *([text, ""] for text in remarks)],
        "absent": [_absent(panel, run, brakings) for panel in PANELS if panel.key not in filled],
        "problems": [_short(text) for text in run.problems],
        "not_drawn": [_short(text) for text in run.not_read],
        "span": [round(start, _TIME_DIGITS), round(end, _TIME_DIGITS)],
        "wheels": [*run.wheels, *({VEHICLE, DRIVER} & {line.of for line in drawn})],
        "panels": [_panel(panel, run, lines, drawn, brakings) for panel in shown],
        "lines": encoded,
        "strips": [thin.strip(strip, meanings) for strip in strips],
        "meanings": meanings.listed,
        "curves": [thin.curves(each) for each in curves],
        "times": thin.times,
        "interval": INTERVAL_95,
        "brakings": [_braking(row) for row in brakings],
        "topics": [_topic(topic, series) for topic, series in sorted(run.series.items())],
    }


class _Thinning:
    """Lines, strips and curves in few numbers; lines with the same times share them."""

    def __init__(self, edges: Array) -> None:
        self._edges = edges
        self._known: dict[bytes, int] = {}
        self.times: list[list[int]] = []
        """Times in units of 0.1 ms: the first, then the steps."""

    def line(self, line: Line) -> dict[str, Any]:
        columns = np.stack([line.values, *(line.band or ())], axis=1)
        time, columns = _broken_at_gaps(line.time, columns)
        if time.size > _MOST_POINTS:
            time, columns = decimate(time, columns, self._edges)
        digits = next(panel.digits for panel in PANELS if panel.key == line.panel)
        scaled = _scaled(columns, digits)
        kept = _changing(scaled)
        if 2 * np.count_nonzero(kept) < time.size:
            time, scaled = time[kept], scaled[kept]
        made: dict[str, Any] = {"panel": line.panel, "label": _short(line.label), "of": line.of, "kind": line.kind}
        made |= {"t": self._time(time), "unit": 10**digits, "v": _whole(scaled[:, 0])}
        if line.band is not None:
            made["band"] = [_whole(scaled[:, 1]), _whole(scaled[:, 2])]
        return made

    def strip(self, strip: Strip, meanings: _Meanings) -> dict[str, Any]:
        time, codes = _broken_at_gaps(strip.time, strip.codes[:, None].astype(np.float64))
        if np.count_nonzero(np.diff(codes[:, 0])) > _MOST_RUNS:
            time, codes = decimate(time, codes, self._edges)
        row = codes[:, 0]
        begins = np.flatnonzero(~((row[1:] == row[:-1]) | (np.isnan(row[1:]) & np.isnan(row[:-1])))) + 1
        begins = np.concatenate([[0], begins])
        known = [meanings.number(strip, code) for code in row[begins]]
        return {
            "panel": strip.panel,
            "group": _short(strip.group),
            "of": strip.of,
            "t": self._time(np.append(time[begins], time[-1])),
            "c": known,
        }

    def curves(self, curves: Curves) -> dict[str, Any]:
        rows = np.arange(curves.time.size)
        if rows.size > _COARSE + _FINE:
            rows = last_of_buckets(curves.time, self._edges)
        made: dict[str, Any] = {
            "label": _short(curves.label),
            "of": curves.of,
            "kind": curves.kind,
            "t": self._time(curves.time[rows]),
        }
        for name, digits in _CURVE_DIGITS.items():
            made[name] = {"unit": 10**digits, "v": _whole(_scaled(curves.columns[name][rows], digits))}
        return made

    def _time(self, time: Array) -> int:
        """Return the number of these times."""
        ticks = np.rint(time * 10**_TIME_DIGITS).astype(np.int64)
        key = ticks.tobytes()
        if key not in self._known:
            self._known[key] = len(self.times)
            self.times.append(np.diff(ticks, prepend=0).tolist())
        return self._known[key]


class _Meanings:
    """What the codes of strips stand for, each with a tone of the page's colours."""

    def __init__(self, strips: Sequence[Strip]) -> None:
        """Give the most frequent reasons of each estimate tones of their own."""
        self._text_of_kind: dict[str, str] = {}
        counted: dict[str, Counter[str]] = {}
        for strip in strips:
            if strip.panel == "validity":
                codes, counts = np.unique(strip.codes, return_counts=True)
                for code, count in zip(codes[codes > 0.0], counts[codes > 0.0], strict=True):
                    counted.setdefault(strip.group, Counter())[self._text(strip, int(code))] += int(count)
        self._rank = {
            (group, text): rank
            for group, frequency in counted.items()
            for rank, (text, _) in enumerate(frequency.most_common())
        }
        self._numbers: dict[tuple[str, str], int] = {}
        self.listed: list[dict[str, str]] = []

    def number(self, strip: Strip, code: float) -> int | None:
        """Return the number of a code's meaning in `listed`; None for a code that means nothing."""
        if not isfinite(code) or int(code) not in strip.meanings:
            return None
        key = strip.group, self._text(strip, int(code))
        if key not in self._numbers:
            self._numbers[key] = len(self.listed)
            self.listed.append(
                {"group": _short(strip.group), "text": _short(key[1]), "tone": self._tone(strip, key[1])}
            )
        return self._numbers[key]

    def _text(self, strip: Strip, code: int) -> str:
        """Return a meaning; of reasons one text for all that differ in numbers only."""
        text = strip.meanings[code]
        return self._text_of_kind.setdefault(report_kind(text), text) if strip.panel == "validity" else text

    def _tone(self, strip: Strip, text: str) -> str:
        if strip.panel != "validity":
            return _STATE_TONES.get(text.partition(",")[0]) or _TONES.get(text, "none")
        rank = self._rank.get((strip.group, text), -1)
        return "good" if rank < 0 else f"reason{rank}" if rank < _REASON_TONES else "none"


def _broken_at_gaps(time: Array, columns: Array) -> tuple[Array, Array]:
    """Add a row of NaN in every gap of the messages."""
    steps = np.diff(time)
    if steps.size == 0:
        return time, columns
    gaps = np.flatnonzero(steps > max(_LONGEST_STEP, _USUAL_STEPS * float(np.median(steps)))) + 1
    if gaps.size == 0:
        return time, columns
    after = np.nextafter(time[gaps - 1], np.inf)
    return np.insert(time, gaps, after), np.insert(columns, gaps, np.nan, axis=0)


def _scaled(values: Array, digits: int) -> Array:
    """Return values in units of their last decimal, rounded; NaN for what is no number, or far from any that is."""
    with np.errstate(over="ignore", invalid="ignore"):
        scaled = np.rint(values * 10.0**digits)
        return np.where(np.abs(scaled) < _LARGEST, scaled, np.nan)


def _changing(scaled: Array) -> NDArray[np.bool_]:
    """Return which rows differ from the one before or the one after: the others change nothing in a picture."""
    same = np.all((scaled[1:] == scaled[:-1]) | (np.isnan(scaled[1:]) & np.isnan(scaled[:-1])), axis=1)
    kept = np.ones(scaled.shape[0], dtype=np.bool_)
    kept[1:-1] = ~(same[1:] & same[:-1])
    return kept


def _whole(scaled: Array) -> list[int | None]:
    missing = np.isnan(scaled)
    numbers: list[int | None] = np.where(missing, 0.0, scaled).astype(np.int64).tolist()
    for row in np.flatnonzero(missing):
        numbers[row] = None
    return numbers


def _panel(
    panel: Panel, run: RecordedRun, lines: Sequence[Line], drawn: Sequence[Line], brakings: Sequence[BrakingRow]
) -> dict[str, Any]:
    empty = [line for line in lines if line.panel == panel.key and not any(line is each for each in drawn)]
    remarks = [
        f"{line.label}: {_why_empty(run.series[line.topic], line.of, brakings)}" for line in empty if line.kind != "aim"
    ]
    made: dict[str, Any] = {"key": panel.key, "title": panel.title, "axis": panel.axis}
    return made | {"remarks": [_short(text) for text in remarks]}


def _absent(panel: Panel, run: RecordedRun, brakings: Sequence[BrakingRow]) -> str:
    """Return a panel's title, and why there is nothing to show: the reason of its first estimate, in brakings."""
    held = panel.holds.split(", ")
    for topic, series in run.series.items():
        of, _, name = topic.rpartition("/")
        if name in held and not topic.startswith("truth/"):
            return _short(f"{panel.title} ({_why_empty(series, of, brakings)})")
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
    return [[_short(name), _short(text)] for name, text in [*facts, *run.notes.items()]]


def _braking(row: BrakingRow) -> dict[str, Any]:
    parts = [
        {"of": part.of, "valid": _number(part.valid, 3), "reason": _short(part.reason)}
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
    made: dict[str, Any] = {"name": _short(topic), "messages": int(series.time.size)}
    return made | {"valid": share if share is None else round(share, 4), "reasons": [_short(text) for text in reasons]}


def _number(value: float, digits: int) -> float | None:
    return round(value, digits) if isfinite(value) else None


def _short(text: str) -> str:
    return text if len(text) <= _LONGEST_TEXT else text[: _LONGEST_TEXT - 1] + "…"


def _file(name: str) -> str:
    return files("friction_report").joinpath("web", name).read_text(encoding="utf-8")
