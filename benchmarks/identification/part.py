"""Identification of lambda_max over manoeuvres, surfaces and methods, beside the Cramer-Rao bound.

Studies: methods (the table of all methods), random (500 random curves), alarms (P(beyond the peak) against the true
crossing), model_error (bias by wrong parameters), outliers, surface_change.
"""

import argparse
from collections.abc import Callable

from benchmarks.identification import studies
from benchmarks.identification.surface_change import surface_change
from benchmarks.protocol import RAMP_TIMES
from benchmarks.rows import Row
from friction_curve_id.chapter.friction_samples import FrictionSource
from friction_curve_id.methods import METHODS
from friction_parameters.command_line import count

_STUDIES: dict[str, Callable[[argparse.Namespace], list[Row]]] = {
    "methods": studies.methods,
    "random": studies.random_curves,
    "alarms": studies.alarms,
    "model_error": studies.model_error,
    "outliers": studies.outliers,
    "surface_change": surface_change,
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this part."""
    parser.add_argument("--study", choices=_STUDIES, default="methods", help="what to study (default: methods)")
    parser.add_argument("--manoeuvre", choices=RAMP_TIMES, default="B", help="torque ramp: A 0.5 s, B 0.25 s, C 0.1 s")
    parser.add_argument("--seeds", type=count, default=500, help="noise seeds a surface")
    parser.add_argument("--methods", nargs="+", choices=METHODS, default=list(METHODS), help="for the study 'methods'")
    parser.add_argument(
        "--source",
        choices=[source.value for source in FrictionSource],
        default=FrictionSource.DEAD_RECKONED.value,
        help="how the chapter's methods make their friction samples",
    )
    parser.add_argument("--processes", type=count, default=2, help="processes that share the runs")


def run(options: argparse.Namespace) -> list[Row]:
    """Make the study and return its rows."""
    return _STUDIES[options.study](options)
