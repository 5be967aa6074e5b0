"""Lines, strips, curves, signals and the track of a run in few numbers, as the JSON of the page holds them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from math import ceil, isfinite, log10
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_bags.results.recorded_run import Array
from friction_report.drive_series import Curves, Line, Strip, Track
from friction_report.signals import Points, Signal
from friction_report.thinning import bucket_edges, decimate, last_of_buckets
from friction_runtime.reports import report_kind

_COARSE, _FINE = 2000, 6000
"""Buckets over the whole drive, and in its brakings: with both, an hour of four wheels stays below 20 MB."""
_MOST_POINTS = 2 * (_COARSE + _FINE)
"""Points of a line that are kept as they are."""
_SIGNAL_POINTS = 600_000
"""Points of all signals of one's own choice together: below 6 MB."""
_SIGNAL_FIGURES = 5
"""Significant figures of the largest value of a signal."""
_MOST_DECIMALS = 9
_POINT_DIGITS = 4
_MOST_RUNS = 6000
"""Changes of a strip that are kept as they are."""
TIME_DIGITS = 4
_LONGEST_STEP = 1.0
"""Time [s] without a message that breaks a line, if it is also long beside the usual step."""
_USUAL_STEPS = 10.0
_LARGEST = 2.0**53
"""Beyond it JSON's readers know no whole numbers; nothing that is measured comes near."""
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


