"""The estimators as a process each and in one process, side by side: cost, delays, losses, growth; beside relays.

Machines differ, and so does one machine from minute to minute: the forms take turns, and ratios are judged.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from itertools import product
from pathlib import Path

import numpy as np
from rich.progress import Progress

from benchmarks.protocol import VEHICLE
from benchmarks.runner import Row, at_most, not_judged
from campaigns.live.recorded_run import (
    ESTIMATES,
    FORMS,
    SEPARATE,
    SEPARATE_RELAYS,
    SOURCE,
    Drive,
    Measured,
    record,
    run,
)
from friction_bringup import graph

ROUNDS = 3
"""How often the forms take turns."""
FOUR_WHEELS = Drive("smart_tyre_car", ("/car",), "car", tyres=True)
GROWTH = {
    1: Drive(VEHICLE, ("/car",), "single_corner", tyres=False),
    4: Drive("compact_car", ("/car",), "car", tyres=False),
    8: Drive("compact_car", ("/first", "/second"), "car", tyres=False),
}
"""By the number of wheels; eight are those of two cars, each with processes of its own."""
RATES = (100.0, 200.0, 500.0)
_GROWTH_SECONDS = 10.0
"""Wall time of each run of the growth [s]."""
_LEAST_OF_SEPARATE = 0.55
_LEAST_OF_RELAYS = 1.3
_DELAY_OF_SEPARATE = 0.7
_DELAY_OF_RELAYS = 3.0


def comparison_rows(seconds: float) -> list[Row]:
    """Run four wheels with smart tyres at 200 Hz for `seconds` [s] in each form; a row a run, then the rules."""
    found: dict[str, list[Row]] = {form: [] for form in FORMS}
    with tempfile.TemporaryDirectory(prefix="friction_recording_") as directory, Progress() as progress:
        bag = Path(directory, "bag")
        task = progress.add_task("recording", total=None)
        record(FOUR_WHEELS, seconds, bag)
        for number, form in product(range(ROUNDS), FORMS):
            progress.update(task, description=f"round {number + 1}, {form}", total=200.0 * seconds)
            measured = run(FOUR_WHEELS, bag, form, 200.0, seconds, True, _shown_in(progress, task))
            found[form].append({"run": form, "round": number + 1, **run_row(measured, [*ESTIMATES, graph.COMMAND])})
    return [*(row for form in FORMS for row in found[form]), *judged_rows(found)]


def latency_rows(seconds: float) -> list[Row]:
    """Run four wheels at 200 Hz for `seconds` [s] as separate nodes, then as relays of them; a row each, and the rule.

    The relays have the same hops from the sensors to the command, and compute nothing.
    """
    delay, found = f"{graph.COMMAND}_p99_ms", []
    with tempfile.TemporaryDirectory(prefix="friction_recording_") as directory, Progress() as progress:
        bag = Path(directory, "bag")
        task = progress.add_task("recording", total=None)
        record(GROWTH[4], seconds, bag)
        for form in (SEPARATE, SEPARATE_RELAYS):
            progress.update(task, description=form, total=200.0 * seconds)
            measured = run(GROWTH[4], bag, form, 200.0, seconds, True, _shown_in(progress, task))
            found.append({"run": form, **run_row(measured, [graph.COMMAND])})
    return [*found, over_relays(*(row[delay] for row in found))]


def over_relays(nodes: float, relays: float) -> Row:
    """Return the row of the 99th percentile of the delays from sensors to command, of nodes and of relays [ms]."""
    quantity = "99 % of the delays from sensors to command, over that of relays"
    return {"run": SEPARATE, "quantity": quantity, **at_most(nodes / relays, _DELAY_OF_RELAYS)}


def _shown_in(progress: Progress, task: object) -> Callable[[int], None]:
    return lambda count: progress.update(task, completed=count)  # type: ignore[arg-type]


def run_row(measured: Measured, answers: Sequence[str]) -> Row:
    """Columns of one run: processor time of the estimators, delays behind the sample, answers that are missing."""
    of_estimators = [share for name, share in measured.processor.items() if name not in (graph.SUPERVISOR, "player")]
    row: Row = {"cpu_percent": 100.0 * sum(of_estimators)}
    if graph.SUPERVISOR in measured.processor:
        row["supervisor_percent"] = 100.0 * measured.processor[graph.SUPERVISOR]
    sources = {topic.removesuffix(SOURCE): each for topic, each in measured.answers.items() if topic.endswith(SOURCE)}
    row["samples"] = sum(len(source.published) for source in sources.values())
    for name in answers:
        missing, delays = 0, [np.empty(0)]
        for topic, each in measured.answers.items():
            if topic.endswith(f"/{name}"):
                (source,) = (sent for place, sent in sources.items() if topic.startswith(place))
                missing += len(source.published.keys() - each.published.keys())
                delays.append(each.delays(source))
        together = np.concatenate(delays)
        row[f"{name}_lost"] = missing
        for what, share in (("median", 50.0), ("p99", 99.0), ("max", 100.0)):
            row[f"{name}_{what}_ms"] = float(np.percentile(together, share)) if together.size else float("nan")
    return row


def judged_rows(found: Mapping[str, Sequence[Row]]) -> list[Row]:
    """Rows of what must hold of the medians over the rounds; `found` are the rows of each form."""

    def median(form: str, name: str) -> float:
        return float(np.median([row[name] for row in found[form]]))

    cpu = {form: median(form, "cpu_percent") for form in FORMS}
    of_separate, of_relays = cpu["composed"] / cpu["separate"], cpu["composed"] / cpu["relays"]
    delay = f"{graph.COMMAND}_p99_ms"
    lost = sum(value for row in found["composed"] for name, value in row.items() if name.endswith("_lost"))
    return [
        {"run": "composed", "quantity": "cpu over that of separate nodes", **not_judged(of_separate)},
        {"run": "composed", "quantity": "cpu over that of its relays", **not_judged(of_relays)},
        {
            "run": "composed",
            "quantity": f"the better of the two over {_LEAST_OF_SEPARATE} and {_LEAST_OF_RELAYS}",
            **at_most(min(of_separate / _LEAST_OF_SEPARATE, of_relays / _LEAST_OF_RELAYS), 1.0),
        },
        {
            "run": "composed",
            "quantity": "99 % of the delays from sensors to command, over that of separate nodes",
            **at_most(median("composed", delay) / median("separate", delay), _DELAY_OF_SEPARATE),
        },
        {"run": "composed", "quantity": "answers lost", **at_most(lost, 0)},
    ]


def growth_rows() -> list[Row]:
    """Run 1, 4 and 8 wheels without smart tyres at 100, 200 and 500 Hz, separate and composed; a row a run."""
    rows: list[Row] = []
    with tempfile.TemporaryDirectory(prefix="friction_recording_") as directory, Progress() as progress:
        task = progress.add_task("growth", total=None)
        for wheels, drive in GROWTH.items():
            bag = Path(directory, f"bag_{wheels}")
            record(drive, _GROWTH_SECONDS * max(RATES) / 200.0, bag)
            for rate, form in product(RATES, FORMS[:2]):
                progress.update(task, description=f"growth: {wheels} wheels, {rate:.0f} Hz, {form}")
                measured = run(drive, bag, form, rate, _GROWTH_SECONDS * rate / 200.0, False, lambda _: None)
                rows.append({"run": form, "wheels": wheels, "rate_hz": rate, **run_row(measured, list(ESTIMATES))})
    return rows
