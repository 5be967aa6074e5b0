"""Parameters of a dataclass on a node, declared and kept up to date; those of a command line, checked before it starts.

The middleware merges what it understands of a file and silently ignores the rest. So each file is read here, with the
reader of the offline runner, and only the checked values go to the middleware; `-p` likewise. The rightmost value wins.
"""

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from friction_parameters.parameter import (
    Declared,
    ParameterError,
    changed,
    checked,
    converted,
    declared,
    unknown,
    values_of,
)
from friction_parameters.parameter_file import NodeName, file_values, is_ros_own, ros_value
from friction_parameters.yaml_file import read_value, yaml_text

Parameters = TypeVar("Parameters")


def declare(node: Node, cls: type[Parameters], apply: Callable[[Parameters], None]) -> Parameters:
    """Declare the parameters on a node, return their values, and call `apply` after each later change.

    A change is refused, with the reason, when a value is bad or when `apply` raises ValueError. An integer is accepted
    for a float, at start and later.

    Raises:
        ParameterError: a value given at start is bad, or an unknown parameter was given.
    """
    known = declared(cls)
    given: dict[str, Any] = {}
    for name, override in node._parameter_overrides.items():
        if name in known:
            given[name] = checked(name, known[name].hint, known[name].limits, override.value)
        elif not is_ros_own(name):
            raise ParameterError(f"node {node.get_fully_qualified_name()}: {unknown(cls, name)}")
    current = changed(cls(), given)
    for name, value in values_of(current).items():
        # The value is declared, not the default: an override of the wrong kind of number has been converted.
        listed = list(value) if isinstance(value, tuple) else value
        node.declare_parameter(name, listed, _descriptor(known[name]), ignore_override=True)

    def on_set(changes: list[Parameter]) -> SetParametersResult:
        nonlocal current
        named = {change.name: change.value for change in changes if change.name in known}
        if not named:
            return SetParametersResult(successful=True)
        try:
            candidate = changed(current, named)
            apply(candidate)
        except ValueError as error:
            return SetParametersResult(successful=False, reason=str(error))
        current = candidate
        return SetParametersResult(successful=True)

    def with_right_numbers(changes: list[Parameter]) -> list[Parameter]:
        # Before ROS compares the types: it does not convert them.
        return [_converted(known[change.name], change) if change.name in known else change for change in changes]

    node.add_pre_set_parameters_callback(with_right_numbers)
    node.add_on_set_parameters_callback(on_set)
    return current


def _converted(parameter: Declared, change: Parameter) -> Parameter:
    try:
        value = converted(parameter.name, parameter.hint, change.value)
    except ParameterError:
        return change  # refused further on
    return Parameter(parameter.name, value=list(value) if isinstance(value, tuple) else value)


def _descriptor(parameter: Declared) -> ParameterDescriptor:
    limits = parameter.limits
    unit = f" [{limits['unit']}]" if limits["unit"] else ""
    descriptor = ParameterDescriptor(
        name=parameter.name,
        description=limits["description"] + unit,
        read_only=limits["read_only"],
        additional_constraints=f"one of {', '.join(limits['choices'])}" if limits["choices"] else "",
    )
    low, high = limits["minimum"], limits["maximum"]
    if low is not None and high is not None:
        if parameter.hint is float:
            descriptor.floating_point_range = [FloatingPointRange(from_value=float(low), to_value=float(high))]
        elif parameter.hint is int:
            descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high), step=1)]
    return descriptor


_BEGIN, _END = "--ros-args", "--"
_FILE = "--params-file"
_PARAMETER = ("-p", "--param")
_REMAP = ("-r", "--remap")
_NAME = "[A-Za-z_][A-Za-z0-9_]*"


def with_checked_parameters(arguments: Sequence[str], classes: Mapping[str, type], directory: Path) -> list[str]:
    """Replace the parameters and parameter files of a command line by one file with the checked values of its nodes.

    Args:
        arguments: command line of the process.
        classes: parameter dataclass of each node, by its name unless it is remapped.
        directory: directory for the new file.

    Returns:
        The command line to give to the middleware.

    Raises:
        ParameterError: file_values refuses a file, a parameter is unknown to a node or has a bad value, or two nodes
            have one name.
    """
    nodes = {node_name(arguments, name): cls for name, cls in classes.items()}
    if len(nodes) < len(classes):
        raise ParameterError(f"{', '.join(classes)} are given one name: put that of the node first, as in NODE:__node")
    found: dict[NodeName, dict[str, Any]] = {node: {} for node in nodes}
    result: list[str] = []
    for flag, value in _flags_and_values(arguments):
        if value is None or flag not in (_FILE, *_PARAMETER):
            result += [flag] if value is None else [flag, value]
            continue
        for node, cls in nodes.items():
            values = file_values(cls, value, node) if flag == _FILE else _parameter(cls, value, node)
            found[node].update(values)
    path = directory / "parameters.yaml"
    path.write_text("\n".join(_section(node, values) for node, values in found.items()), encoding="utf-8")
    return [*result, _BEGIN, _FILE, str(path)] if any(found.values()) else result


def node_name(arguments: Sequence[str], name: str) -> NodeName:
    """Return name and namespace of a node after the remapping on a command line; the first of several rules counts.

    Raises:
        ParameterError: the name or the namespace is not valid.
    """
    rules: dict[str, str] = {}
    for flag, rule in _flags_and_values(arguments):
        if flag in _REMAP and rule is not None:
            left, _, value = rule.partition(":=")
            of_node, _, what = left.rpartition(":")
            if of_node in ("", name):
                rules.setdefault("__node" if what == "__name" else what, value)
    found = NodeName(rules.get("__node", name), rules.get("__ns", "/"), remapped="__node" in rules)
    if not re.fullmatch(_NAME, found.name):
        raise ParameterError(f"'{found.name}' is not a valid node name: letters, digits and _ only")
    if not re.fullmatch(f"/|(/{_NAME})+", found.namespace):
        raise ParameterError(f"'{found.namespace}' is not a valid namespace: it must be like /my_car")
    return found


def _flags_and_values(arguments: Sequence[str]) -> Iterator[tuple[str, str | None]]:
    """Yield the words of a command line; flags that matter here come with the word that follows."""
    inside, words = False, iter(arguments)
    for word in words:
        inside = word == _BEGIN or (inside and word != _END)
        yield word, next(words, None) if inside and word in (_FILE, *_PARAMETER, *_REMAP) else None


def _section(node: NodeName, values: Mapping[str, Any]) -> str:
    lines = [f"{json.dumps(node.full)}:", "  ros__parameters:" + ("" if values else " {}")]
    lines += [f"    {json.dumps(name)}: {yaml_text(value)}" for name, value in values.items()]
    return "\n".join(lines)


def _parameter(cls: type, rule: str, node: NodeName) -> dict[str, Any]:
    """Return name and value of one parameter on the command line; nothing if it is for another node."""
    left, assigned, text = rule.partition(":=")
    of_node, _, name = left.rpartition(":")
    if of_node not in ("", node.name):
        return {}
    if not assigned or not name:
        raise ParameterError(f"-p {rule}: it must be name:=value")
    known = declared(cls)
    if name not in known and not is_ros_own(name):
        raise ParameterError(f"node {node.full}: {unknown(cls, name)}")
    try:
        value: Any = read_value(text)
    except ParameterError as error:
        raise ParameterError(f"-p {rule}: {error}") from error
    return {
        name: ros_value(name, value) if is_ros_own(name) else checked(name, known[name].hint, known[name].limits, value)
    }
