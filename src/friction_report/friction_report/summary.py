"""Summary that is printed at the end of a run."""

from __future__ import annotations

import numpy as np
from friction_msgs.msg import BrakeCommand, SupervisorState
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from friction_bags.results.recorded_run import CrossingEvent, RecordedRun
from friction_report.braking_metrics import (
    Braking,
    JudgedCrossing,
    judge_crossings,
    measure_braking,
    release_times,
    right_signs,
)
from friction_runtime.reports import plain_reason

_SHOWN_CROSSINGS = 16
_SHOWN_REASONS = 3
_ENDING_LIMITS = (SupervisorState.LIMIT_NO_SPIN_UP, SupervisorState.LIMIT_BUDGET, SupervisorState.LIMIT_RETURN)
"""In force from the end of a release until the pressure is back."""


def print_summary(console: Console, run: RecordedRun) -> None:
    """Print crossings and utilisation where the truth is known, releases, and validity everywhere."""
    for wheel in run.wheels:
        curve, truth = run.get(f"truth/{wheel}/friction_curve"), run.crossings(f"truth/{wheel}/friction_slope")
        if curve is not None:
            found = run.crossings(f"{wheel}/friction_slope")
            judged = judge_crossings(found, truth, curve.time, curve["lambda_max"])
            console.print(crossing_table(wheel, judged, truth))
            console.print(sign_text(run, wheel))
    braking = braking_of(run)
    if isinstance(braking, Braking):
        console.print(braking_table(braking))
    else:
        console.print(f"Stopping distance and utilisation: {braking}.")
    console.print(release_table(run))
    console.print(validity_table(run))


def braking_of(run: RecordedRun) -> Braking | str:
    """Measure the braking of a run by its truth, or return why that is not possible."""
    speed, demand = run.get("truth/vehicle_velocity"), run.get("brake_demand")
    curves = [curve for wheel in run.wheels if (curve := run.get(f"truth/{wheel}/friction_curve")) is not None]
    if speed is None or len(curves) != len(run.wheels):
        return "no truth in this bag (a measured one has none), so there is no ideal to compare with"
    if demand is None or not np.any(demand["pressure"] > 0.0):
        return "the driver never braked"
    time = speed.time
    mu, mu_max = (np.mean([np.interp(time, c.time, c[name]) for c in curves], axis=0) for name in ("mu", "mu_max"))
    onset = float(demand.time[np.argmax(demand["pressure"] > 0.0)])
    try:
        return measure_braking(time, speed["twist.twist.linear.x"], mu, mu_max, onset)
    except ValueError as error:
        return str(error)


def crossing_table(wheel: str, crossings: list[JudgedCrossing], truth: list[CrossingEvent]) -> Table:
    """Return a table of the first detected crossings beside the true ones, with the count of all."""
    shown = "" if len(crossings) <= _SHOWN_CROSSINGS else f", the first {_SHOWN_CROSSINGS} of {len(crossings)}"
    table = Table(title=f"{wheel}: crossings of the peak of the friction curve{shown}", title_justify="left")
    for heading in ("detected at [s]", "crossing", "slip at crossing", "true λ_max", "error", "delay [ms]"):
        table.add_column(escape(heading), justify="left" if heading == "crossing" else "right")
    for crossing in crossings[:_SHOWN_CROSSINGS]:
        table.add_row(
            f"{crossing.estimate.time:.3f}",
            "peak passed" if crossing.estimate.sign < 0 else "regained",
            f"{crossing.estimate.slip:.3f}",
            f"{crossing.lambda_max:.3f}",
            f"{crossing.relative_error:+.0%}",
            f"{1e3 * crossing.delay:.0f}" if np.isfinite(crossing.delay) else "no true one",
        )
    counts = [_told(crossings, truth, sign, word) for sign, word in ((-1, "peak passed"), (1, "regained"))]
    table.caption = "\n".join(counts)
    return table


