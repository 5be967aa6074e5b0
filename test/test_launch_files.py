"""Launch files and parameter files: they fit the nodes, in any namespace."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest
import yaml
from ament_index_python.packages import get_package_share_directory

from friction_bringup import graph
from friction_runtime.parameters import shipped_file

ROOT = Path(__file__).resolve().parents[1]
FILES = sorted(ROOT.glob("src/*/config/*.yaml"))
LAUNCH_FILES = sorted(Path(get_package_share_directory("friction_bringup"), "launch").glob("*.launch.py"))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_sections_of_a_parameter_file_match_a_node_in_any_namespace(path: Path) -> None:
    for section, content in yaml.safe_load(path.read_text()).items():
        assert section.startswith("/**"), f"{section} does not match a node in a namespace"
        assert set(content) == {"ros__parameters"}


@pytest.mark.parametrize(
    "path", [shipped_file("friction_bringup", name) for name in ("demo", "alongside", "bmw_m8")], ids=str
)
def test_parameters_that_decide_are_known_to_the_files_they_decide_over(path: Path) -> None:
    for section, content in yaml.safe_load(path.read_text()).items():
        node = section.removeprefix("/**/")
        below = yaml.safe_load(graph.parameter_files(node, path)[0].read_text())[section]
        assert set(content["ros__parameters"]) <= set(below["ros__parameters"])


def test_nothing_commands_beside_a_vehicle_stack() -> None:
    sections = yaml.safe_load(shipped_file("friction_bringup", "alongside").read_text())
    assert sections["/**/abs_supervisor"]["ros__parameters"]["shadow"] is True
    assert graph.PLANT not in graph.ESTIMATORS


def test_command_line_quotes_every_kind_of_parameter() -> None:
    overrides: dict[str, graph.ParameterValue] = {
        "surfaces": ["snow"],
        "shadow": True,
        "radii": [0.345, 0.3465],
        "level": 1,
    }
    made = graph.command("corner_sim", [Path("/a/b.yaml")], overrides, namespace="/car/")
    assert made[1:] == [
        *("-m", "corner_sim", "--ros-args", "--params-file", "/a/b.yaml"),
        *("-p", 'surfaces:=["snow"]', "-p", "shadow:=true", "-p", "radii:=[0.345, 0.3465]", "-p", "level:=1"),
        *("-r", "__ns:=/car"),
    ]


@pytest.mark.skipif(importlib.util.find_spec("launch_ros") is None, reason="launch_ros is not installed here")
@pytest.mark.parametrize("path", LAUNCH_FILES, ids=lambda path: path.name)
def test_launch_file_starts_nodes_of_the_one_list(path: Path) -> None:
    from launch import LaunchContext, LaunchService
    from launch.launch_description_sources import get_launch_description_from_python_launch_file
    from launch_ros.actions import Node

    description = get_launch_description_from_python_launch_file(str(path))
    context: LaunchContext = LaunchService().context
    context.launch_configurations.update(node=graph.PLANT, surface="snow")
    found = []
    for entity in description.entities:
        for made in entity.visit(context) or []:
            assert isinstance(made, Node)
            found.append(made.node_package)
    assert found
    assert set(found) <= set(graph.NODES)
