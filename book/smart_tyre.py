"""Section 8.4: Figures 8.16 to 8.28, the forces beside their truth."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import groupby
from pathlib import Path

import numpy as np

from benchmarks.runner import Row, rows_of
from benchmarks.smart_tyre.runs import NOISY, STEADY, calibration_runs
from book.chapter_numbers import LENGTH_OF_PATCH, Spread, compared
from book.page import Picture, Section, Table
from book.smart_tyre_figures import CASE, draw

_TEXT = """The drives are simulated with a belt model, as neither recordings nor forces are published. Omega_0 of
the text, 10 ms at constant speed, is less than a revolution and is read as seconds. Removing the speed trend removes
the steady part of Fx (air drag, rolling); it is added again."""
_CAPTIONS = {
    "figure_8_16": "Figure 8.16: raw radial acceleration in the tyre over 0.7 s: constant but for a twin spike"
    " at each passage of the contact patch",
    "figure_8_18": "Figure 8.18: voltage of the wheel encoder, wheel speed, and wheel angle interpolated between teeth",
    "figure_8_19": "Figure 8.19: one revolution over the wheel angle, shifted and scaled to a fall of 1 in the patch:"
    " the fronts are its zeros, the dotted line is what the detection makes of them",
    "figure_8_20": "Figure 8.20: a dynamic drive, rear wheel, as measured: speed, shift and length of the patch."
    " Shift and length follow acceleration and braking (grey); at constant speed they differ by the trend alone",
    "figure_8_21": "Figure 8.21: shift and length over speed in slow drives up and down, with the second-order maps",
    "figure_8_22": "Figure 8.22: rear wheel without the speed trend: at constant speed shift and length return to the"
    " dashed lines",
    "figure_8_23": "Figure 8.23: front wheel without the speed trend: in the acceleration a small shift is left, though"
    " the front wheels drive nothing",
    "figure_8_24": "Figure 8.24: that acceleration in detail, front wheel, before and after the correction (8.19)",
    "figure_8_25": "Figure 8.25: rear wheel, 2.0 bar, all corrections: forward and longer in acceleration, back and"
    " shorter in braking",
    "figure_8_26": "Figure 8.26: front wheel, 2.0 bar: no shift and a shorter patch in acceleration, back and longer in"
    " braking",
    "figure_8_27": "Figure 8.27: rear wheel at 1.6 bar, not calibrated anew: the patch is longer, the shift alike",
    "figure_8_28": "Figure 8.28: front wheel at 1.6 bar, not calibrated anew",
    "figure_forces": "Beyond the chapter: Fx and Fz of a front and a rear wheel from shift and length (2.0 bar), beside"
    " the truth of the simulation",
}


def section(pictures: Path, seeds: Callable[[int], int]) -> Section:
    """Make the runs and draw into `pictures`."""
    drawn = draw(pictures, calibration_runs(NOISY))
    rows = [*rows_of("benchmarks", "smart_tyre", "--seeds", str(seeds(30))), *drawn]
    title = "Contact forces from the smart tyre, Figures 8.16 to 8.28"
    shown = [Picture(caption, pictures / f"{name}.png") for name, caption in _CAPTIONS.items()]
    return Section("8.4", title, _TEXT, list(tables(rows)), shown, numbers(drawn))


def numbers(drawn: Sequence[Row]) -> list[Row]:
    """Compare the length of the patch at constant speed, over both axles."""
    ends = tuple(f"corrected: length, {phase} [deg]" for phase in STEADY)
    lengths = [
        row["value"] for row in drawn if row["quantity"].startswith("2.0 bar") and row["quantity"].endswith(ends)
    ]
    ours = Spread(min(lengths), float(np.median(lengths)), max(lengths))
    return [compared("Figures 8.22, 8.23", "length of the patch at constant speed [deg]", LENGTH_OF_PATCH, ours)]


def tables(rows: Sequence[Row]) -> list[Table]:
    """One table of what has to hold, and the rest folded by case, with the axles side by side."""
    judged = [row for row in rows if row.get("passed") is not None]
    found = [Table("Fz and Fx against the limits of the project", _by_axle(judged))]
    for case, group in groupby(sorted(rows, key=lambda row: str(row["case"])), key=lambda row: str(row["case"])):
        shown = [{k: v for k, v in row.items() if k != "case"} for row in _by_axle(list(group))]
        title = "what the figures show" if case == CASE else case
        found.append(Table(f"Smart tyre: {title} ({len(shown)} rows)", shown, folded=True))
    return found


def _by_axle(rows: Sequence[Row]) -> list[Row]:
    found: dict[tuple[str, str], Row] = {}
    for row in rows:
        line = found.setdefault(
            (row["case"], row["quantity"]), {"case": row["case"], "quantity": row["quantity"], "limit": row["limit"]}
        )
        line[str(row["axle"])] = row["value"]
        if row.get("passed") is not None:
            line["passed"] = bool(row["passed"]) and line.get("passed", True)
    order = ("case", "quantity", "front", "rear", "both", "all", "limit", "passed")
    return [{name: line[name] for name in order if name in line} for line in found.values()]
