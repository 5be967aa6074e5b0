"""Soak: memory, threads, descriptors, lost samples and delays of the whole graph, lap after lap."""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from math import ceil

import numpy as np
from rich.progress import Progress

from benchmarks.runner import Row, at_least, at_most, not_judged
from campaigns.dds import ProcessUse
from campaigns.soak.graph import Answers, SoakError, SoakGraph, together
from friction_parameters.command_line import positive

_INTERVAL = 60.0
"""Length of an interval in the table [s, wall clock]."""
_LEAST_LAPS = 3
_WARM_UP = 0.2
"""Share of the laps in which memory, threads and descriptors may still grow; at least the first lap."""
_JUDGED_FROM = 300.0
"""Least time after the warm-up from which the growth of the memory is judged [s]: pages come in steps."""
_FASTEST_GROWTH = 6.0
"""Largest growth of the memory of a process [MB/h]. A hundred bytes for each sample of a wheel would be 70."""
_MEGABYTE = 1e6
_HOUR = 3600.0


@dataclass(frozen=True)
class Lap:
    """One lap, and what the processes held at its end."""

    ended: float
    """Time since the begin of the first lap [s, wall clock]."""
    answers: Mapping[str, Answers]
    """By topic."""
    uses: Mapping[str, ProcessUse]
    """By node."""
    load: float
    """Mean number of runnable threads of the machine over the last minute."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this part."""
    parser.add_argument("--minutes", type=positive, default=20.0, help="length [min]; at least three laps of 6 s")


def run(options: argparse.Namespace) -> list[Row]:
    """Run the graph; return rows of each interval, then those that have to hold."""
    laps: list[Lap] = []
    packets = patches = 0
    problem = ""
    with SoakGraph() as graph, Progress() as progress:
        task = progress.add_task("soak", total=options.minutes * 60.0)
        begun = time.monotonic()
        try:
            while len(laps) < _LEAST_LAPS or time.monotonic() - begun < options.minutes * 60.0:
                answers = graph.lap()
                laps.append(Lap(time.monotonic() - begun, answers, graph.use(), os.getloadavg()[0]))
                packets += graph.lost_packets
                progress.update(task, completed=laps[-1].ended)
        except SoakError as error:
            problem = str(error)
        patches = graph.patches
    rows = _interval_rows(laps)
    rows.append({"quantity": "laps that failed", **at_most(int(bool(problem)), 0), "text": problem, "laps": len(laps)})
    rows.append({"quantity": "contact patches", **at_least(patches, 1)})
    rows.append({"quantity": "contact patches that lack blocks", **at_most(packets, 0)})
    return rows + lost_rows(laps) + use_rows(laps)


def lost_rows(laps: Sequence[Lap]) -> list[Row]:
    """Return a row for each topic with the samples that have no answer in all laps."""
    return [
        {"topic": topic, "quantity": "lost", **at_most(found.lost, 0), **_delays(found)}
        for topic in (laps[0].answers if laps else ())
        for found in [together([lap.answers[topic] for lap in laps])]
    ]


def use_rows(laps: Sequence[Lap]) -> list[Row]:
    """Return three rows for each process: growth of its memory, changes of the number of threads and descriptors."""
    judged = laps[max(1, ceil(_WARM_UP * len(laps))) :]
    if not judged:
        return []
    long_enough = judged[-1].ended - judged[0].ended >= _JUDGED_FROM
    rows: list[Row] = []
    for process in judged[0].uses:
        uses = [lap.uses[process] for lap in judged]
        growth = _growth([lap.ended for lap in judged], [use.rss for use in uses])
        for quantity, result in (
            ("growth of the memory [MB/h]", at_most(growth, _FASTEST_GROWTH) if long_enough else not_judged(growth)),
            ("change of the threads", at_most(_change([use.threads for use in uses]), 0)),
            ("change of the descriptors", at_most(_change([use.descriptors for use in uses]), 0)),
        ):
            rows.append({"process": process, "quantity": quantity, **result})
    return rows


def _interval_rows(laps: Sequence[Lap]) -> list[Row]:
    rows: list[Row] = []
    for _, group in groupby(laps, key=lambda lap: lap.ended // _INTERVAL):
        within = list(group)
        last = within[-1]
        interval = {"until_s": round(last.ended), "laps": len(within), "load": last.load}
        for topic in last.answers:
            found = together([lap.answers[topic] for lap in within])
            rows.append({**interval, "topic": topic, "quantity": "lost", **not_judged(found.lost), **_delays(found)})
        for process, use in last.uses.items():
            rows.append(
                {
                    **interval,
                    "process": process,
                    "rss_mb": round(use.rss / _MEGABYTE, 2),
                    "threads": use.threads,
                    "descriptors": use.descriptors,
                }
            )
    return rows


def _delays(found: Answers) -> Row:
    if not len(found.delays):
        return {}
    return {
        "samples": found.samples,
        "delay_median_ms": float(np.median(found.delays)),
        "delay_p99_ms": float(np.percentile(found.delays, 99.0)),
        "delay_max_ms": float(found.delays.max()),
    }


def _growth(times: Sequence[float], rss: Sequence[int]) -> float:
    """Slope [MB/h] of the straight line through the memory [B] at some times [s]."""
    if len(rss) < 2:
        return 0.0
    return float(np.polyfit(np.array(times) / _HOUR, np.array(rss) / _MEGABYTE, 1)[0])


def _change(numbers: Sequence[int]) -> int:
    return max(numbers) - min(numbers)
