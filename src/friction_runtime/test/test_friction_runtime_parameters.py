"""Command lines with checked parameters; sections, order and values have the same meaning as in ROS."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import rclpy
from rclpy.context import Context

from friction_parameters.parameter import ParameterError, group, parameter
from friction_parameters.parameter_file import NodeName, file_values
from friction_runtime.parameters import node_name, with_checked_parameters
from friction_test_support.dds_client import own_domain


@dataclass(frozen=True)
class FilterParameters:
    offset: float = parameter(0.0, "offset")


@dataclass(frozen=True)
class EchoParameters:
    gain: float = parameter(2.0, "factor", minimum=0.0, maximum=10.0)
    count: int = parameter(1, "count")
    text: str = parameter("a", "text")
    on: bool = parameter(False, "flag")
    names: tuple[str, ...] = parameter(("a",), "names")
    distances: tuple[float, ...] = parameter((0.0,), "distances")
    filter: FilterParameters = group(FilterParameters())


def checked(directory: Path, *arguments: str) -> list[str]:
    return with_checked_parameters(arguments, {"echo": EchoParameters}, directory)


def seen_by_ros(*arguments: str) -> tuple[str, dict[str, Any]]:
    """Full name and parameters of a node that plain ROS starts with a command line."""
    context = Context()
    rclpy.init(context=context, args=list(arguments), domain_id=own_domain())
    node = rclpy.create_node("echo", context=context, start_parameter_services=False, enable_rosout=False)
    found = {}
    for name, override in node._parameter_overrides.items():
        value = override.value
        found[name] = value if isinstance(value, (bool, int, float, str)) else tuple(value)
    full_name = node.get_fully_qualified_name()
    node.destroy_node()
    rclpy.shutdown(context=context)
    return full_name, found


SECTIONS = [
    "/**/echo: {ros__parameters: {gain: 3.0}}\n/**: {ros__parameters: {gain: 4.0, count: 5}}",
    "/**: {ros__parameters: {gain: 4.0, count: 5}}\n/**/echo: {ros__parameters: {gain: 3.0}}",
    "/**/echo: {ros__parameters: {gain: 3.0, filter: {offset: 1.0}}}\n/my_car/echo: {ros__parameters: {gain: 4.0}}",
    "/my_car/echo: {ros__parameters: {gain: 4.0, filter.offset: 1.0}}\n/**/echo: {ros__parameters: {gain: 3.0}}",
    "my_car: {echo: {ros__parameters: {gain: 4.0}}, other: {ros__parameters: {gain: 5.0}}}",
    "my_car/echo: {ros__parameters: {gain: 4.0}}",
    "/*/echo: {ros__parameters: {gain: 4.0}}\n/*/*/echo2: {ros__parameters: {gain: 5.0}}",
    "/my_car/**: {ros__parameters: {gain: 4.0}}\n/*: {ros__parameters: {gain: 5.0}}",
    "/my_car/*: {ros__parameters: {gain: 4.0}}\n/your_car/**: {ros__parameters: {gain: 5.0}}",
    "/**: {ros__parameters: {use_sim_time: yes, qos_overrides: {/a/b: {publisher: {depth: 5}}}}}",
    "/**: {ros__parameters: {on: True, text: 'yes', names: [\"a b\", 'c'], distances: [1.0, 1e-3, .5, 2.]}}",
    '/**: {ros__parameters: {text: "\\u00e9\\U0001F600 # : \\n", gain: 1.0e-07, count: -7}}',
    "/**: {ros__parameters: {on: off, text: /a/b.yaml, gain: 1.5E+0, count: 0}}",
]


@pytest.mark.parametrize("text", SECTIONS)
def test_a_file_means_what_it_means_to_ros(text: str, tmp_path: Path) -> None:
    file = tmp_path / "p.yaml"
    file.write_text(text, encoding="utf-8")
    arguments = ["--ros-args", "-r", "__ns:=/my_car", "--params-file", str(file)]
    name, values = seen_by_ros(*arguments)
    assert name == "/my_car/echo"
    assert file_values(EchoParameters, file, NodeName("echo", "/my_car")) == values
    assert seen_by_ros(*checked(tmp_path, *arguments)) == (name, values)


@pytest.mark.parametrize(
    "remapping",
    [
        ["-r", "__node:=first", "-r", "__node:=second"],
        ["-r", "echo:__ns:=/a", "-r", "__ns:=/b"],
        ["-r", "other:__ns:=/a", "--remap", "__ns:=/b/c", "-r", "__name:=second"],
        ["-r", "a:=b", "-r", "__ns:=/"],
        ["--", "-r", "of the user", "--ros-args", "-r", "__ns:=/c"],
    ],
)
def test_names_after_remapping_are_those_of_ros(remapping: list[str]) -> None:
    assert node_name(["--ros-args", *remapping], "echo").full == seen_by_ros("--ros-args", *remapping)[0]


def test_a_node_that_was_given_a_name_is_marked() -> None:
    assert node_name(["--ros-args", "-r", "__node:=echo_fl"], "echo") == NodeName("echo_fl", "/", remapped=True)
    assert node_name(["-r", "__node:=echo_fl"], "echo") == NodeName("echo", "/", remapped=False)


@pytest.mark.parametrize(
    ("argument", "name", "value"),
    [
        ("gain:=3", "gain", 3.0),
        ("gain:=3e0", "gain", 3.0),
        ("echo:gain:=3", "gain", 3.0),
        ("distances:=[0, 40.5]", "distances", (0.0, 40.5)),
        ("filter.offset:=1", "filter.offset", 1.0),
        ("on:=True", "on", True),
        ("text:=/a/b c.yaml", "text", "/a/b c.yaml"),
        ("text:='5'", "text", "5"),
        ("names:=[a, 'b c']", "names", ("a", "b c")),
        ("use_sim_time:=True", "use_sim_time", True),
    ],
)
def test_parameters_are_converted_before_ros_sees_them(argument: str, name: str, value: Any, tmp_path: Path) -> None:
    _, found = seen_by_ros(*checked(tmp_path, "--ros-args", "--param", argument))
    assert found == {name: value}
    assert type(found[name]) is type(value)


def test_what_stands_further_right_decides(tmp_path: Path) -> None:
    file = tmp_path / "p.yaml"
    file.write_text("/**: {ros__parameters: {count: 3}}\n/**/echo: {ros__parameters: {gain: 3}}")
    files = ["--params-file", str(file)]
    assert seen_by_ros(*checked(tmp_path, "--ros-args", *files, "-p", "gain:=5"))[1] == {"count": 3, "gain": 5.0}
    assert seen_by_ros(*checked(tmp_path, "--ros-args", "-p", "gain:=5", *files))[1] == {"count": 3, "gain": 3.0}


def test_arguments_of_the_user_and_of_other_nodes_are_left_alone(tmp_path: Path) -> None:
    user = ["program", "-p", "gain:=x", "--params-file", "none.yaml"]
    ros = ["--ros-args", "--log-level", "info", "-r", "a:=b", "-p", "other:gain:=x", "--", "-p", "y"]
    assert checked(tmp_path, *user, *ros) == [*user, *ros[:5], *ros[7:]]


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["-p", "gian:=1"], "node /echo: unknown parameter 'gian': known are gain, count, "),
        (["-p", "gain:=11"], "parameter 'gain' = 11.0 is outside [0.0, 10.0]"),
        (["-p", "distances:=[0, x]"], "parameter 'distances' = 'x' must be of type float"),
        (["-p", "gain:=[1"], "-p gain:=[1: line 1: not YAML: "),
        (["-p", "gain:=\n{"], "-p gain:= {: line 2: not YAML: "),
        (["-p", ":=1"], "-p :=1: it must be name:=value"),
        (["--params-file", "/missing.yaml"], "parameter file /missing.yaml: No such file or directory"),
        (["--params-file", "/"], "parameter file /: Is a directory"),
        (["-r", "__ns:=my_car"], "'my_car' is not a valid namespace: "),
        (["-r", "__node:=5"], "'5' is not a valid node name: "),
    ],
)
def test_bad_arguments_are_refused_in_one_line(arguments: list[str], text: str, tmp_path: Path) -> None:
    with pytest.raises(ParameterError) as caught:
        checked(tmp_path, "--ros-args", *arguments)
    assert str(caught.value).startswith(text)
    assert "\n" not in str(caught.value)
