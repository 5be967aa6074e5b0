"""The estimators of the graph, built from parameter files and the car in the same way as their nodes."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

from friction_parameters.parameter import ParameterError, changed, ignored
from friction_parameters.parameter_file import NodeName, file_values, is_ros_own
from friction_runtime.installed import shipped_parameters
from friction_runtime.processor import Processor, Report, silent
from vehicle_models.vehicle import Vehicle

ESTIMATORS = (
    *("wheel_slip", "friction_slope", "friction_curve_id", "abs_supervisor"),
    *("smart_tyre_forces", "friction_grip", "friction_state"),
)
"""Estimators in the order of the data flow. Package, node and parameter file have the same name; `SHIPPED` of the
module `parameters` holds the shipped values, `build` of the module `processor` makes the processors. Only the selected
ones are imported: all of them take a second."""
SMART_TYRE, STATE = "smart_tyre_forces", "friction_state"
WHEEL_ESTIMATORS = tuple(name for name in ESTIMATORS if name not in (SMART_TYRE, STATE))
"""Estimators that need wheel_states, without the one that only collects their answers."""


def read_parameters(
    estimators: Iterable[str], files: Sequence[Path], report: Report, namespace: str = "/"
) -> dict[str, Any]:
    """Return the parameters of some estimators, by name.

    Args:
        estimators: names from ESTIMATORS.
        files: ROS parameter files that override those of the packages; later files override earlier ones.
        report: log function; parameters that are set for a method that is not chosen are reported.
        namespace: namespace of the estimators, such as /car.

    Raises:
        ParameterError: a file or a parameter is bad; the text names it.
    """
    found: dict[str, Any] = {}
    for name in estimators:
        parameters = shipped_parameters(name)
        values: dict[str, Any] = {}
        for file in files:
            values.update(file_values(type(parameters), file, NodeName(name, namespace)))
        try:
            found[name] = changed(parameters, {key: each for key, each in values.items() if not is_ros_own(key)})
        except ParameterError as error:
            raise ParameterError(f"{name}: {error}") from error
        for text in ignored(found[name]):
            report("warning", f"{name}: {text}")
    return found


def closed_loop_parameters(estimators: Iterable[str], law: str = "slope_sign") -> dict[str, Any]:
    """Return the shipped parameters of some estimators, by name; abs_supervisor, among them, commands by `law`."""
    found = read_parameters(estimators, (), silent)
    found["abs_supervisor"] = replace(found["abs_supervisor"], shadow=False, law=law)
    return found


def vehicle_of(parameters: Mapping[str, Any]) -> str:
    """Return the vehicle file that the parameters of estimators name; empty where none does.

    Raises:
        ParameterError: they name different ones.
    """
    found = {each.vehicle_file: name for name, each in parameters.items() if each.vehicle_file}
    if len(found) > 1:
        texts = [f"{name} has '{file}'" for file, name in found.items()]
        raise ParameterError(f"parameter 'vehicle_file': {', '.join(texts)}: estimators must have the same car")
    return next(iter(found), "")


def make_processors(parameters: Mapping[str, Any], vehicle: Vehicle, report: Report) -> list[Processor]:
    """Make the processors of some estimators.

    Args:
        parameters: parameters of each, from read_parameters.
        vehicle: the car; `vehicle_file` of the parameters is not used.
        report: log function of the processors.

    Raises:
        ParameterError: parameters do not fit the car or each other.
    """
    processors: list[Processor] = []
    for name, each in parameters.items():
        try:
            processors.extend(import_module(f"{name}.ros.processor").build(each, vehicle, report))
        except ValueError as error:
            raise ParameterError(f"{name}: {error}") from error
    return processors
