"""Everything that a package imports, or starts by name, is declared in its package.xml and setup.py.

Executables, nodes and launch files start where nothing but what their package declares can be imported.
"""

from __future__ import annotations

import ast
import json
import os
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable
from functools import cache
from importlib.metadata import entry_points, packages_distributions, requires
from importlib.util import find_spec
from pathlib import Path

import pytest
from ament_index_python.packages import PackageNotFoundError, get_package_share_directory

from friction_bags.offline.estimators import ESTIMATORS
from friction_bringup import graph
from friction_parameters.command_line import WITHOUT_ROSDEP_KEY
from friction_test_support.dds_client import DdsClient, dds_client, stop

SOURCES = Path(__file__).parents[1] / "src"
PACKAGES = sorted(path.parent for path in SOURCES.glob("*/setup.py"))
NAMES = [package.name for package in PACKAGES]
STARTED_BY_NAME = {"friction_bringup": graph.NODES, "friction_bags": ESTIMATORS}
ROSDEP_KEYS = {
    **{name: f"python3-{name}" for name in ("hypothesis", "matplotlib", "numpy", "pytest", "rich", "scipy", "yaml")}
}
"""Keys of libraries that are no ROS packages, by the module that is imported."""
PIP_NAMES = {"yaml": "PyYAML"}
PATIENCE = 120.0


def imported(files: Iterable[Path]) -> set[str]:
    """Return the top-level modules outside the standard library that Python files import anywhere."""
    found: set[str] = set()
    for file in files:
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.Import):
                found |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module is not None:
                found.add(node.module)
    return {name.split(".")[0] for name in found} - sys.stdlib_module_names


def declared(manifest: Path, *kinds: str) -> set[str]:
    root = ElementTree.parse(manifest).getroot()
    return {element.text or "" for kind in kinds for element in root.iter(kind)}


def keys(modules: Iterable[str]) -> set[str]:
    return {ROSDEP_KEYS.get(name, name) for name in modules}


@pytest.mark.parametrize("package", PACKAGES, ids=NAMES)
def test_dependencies_are_declared(package: Path) -> None:
    found = imported([*(package / package.name).rglob("*.py"), *package.glob("launch/*.py")])
    needed = found - {package.name} - WITHOUT_ROSDEP_KEY.keys() | set(STARTED_BY_NAME.get(package.name, ()))
    assert keys(needed) <= declared(package / "package.xml", "exec_depend", "depend")
    libraries = {PIP_NAMES.get(name, name) for name in needed & ROSDEP_KEYS.keys()}
    given = re.search(r"install_requires=(\[.*?\])", (package / "setup.py").read_text())
    assert given is not None
    assert libraries <= set(json.loads(given[1]))


@pytest.mark.parametrize("package", PACKAGES, ids=NAMES)
def test_dependencies_of_the_tests_are_declared(package: Path) -> None:
    found = imported(package.glob("test/**/*.py"))
    own = {package.name, *(file.stem for file in package.glob("test/*.py"))}
    needed = keys(found - own - WITHOUT_ROSDEP_KEY.keys())
    if package.name != "friction_test_support":
        needed.add("friction_test_support")  # its plugin sets up every test run
    assert needed <= declared(package / "package.xml", "exec_depend", "test_depend", "depend")


@cache
def importable(package: str) -> frozenset[str]:
    """Return the modules that a package may import: its own, and those of all that it declares, transitively."""
    found: set[str] = set()
    libraries = {"setuptools"}
    waiting = [package]
    modules = {key: module for module, key in ROSDEP_KEYS.items()}
    while waiting:
        name = waiting.pop()
        if name.startswith("python3-"):
            module = modules.get(name, name.removeprefix("python3-").replace("-", "_"))
            libraries.add(PIP_NAMES.get(module, module))
            found.add("lark" if module == "lark_parser" else module)
        elif name not in found:
            found.add(name)
            libraries.add(f"ros-{name}")  # the same package as a Python wheel, which names what it needs itself
            try:
                manifest = Path(get_package_share_directory(name), "package.xml")
            except PackageNotFoundError:  # of the system, such as a compiler
                continue
            if manifest.exists():
                waiting += declared(manifest, "exec_depend", "depend", "run_depend")
    return frozenset(found | {module for library in libraries for module in _modules_of(library)})


