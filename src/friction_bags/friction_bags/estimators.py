"""The estimators of the graph and how each is built from parameter files, as its node is."""

from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import yaml

from friction_runtime.parameters import ParameterError, from_mapping, shipped_file
from friction_runtime.processor import Processor, Report

_PARAMETERS = {
    "wheel_slip": "WheelSlipParameters",
    "friction_slope": "FrictionSlopeParameters",
    "friction_curve_id": "FrictionCurveParameters",
    "abs_supervisor": "SupervisorParameters",
    "smart_tyre_forces": "SmartTyreParameters",
}
ESTIMATORS = tuple(_PARAMETERS)
"""In the order in which data flows. Package, node and parameter file have one name; `build` of the module `processor`
makes the processors from the parameters. Only what is asked for is imported: all of it takes a second."""
SMART_TYRE = "smart_tyre_forces"
WHEEL_ESTIMATORS = tuple(name for name in ESTIMATORS if name != SMART_TYRE)
"""Those that live on wheel_states."""


def build_processors(
    estimators: Sequence[str], wheels: Sequence[str], files: Sequence[Path], report: Report
) -> list[Processor]:
    """Make the processors of some estimators.

    Args:
        estimators: names from ESTIMATORS.
        wheels: names of the wheels, as in wheel_states.
        files: ROS parameter files over those that the packages ship, the later decides.
        report: takes what the processors have to say.

    Raises:
        ParameterError: a parameter is bad; the text names it.
        OSError: a file cannot be read.
    """
    processors: list[Processor] = []
    for name in estimators:
        values: dict[str, Any] = {}
        for file in (shipped_file(name), *files):
            values.update(_section(file, name))
        values["wheels"] = list(wheels)
        values.pop("use_sim_time", None)
        parameters = getattr(import_module(f"{name}.parameters"), _PARAMETERS[name])
        build = import_module(f"{name}.processor").build
        try:
            processors.extend(build(from_mapping(parameters, values), report))
        except ValueError as error:
            raise ParameterError(f"{name}: {error}") from error
    return processors


def _section(file: Path, node: str) -> dict[str, Any]:
    """Parameters a file gives to a node: of all nodes, then its own."""
    try:
        sections = yaml.safe_load(file.read_text(encoding="utf-8")) or {}
        found: dict[str, Any] = {}
        for key in ("/**", f"/**/{node}", node, f"/{node}"):
            found.update(sections.get(key, {}).get("ros__parameters", {}))
    except (yaml.YAMLError, AttributeError, TypeError) as error:
        raise ParameterError(f"{file} is no ROS parameter file: {error}") from error
    return found
