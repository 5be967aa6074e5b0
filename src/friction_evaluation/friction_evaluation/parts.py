"""The parts of the evaluation, by name.

Each is a subpackage whose module `part` has `add_arguments(parser)` and `run(options) -> rows`.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from importlib import import_module
from typing import Protocol, cast

from friction_evaluation.rows import Row

PARTS = {
    "slope": "delay, false alarms and slip at detection of the slope sign, both methods, all surfaces",
    "abs": "closed loop with the supervisor: adhesion utilisation, stopping distance, wheel lock",
    "faults": "campaign of faults in closed loop: what each does to the stop, and whether the limits hold",
    "identification": "Monte Carlo of lambda_max: the chapter's methods and the default, beside the Cramer-Rao bound",
    "real_car": "friction curves of cars that are not known exactly, on a plant of its own",
    "measured": "whole-vehicle fit on measured data: BMW stop, Putnam laps, tyre rig",
    "slip": "vehicle speed and slip without a speed sensor, simulated stops and the measured one",
    "smart_tyre": "Fz and Fx from the in-tyre accelerometer",
    "fuzz": "hostile messages into every processor: exceptions, valid nonsense, recovery",
    "doctor": "the doctor: sabotaged drives named, healthy ones without alarm, accuracy of what it learns",
    "bags": "offline processing of bags: real-time factor, memory over length",
    "live": "the graph over DDS: lost samples, delay, agreement with the offline processors",
    "soak": "the whole graph with tyres over DDS for minutes: memory, threads, descriptors, lost samples, delays",
    "checkouts": "the estimates of two built checkouts over every bag, compared field by field",
    "report": "every table and figure of the chapter beside its own numbers, as one page",
}
"""Names and one-line descriptions."""

_SUBPACKAGES = {"abs": "closed_loop"}
"""Subpackages whose name differs from the part's."""


class Part(Protocol):
    """A part of the evaluation."""

    def add_arguments(self, parser: argparse.ArgumentParser) -> None:
        """Add its own options."""

    def run(self, options: argparse.Namespace) -> Sequence[Row]:
        """Do it, with a progress bar, and return flat rows; what has to hold is in their `passed` (rows.py)."""


def part(name: str) -> Part:
    """Import a part when it is needed: some need the middleware, some only numpy."""
    return cast(Part, import_module(f"friction_evaluation.{_SUBPACKAGES.get(name, name)}.part"))