@cache
def _modules_of(distribution: str) -> frozenset[str]:
    """Modules of a Python package and of what it requires."""
    found, waiting = set(), [distribution]
    while waiting:
        name = _normal(waiting.pop())
        if name not in found:
            found.add(name)
            try:
                needed = requires(name) or []
            except Exception:  # another platform's, or absent
                continue
            waiting += [re.split(r"[ ;<>=!~\[(]", each)[0] for each in needed if "extra ==" not in each]
    return frozenset(
        module for module, owners in packages_distributions().items() if {_normal(owner) for owner in owners} & found
    )


def _normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


BLOCK = """
import json, os, sys
from importlib.abc import MetaPathFinder

ALLOWED = frozenset(json.loads(os.environ["IMPORTABLE"])) | sys.stdlib_module_names

class OnlyDeclared(MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        root = name.partition(".")[0]
        if root not in ALLOWED and not root.startswith("_"):
            raise ModuleNotFoundError(f"No module named {root!r}: it is not declared", name=root)
        return None

sys.meta_path.insert(0, OnlyDeclared())
"""


@pytest.fixture
def only_declared(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """Let child processes import what the variable IMPORTABLE lists."""
    (tmp_path / "usercustomize.py").write_text(BLOCK)
    (tmp_path / "sitecustomize.py").write_text(BLOCK)
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}{os.pathsep}{os.environ['PYTHONPATH']}")
    return monkeypatch


OF_BAGS = ("analyse", "demo", "doctor")
"""Commands of packages without a bag library that need one."""


def executables() -> list[tuple[str, str]]:
    """Return package and name of each executable, those of `ros2 run`."""
    scripts = {(each.module.partition(".")[0], each.name) for each in entry_points(group="console_scripts")}
    return sorted(each for each in scripts if each[0] in NAMES)


def test_a_module_that_is_not_declared_is_blocked(only_declared: pytest.MonkeyPatch) -> None:
    only_declared.setenv("IMPORTABLE", json.dumps(sorted(importable("vehicle_models"))))
    command = [sys.executable, "-c"]
    assert subprocess.run([*command, "import vehicle_models.vehicle_file, numpy.linalg"], check=False).returncode == 0
    blocked = subprocess.run([*command, "import rosbags"], capture_output=True, text=True, check=False)
    assert "not declared" in blocked.stderr


@pytest.mark.parametrize(("package", "name"), executables(), ids="/".join)
def test_executable_starts_with_what_its_package_declares(
    package: str, name: str, only_declared: pytest.MonkeyPatch
) -> None:
    only_declared.setenv("IMPORTABLE", json.dumps(sorted(importable(package))))
    program = Path(get_package_share_directory(package)).parents[1] / "lib" / package / name
    if name.endswith("_node") or name in ("graph", "monitor"):
        with dds_client() as client:
            _start_and_stop(client, program)
        return
    ended = subprocess.run(
        [sys.executable, str(program), "--help"], capture_output=True, text=True, timeout=PATIENCE, check=False
    )
    if ended.returncode != 0:
        assert ended.returncode == 2, ended.stderr
        assert re.fullmatch(r"error: this needs \w+: python3 -m pip install [\w -]+\n", ended.stderr), ended.stderr
        assert package not in ("friction_adapter", "friction_bringup") or name in OF_BAGS


def _start_and_stop(client: DdsClient, program: Path) -> None:
    node = "live_view" if program.name == "monitor" else "wheel_slip" if program.name == "graph" else program.stem[:-5]
    options = [] if program.name in ("monitor", "corner_sim_node") else ["-p", "vehicle_file:=compact_car"]
    if node == graph.ADAPTER:
        options += ["-p", "map_file:=gazebo"]
    process = client.start(str(program), "--ros-args", *options)
    client.until(lambda: process.poll() is not None or node in client.node.get_node_names())
    output = stop(process) if process.poll() is None else process.communicate()[0]
    assert process.returncode == 0, output
    assert "Traceback" not in output


@pytest.mark.skipif(find_spec("launch_ros") is None, reason="launch_ros is not installed here")
@pytest.mark.parametrize("file", sorted(SOURCES.glob("*/launch/*.launch.py")), ids=lambda file: file.name)
def test_launch_file_loads_with_what_its_package_declares(file: Path, only_declared: pytest.MonkeyPatch) -> None:
    only_declared.setenv("IMPORTABLE", json.dumps(sorted(importable(file.parents[1].name))))
    code = "from launch.launch_description_sources import get_launch_description_from_python_launch_file as load"
    command = [sys.executable, "-c", f"{code}; import sys; load(sys.argv[1])", str(file)]
    loaded = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert loaded.returncode == 0, loaded.stderr
