"""The parts of the evaluation, by name. Each is a module with `add_arguments(parser)` and `run(options) -> rows`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from importlib import import_module
from math import isfinite
from typing import Any, Protocol, cast, runtime_checkable

Row = dict[str, Any]
"""One flat row of a result: names and numbers or texts."""

PARTS = {
    "slope": "delay, false alarms and slip at detection of the slope sign, both methods, all surfaces",
    "abs": "closed loop with the supervisor: adhesion utilisation, stopping distance, wheel lock",
    "identification": "Monte Carlo of lambda_max: the chapter's methods and the default, beside the Cramer-Rao bound",
    "measured": "whole-vehicle fit on measured data: BMW stop, Putnam laps, tyre rig",
    "slip": "vehicle speed and slip without a speed sensor, simulated stops and the measured one",
    "smart_tyre": "Fz and Fx from the in-tyre accelerometer",
    "bags": "offline processing of bags: real-time factor, memory over length",
    "live": "the graph over DDS: lost samples, delay, agreement with the offline processors",
    "checkouts": "the estimates of two built checkouts over every bag, compared field by field",
    "report": "every table and figure of the chapter beside its own numbers, as one page",
}
"""Names and one-line descriptions."""

_MODULES = {"abs": "abs_loop"}
"""Modules whose name differs from the part's."""


def plain(row: Row) -> Row:
    """JSON has no NaN and no infinity: they become null and the text "inf"."""
    found: Row = {}
    for name, value in row.items():
        if hasattr(value, "item"):
            value = value.item()
        if isinstance(value, float) and not isfinite(value):
            value = None if value != value else ("inf" if value > 0 else "-inf")
        found[name] = value
    return found


class Part(Protocol):
    """A part of the evaluation."""

    def add_arguments(self, parser: argparse.ArgumentParser) -> None:
        """Add its own options."""

    def run(self, options: argparse.Namespace) -> Sequence[Row]:
        """Do it, with a progress bar, and return flat rows."""


@runtime_checkable
class JudgingPart(Part, Protocol):
    """A part whose rows are right or wrong. Its JSON file holds them as `rows`."""

    def failed(self, rows: Sequence[Row]) -> bool:
        """Are they wrong?"""


def part(name: str) -> Part:
    """Import a part when it is asked for: some need the middleware, some only numpy."""
    return cast(Part, import_module(f"friction_evaluation.{_MODULES.get(name, name)}"))