class Thinning:
    """Lines, strips, curves and signals in few numbers; those with the same times share them."""

    def __init__(self, start: float, end: float, brakings: Sequence[tuple[float, float]], signals: int) -> None:
        """Divide a drive.

        Args:
            start: its begin [s].
            end: its end [s].
            brakings: begin and end [s] of each.
            signals: number of signals, which share `_SIGNAL_POINTS`.
        """
        self._edges = bucket_edges(start, end, brakings, _COARSE, _FINE)
        self._of_signal = min(_MOST_POINTS, _SIGNAL_POINTS // max(signals, 1))
        buckets = max(self._of_signal // 4, 1)  # over the drive, as many in its brakings: two points of each
        self._signal_edges = bucket_edges(start, end, brakings, buckets, buckets)
        self._known: dict[bytes, int] = {}
        self.times: list[list[int]] = []
        """Times in units of 0.1 ms: the first, then the steps."""

    def line(self, line: Line, digits: int) -> dict[str, Any]:
        """Return a line with values of so many decimals."""
        columns = np.stack([line.values, *(line.band or ())], axis=1)
        time, scaled = self._few(line.time, columns, digits, _MOST_POINTS, self._edges)
        made: dict[str, Any] = {"panel": line.panel, "label": short(line.label), "of": line.of, "kind": line.kind}
        made |= {"t": self._time(time), "unit": 10**digits, "v": _whole(scaled[:, 0])}
        if line.band is not None:
            made["band"] = [_whole(scaled[:, 1]), _whole(scaled[:, 2])]
        return made

    def signal(self, signal: Signal) -> dict[str, Any]:
        """Return a signal with as many decimals as its largest value needs."""
        digits = _decimals(signal.values)
        time, scaled = self._few(signal.time, signal.values[:, None], digits, self._of_signal, self._signal_edges)
        made: dict[str, Any] = {"topic": short(signal.topic), "field": signal.field}
        return made | {"t": self._time(time), "unit": 10**digits, "v": _whole(scaled[:, 0])}

    def points(self, points: Points) -> dict[str, Any]:
        """Return measured points, every n-th of those that are too many."""
        rows = np.flatnonzero(np.isfinite(points.slip) & np.isfinite(points.mu))
        rows = rows[:: ceil(max(rows.size, 1) / _COARSE)]
        made: dict[str, Any] = {"label": short(points.label), "about": points.about, "of": points.of}
        made |= {"kind": points.kind, "t": self._time(points.time[rows])}
        for name, values in (("slip", points.slip), ("mu", points.mu)):
            made[name] = {"unit": 10**_POINT_DIGITS, "v": _whole(_scaled(values[rows], _POINT_DIGITS))}
        return made

    def strip(self, strip: Strip, meanings: Meanings) -> dict[str, Any]:
        """Return a strip as its changes."""
        time, codes = _broken_at_gaps(strip.time, strip.codes[:, None].astype(np.float64))
        if np.count_nonzero(np.diff(codes[:, 0])) > _MOST_RUNS:
            time, codes = decimate(time, codes, self._edges)
        row = codes[:, 0]
        begins = np.flatnonzero(~((row[1:] == row[:-1]) | (np.isnan(row[1:]) & np.isnan(row[:-1])))) + 1
        begins = np.concatenate([[0], begins])
        known = [meanings.number(strip, code) for code in row[begins]]
        return {
            "panel": strip.panel,
            "group": short(strip.group),
            "of": strip.of,
            "t": self._time(np.append(time[begins], time[-1])),
            "c": known,
        }

    def curves(self, curves: Curves) -> dict[str, Any]:
        """Return the parameters of curves, of too many the last one of each bucket."""
        rows = np.arange(curves.time.size)
        if rows.size > _COARSE + _FINE:
            rows = last_of_buckets(curves.time, self._edges)
        made: dict[str, Any] = {
            "label": short(curves.label),
            "of": curves.of,
            "kind": curves.kind,
            "t": self._time(curves.time[rows]),
        }
        for name, digits in _CURVE_DIGITS.items():
            made[name] = {"unit": 10**digits, "v": _whole(_scaled(curves.columns[name][rows], digits))}
        return made

    def track(self, track: Track) -> dict[str, Any]:
        """Return a track, every n-th place of those that are too many."""
        rows = np.flatnonzero(np.isfinite(track.east))
        rows = rows[:: ceil(max(rows.size, 1) / _FINE)]
        made: dict[str, Any] = {"t": self._time(track.time[rows])}
        for name, values, digits in (("east", track.east, 1), ("north", track.north, 1)):
            made[name] = {"unit": 10**digits, "v": _whole(_scaled(values[rows], digits))}
        for name, values in track.values.items():
            made[name] = {"unit": 10**_POINT_DIGITS, "v": _whole(_scaled(values[rows], _POINT_DIGITS))}
        return made

    def _few(self, time: Array, columns: Array, digits: int, most: int, edges: Array) -> tuple[Array, Array]:
        """Return times, and columns in units of the last decimal, of the points that a picture needs."""
        time, columns = _broken_at_gaps(time, columns)
        if time.size > most:
            time, columns = decimate(time, columns, edges)
        scaled = _scaled(columns, digits)
        kept = _changing(scaled)
        return (time[kept], scaled[kept]) if 2 * np.count_nonzero(kept) < time.size else (time, scaled)

    def _time(self, time: Array) -> int:
        """Return the number of these times."""
        ticks = np.rint(time * 10**TIME_DIGITS).astype(np.int64)
        key = ticks.tobytes()
        if key not in self._known:
            self._known[key] = len(self.times)
            self.times.append(np.diff(ticks, prepend=0).tolist())
        return self._known[key]


class Meanings:
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
            self.listed.append({"group": short(strip.group), "text": short(key[1]), "tone": self._tone(strip, key[1])})
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


def _decimals(values: Array) -> int:
    """Return the decimals that give the largest value `_SIGNAL_FIGURES` figures; a whole number has none."""
    finite = np.abs(values[np.isfinite(values) & (np.abs(values) < _LARGEST)])
    if not finite.size or np.all(finite == np.rint(finite)):
        return 0
    return int(np.clip(_SIGNAL_FIGURES - ceil(log10(float(np.max(finite)))), 0, _MOST_DECIMALS))


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


def short(text: str) -> str:
    """Return a text of a bag, cut where it is very long."""
    return text if len(text) <= _LONGEST_TEXT else text[: _LONGEST_TEXT - 1] + "…"