def _told(crossings: list[JudgedCrossing], truth: list[CrossingEvent], sign: int, word: str) -> str:
    """Count the crossings of one sign: true, detected and without a true one, with the median delay."""
    found = np.array([crossing.delay for crossing in crossings if crossing.estimate.sign == sign])
    near = found[np.isfinite(found)]
    delay = f"median delay {1e3 * np.median(near):.0f} ms" if near.size else "no delay"
    total = sum(event.sign == sign for event in truth)
    return f"{word}: {near.size} of {total} true ones found ({delay}), {found.size - near.size} without a true one"


def sign_text(run: RecordedRun, wheel: str) -> str:
    """Return how many of the valid slope signs of a wheel are the true ones `delay` before their stamps."""
    found, truth = run.get(f"{wheel}/friction_slope"), run.get(f"truth/{wheel}/friction_slope")
    if found is None or truth is None:
        return ""
    valid, right = right_signs(
        found.time, found["sign"], found["valid"] > 0.0, found["delay"], truth.time, truth["sign"]
    )
    return f"{wheel}: {right} of {valid} valid slope signs are the true ones" if valid else f"{wheel}: no valid sign"


def braking_table(braking: Braking) -> Table:
    """Return a table of stopping distance and adhesion utilisation."""
    table = Table(
        title=f"Braking from {braking.initial_speed:.1f} to {braking.end_speed:.1f} m/s", title_justify="left"
    )
    table.add_column("quantity")
    table.add_column("value", justify="right")
    table.add_row("time", f"{braking.duration:.2f} s")
    table.add_row("distance", f"{braking.distance:.1f} m")
    table.add_row("ideal distance (mu = mu_max throughout)", f"{braking.ideal_distance:.1f} m")
    table.add_row("longer than the ideal", f"{braking.distance / braking.ideal_distance - 1.0:+.1%}")
    table.add_row("adhesion utilisation, mean mu / mu_max", f"{braking.utilisation:.3f}")
    table.add_row("the same without the first 0.4 s", f"{braking.utilisation_built_up:.3f}")
    return table


def release_table(run: RecordedRun) -> Table:
    """Return a table of what the intervention did with the releases that the law of each wheel asked for."""
    commanded = any(run.get(f"{wheel}/brake_command") is not None for wheel in run.wheels)
    title = "Releases of the brake" if commanded else "Releases of the brake that would be commanded: shadow mode"
    table = Table(title=title, title_justify="left")
    table.add_column("wheel")
    for heading in ("released [s]", "longest [s]", "refused", "ended by a limit"):
        table.add_column(escape(heading), justify="right")
    for wheel in run.wheels:
        if (series := run.get(f"{wheel}/abs_supervisor")) is None:
            continue
        times = release_times(series.time, series["command"] == BrakeCommand.DECREASE)
        refused, capped = series["refused_releases"][-1], np.isin(series["limit"], _ENDING_LIMITS)
        ended = np.count_nonzero(np.diff(capped, prepend=False) & capped)
        table.add_row(wheel, f"{np.sum(times):.2f}", f"{np.max(times, initial=0.0):.2f}", f"{refused:.0f}", str(ended))
    return table


def validity_table(run: RecordedRun) -> Table:
    """Return a table of the valid share of each estimate, with the reasons for the rest."""
    table = Table(title="What was estimated, and what could not be", title_justify="left")
    table.add_column("topic", no_wrap=True)
    table.add_column("messages", justify="right")
    table.add_column("valid", justify="right")
    table.add_column("why not (most frequent first)")
    for topic, series in sorted(run.series.items()):
        if topic.startswith("truth/") or "valid" not in series.columns:
            continue
        wheel = topic.split("/")[0]
        reasons = [f"{plain_reason(text, wheel)} ({n})" for text, n in series.reasons.most_common(_SHOWN_REASONS)]
        table.add_row(topic, str(series.time.size), f"{np.mean(series['valid']):.1%}", escape("\n".join(reasons)))
    return table
