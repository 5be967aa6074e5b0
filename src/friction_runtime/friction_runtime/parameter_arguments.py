"""Parameters on the command line of one or several nodes, checked before the middleware starts.

The middleware merges what it understands of a file and silently ignores the rest. So each file is read here, with the
reader of the offline runner, and only the checked values go to the middleware; `-p` likewise. The rightmost value wins.
"""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from friction_parameters.parameter import ParameterError, checked, declared, unknown
from friction_parameters.parameter_file import NodeName, file_values, is_ros_own, ros_value
from friction_parameters.yaml_file import read_value, yaml_text

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
