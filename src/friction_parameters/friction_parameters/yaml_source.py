"""YAML that remembers its lines, and which keys stand twice."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from friction_parameters.parameter import ParameterError

_EXPONENT = re.compile(r"[-+]?[0-9]+(\.[0-9]*)?[eE][-+]?[0-9]+")
"""Floats such as 1e-4, which YAML 1.1 takes for texts and ROS for numbers."""


@dataclass(frozen=True)
class Entry:
    """A value of a mapping."""

    line: int
    """Of its key, from 1."""
    value: Any
    """A scalar, a list, or a dict of Entry."""
    first_line: int = 0
    """Line in which the same key stands before, 0 if it does not; the last of them counts."""


def read_yaml(path: str | Path) -> dict[str, Entry]:
    """Read a file that holds one mapping.

    Raises:
        ParameterError: it is no YAML, or its top is no mapping.
        OSError: it cannot be read.
    """
    try:
        node = yaml.compose(Path(path).read_text(encoding="utf-8"), Loader=yaml.SafeLoader)
        if node is None:
            return {}
        if not isinstance(node, yaml.MappingNode):
            raise ParameterError(f"{path}: line {node.start_mark.line + 1}: a mapping is expected")
        return _mapping(path, node)
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise ParameterError(f"{path} is no YAML: {' '.join(str(error).split())}") from error


def plain(value: Any) -> Any:
    """Return a value without its lines."""
    if isinstance(value, dict):
        return {key: plain(entry.value) for key, entry in value.items()}
    return value


def refuse_repeated(path: str | Path, key: str, entry: Entry) -> None:
    """Refuse a key that stands twice: this one, or one below it.

    Raises:
        ParameterError: with both lines.
    """
    if entry.first_line:
        raise ParameterError(f"{path}: line {entry.line}: '{key}' stands here again, first in line {entry.first_line}")
    if isinstance(entry.value, dict):
        for inner, below in entry.value.items():
            refuse_repeated(path, inner, below)


def _mapping(path: str | Path, node: yaml.MappingNode) -> dict[str, Entry]:
    found: dict[str, Entry] = {}
    for key_node, value_node in node.value:
        line = key_node.start_mark.line + 1
        if not isinstance(key_node, yaml.ScalarNode):
            raise ParameterError(f"{path}: line {line}: a key must be a text")
        key = str(key_node.value)
        first_line = found[key].line if key in found else 0
        found[key] = Entry(line, _value(path, value_node), first_line)
    return found


def _value(path: str | Path, node: yaml.Node) -> Any:
    if isinstance(node, yaml.MappingNode):
        return _mapping(path, node)
    if isinstance(node, yaml.SequenceNode):
        return [plain(_value(path, each)) for each in node.value]
    if node.style is None and _EXPONENT.fullmatch(node.value):
        return float(node.value)
    loader = yaml.SafeLoader("")
    return loader.construct_object(node)
