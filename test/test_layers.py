"""Layers: packages import only from below, and algorithms import no ROS, so that they run wherever Python does."""

from __future__ import annotations

import ast
import subprocess
import sys

import pytest

from draw_layers import LAYERS, ROOT, drawing, imports, package_imports

SOURCES = ROOT / "src"
ALGORITHMS = (
    "friction_parameters",
    "vehicle_models",
    "sensor_monitor",
    "corner_sim",
    "friction_adapter",
    "wheel_slip",
    "friction_slope",
    "friction_curve_id",
    "abs_supervisor",
    "smart_tyre_forces",
    "friction_grip",
    "friction_state",
)
"""Packages that consist of an algorithm, or the plant, and the code around it."""
WITHOUT_ROS = """
import sys
from importlib import import_module
from importlib.abc import MetaPathFinder

class NoRos(MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        root = name.partition(".")[0]
        if root.endswith("_msgs") or root in ("rclpy", "rosbag2_py", "builtin_interfaces", "ament_index_python"):
            raise ModuleNotFoundError(f"{name} is ROS")
        return None

sys.meta_path.insert(0, NoRos())
failed = []
for module in sys.argv[1:]:
    try:
        import_module(module)
    except ImportError as error:
        failed.append(f"{module}: {error}")
print("\\n".join(failed))
sys.exit(bool(failed))
"""


def modules_of(package: str) -> list[str]:
    """Names of all modules of a package, those of its subpackages too."""
    directory = SOURCES / package
    files = sorted((directory / package).rglob("*.py"))
    names = [".".join(file.relative_to(directory).with_suffix("").parts) for file in files]
    return [name.removesuffix(".__init__") for name in names]


def imported_without_ros(modules: list[str]) -> str:
    """Import modules in a new interpreter in which ROS cannot be imported; return what failed."""
    command = [sys.executable, "-c", WITHOUT_ROS, *modules]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode in (0, 1), done.stderr
    return done.stdout.strip()


@pytest.mark.parametrize("package", ALGORITHMS)
def test_algorithms_import_no_ros(package: str) -> None:
    layer_1 = [name for name in modules_of(package) if name.split(".")[1:2] not in (["ros"], ["__main__"])]
    assert layer_1
    assert imported_without_ros(layer_1) == ""


def test_what_processors_share_with_algorithms_imports_no_ros_either() -> None:
    assert imported_without_ros(["friction_runtime.aligner", "friction_runtime.processor"]) == ""


def test_a_module_that_imports_ros_is_found() -> None:
    assert "friction_msgs is ROS" in imported_without_ros(["friction_slope.estimate", "friction_slope.ros.processor"])


def message_classes(tree: ast.Module) -> set[str]:
    """Return the names under which a module imports message classes."""
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    return {
        name.asname or name.name for node in imports if (node.module or "").endswith("_msgs.msg") for name in node.names
    }


@pytest.mark.parametrize("package", sorted(path.parent.name for path in SOURCES.glob("*/setup.py")))
def test_no_package_asks_for_the_class_of_a_message(package: str) -> None:
    """A message read from a bag is of another library than one of the middleware: a topic or a type's name decides."""
    for file in sorted((SOURCES / package / package).rglob("*.py")):
        tree = ast.parse(file.read_text())
        classes = message_classes(tree)
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "isinstance":
                asked = {each.id for each in ast.walk(node.args[1]) if isinstance(each, ast.Name)}
                assert not asked & classes, f"{file}:{node.lineno}"


def test_packages_import_only_from_layers_below_their_own() -> None:
    graph = package_imports(SOURCES)
    layer = {name: height for height, names in enumerate(reversed(LAYERS)) for name in names}
    assert layer.keys() == graph.keys() - {"friction_test_support"}
    upward = {(name, other) for name in layer for other in graph[name] if layer.get(other, 99) >= layer[name]}
    assert not upward
    assert not graph["friction_test_support"]


def test_the_picture_of_the_layers_is_up_to_date() -> None:
    assert (ROOT / "docs/layers.svg").read_text() == drawing(package_imports(SOURCES)), "run `make docs`"


def test_packages_import_nothing_that_is_not_installed() -> None:
    not_installed = {path.parent.name for path in ROOT.glob("*/__init__.py")} | {"tools"}
    assert {"book", "benchmarks", "campaigns"} <= not_installed
    assert not imports(SOURCES.rglob("*.py")) & not_installed
