"""Parameters on the command line of a node, checked before the middleware starts.

The middleware merges what it understands of a file and silently ignores the rest. So each file is read here, with the
reader of the offline runner, and only the checked values go to the middleware; `-p` likewise. The rightmost value wins.
"""

import json
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from friction_parameters.parameter import ParameterError, checked
from friction_parameters.parameter_file import EVERY_NODE, NodeName, file_values, is_ros_own
from friction_parameters.values import declared, unknown
from friction_parameters.yaml_source import read_value, yaml_text

_BEGIN, _END = "--ros-args", "--"
_FILE = "--params-file"
_PARAMETER = ("-p", "--param")
_REMAP = ("-r", "--remap")
_NAME = "[A-Za-z_][A-Za-z0-9_]*"


def with_checked_parameters(arguments: Sequence[str], name: str, cls: type, directory: Path) -> list[str]:
    """Replace the parameters and parameter files of a command line by the checked values for a node.

    Args:
        arguments: command line of the node.
        name: name of the node, unless it is remapped.
        cls: parameter dataclass of the node.
        directory: directory for new files.

    Returns:
        The command line to give to the middleware.

    Raises:
        ParameterError: file_values refuses a file, a parameter is unknown or has a bad value.
    """
    node = node_name(arguments, name)
    result: list[str] = []
    for place, (flag, value) in enumerate(_flags_and_values(arguments)):
        if flag == _FILE and value is not None:
            result += [_FILE, str(_checked_file(cls, value, node, directory / f"{place}.yaml"))]
        elif flag in _PARAMETER and value is not None:
            result += _checked_parameter(cls, value, node)
        else:
            result += [flag] if value is None else [flag, value]
    return result


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


def _checked_file(cls: type, path: str, node: NodeName, copy: Path) -> Path:
    values = file_values(cls, path, node)
    lines = [f"{json.dumps(EVERY_NODE)}:", "  ros__parameters:" + ("" if values else " {}")]
    lines += [f"    {json.dumps(name)}: {yaml_text(value)}" for name, value in values.items()]
    copy.write_text("\n".join(lines), encoding="utf-8")
    return copy


def _checked_parameter(cls: type, rule: str, node: NodeName) -> list[str]:
    """Return flag and rule of one parameter; nothing if it is for another node."""
    left, assigned, text = rule.partition(":=")
    of_node, _, name = left.rpartition(":")
    if of_node not in ("", node.name):
        return []
    if not assigned or not name:
        raise ParameterError(f"-p {rule}: it must be name:=value")
    if is_ros_own(name):
        return ["-p", rule]
    known = declared(cls)
    if name not in known:
        raise ParameterError(f"node {node.full}: {unknown(cls, name)}")
    try:
        value: Any = read_value(text)
    except ParameterError as error:
        raise ParameterError(f"-p {rule}: {error}") from error
    return ["-p", f"{name}:={yaml_text(checked(name, known[name].hint, known[name].limits, value))}"]
