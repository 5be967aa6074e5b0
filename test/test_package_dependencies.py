"""Everything that a package imports, or starts by name, is declared in its package.xml."""

from __future__ import annotations

import ast
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable
from pathlib import Path

import pytest
from ament_index_python.packages import get_packages_with_prefixes

from friction_bags.offline.estimators import ESTIMATORS
from friction_bringup import graph

PACKAGES = sorted(path.parent for path in (Path(__file__).parents[1] / "src").glob("*/setup.py"))
NAMES = [package.name for package in PACKAGES]
STARTED_BY_NAME = {"friction_bringup": graph.NODES, "friction_bags": ESTIMATORS}


def imported(files: Iterable[Path]) -> set[str]:
    """ROS packages, ours among them, that Python files import anywhere."""
    found: set[str] = set()
    for file in files:
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.Import):
                found |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module is not None:
                found.add(node.module)
    return {name.split(".")[0] for name in found} & get_packages_with_prefixes().keys()


def declared(package: Path, *kinds: str) -> set[str]:
    root = ElementTree.parse(package / "package.xml").getroot()
    return {element.text or "" for kind in kinds for element in root.iter(kind)}


@pytest.mark.parametrize("package", PACKAGES, ids=NAMES)
def test_dependencies_are_declared(package: Path) -> None:
    needed = imported([*(package / package.name).rglob("*.py"), *package.glob("launch/*.py")])
    needed |= set(STARTED_BY_NAME.get(package.name, ()))
    assert needed - {package.name} <= declared(package, "exec_depend", "depend")


@pytest.mark.parametrize("package", PACKAGES, ids=NAMES)
def test_dependencies_of_the_tests_are_declared(package: Path) -> None:
    needed = imported(package.glob("test/**/*.py"))
    assert needed - {package.name} <= declared(package, "exec_depend", "test_depend", "depend")
