"""The estimators of the graph and how each is built from parameter files, as its node is."""

from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import yaml

from abs_supervisor.parameters import SupervisorParameters
from friction_curve_id.parameters import FrictionCurveParameters
from friction_runtime.parameters import ParameterError, from_mapping, shipped_file
from friction_runtime.processor import Processor, Report
from friction_slope.parameters import FrictionSlopeParameters
from smart_tyre_forces.parameters import SmartTyreParameters
from wheel_slip.parameters import WheelSlipParameters

_PARAMETERS: dict[str, type] = {
    "wheel_slip": WheelSlipParameters,
    "friction_slope": FrictionSlopeParameters,
    "friction_curve_id": FrictionCurveParameters,
    "abs_supervisor": SupervisorParameters,
    "smart_tyre_forces": SmartTyreParameters,
}
ESTIMATORS = tuple(_PARAMETERS)
"""In the order in which data flows. Package, node and parameter file have one name; `build` of the module `processor`
makes the processors from the parameters."""
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
        build = import_module(f"{name}.processor").build
        try:
            processors.extend(build(from_mapping(_PARAMETERS[name], values), report))
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
