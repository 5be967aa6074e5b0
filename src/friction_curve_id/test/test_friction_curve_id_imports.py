"""Import rules between the modules of the package, read from the sources."""

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import friction_curve_id

PACKAGE = Path(friction_curve_id.__file__).parent
MODULES = {".".join(path.relative_to(PACKAGE).with_suffix("").parts): path for path in PACKAGE.glob("**/*.py")}

INTERFACE = {"interface", "measurement_noise", "sample_gate", "stamp_order"}
METHODS = {"car", "chapter", "vehicle"}
CHOICE = {"methods", "parameters"}
ROS_LAYER = {"ros", "__main__"}

LAYER_1: dict[str, set[str]] = {
    **{module: INTERFACE for module in INTERFACE},
    "activation": INTERFACE,
    "known_car": INTERFACE,
    "curve": INTERFACE | {"curve"},
    **{room: INTERFACE | {"curve", room} for room in METHODS},
    **{module: INTERFACE | {"curve", "known_car"} | METHODS | CHOICE for module in CHOICE},
}
"""Allowed imports, within the package, of a subpackage or a module beside them that must not depend on ROS."""
OWN = {"friction_curve_id", "friction_parameters", "sensor_monitor", "vehicle_models"}
PACKAGES = {*OWN, "numpy", "scipy", *sys.stdlib_module_names}
"""All its allowed imports: no message, and not friction_runtime, which depends on ROS."""


def place(module: str) -> str:
    return module.split(".")[0]


def imported(path: Path) -> Iterator[str]:
    """Full names of the modules that a file imports, wherever in it the import stands."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0 and node.module, f"{path}: a relative import"
            names = [f"{node.module}.{alias.name}" for alias in node.names]
            inside = [name for name in names if name.removeprefix("friction_curve_id.") in MODULES]
            yield from inside or [node.module]


def of_the_package(path: Path) -> set[str]:
    prefix = "friction_curve_id."
    return {place(name.removeprefix(prefix)) for name in imported(path) if name.startswith(prefix)}


def test_every_module_has_its_place() -> None:
    assert {place(module) for module in MODULES} == {"__init__", *LAYER_1, *ROS_LAYER}


@pytest.mark.parametrize("module", [module for module in MODULES if place(module) in LAYER_1])
def test_an_algorithm_imports_no_ros_and_nothing_above_it(module: str) -> None:
    assert {name.split(".")[0] for name in imported(MODULES[module])} <= PACKAGES
    assert of_the_package(MODULES[module]) <= LAYER_1[place(module)]
