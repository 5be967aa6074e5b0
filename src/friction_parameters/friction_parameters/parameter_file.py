"""ROS parameter files: what a file gives to a node, and everything in it that looks meant for the node but is not.

    /**:                       # every node
      ros__parameters: {use_sim_time: true}
    /**/friction_slope:        # the node of this name in any namespace
      ros__parameters:
        detector: {window: 6}
    /my_car/friction_slope:    # its full name, as `ros2 param dump` writes it

A later section decides over an earlier one. Sections of other nodes are ignored.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from difflib import SequenceMatcher
from pathlib import Path
from typing import Any, TypeVar

from friction_parameters.parameter import ParameterError, checked
from friction_parameters.values import declared, from_mapping, unknown
from friction_parameters.yaml_source import Entry, plain, read_yaml, refuse_repeated

Parameters = TypeVar("Parameters")

EVERY_NODE = "/**"
_KEY = "ros__parameters"
_ROS_OWN = ("use_sim_time", "start_type_description_service")
_QOS = "qos_overrides."
_ALIKE = 0.85
"""Share of common letters above which one name is taken for a misspelling of another."""


@dataclass(frozen=True)
class NodeName:
    """Name of a node and its namespace."""

    name: str
    namespace: str = "/"

    @property
    def full(self) -> str:
        """Full name, such as /my_car/friction_slope."""
        return f"/{self.namespace.strip('/')}/{self.name}".replace("//", "/")


def is_ros_own(name: str) -> bool:
    """Is this a parameter that ROS gives to every node?"""
    return name in _ROS_OWN or name.startswith(_QOS)


def file_values(cls: type, path: str | Path, node: NodeName) -> dict[str, Any]:
    """Values that a file gives to a node, by dotted name, converted and checked; those of ROS as they are.

    Args:
        cls: parameter dataclass of the node.
        path: the file.
        node: the node.

    Raises:
        ParameterError: in one line with file and line: no YAML, a key that stands twice, a parameter that the node
            does not have, a bad value, a section whose name is nearly that of the node, or is that of the node
            without matching its full name.
        OSError: the file cannot be read.
    """
    found: dict[str, Any] = {}
    for name, entry in _sections(path, "", read_yaml(path)):
        if name == EVERY_NODE:
            found.update(_section_values(cls, path, name, entry, strict=False))
        elif name.rpartition("/")[2] == node.name:
            if not re.fullmatch(_pattern(name), node.full):
                raise ParameterError(
                    f"{path}: line {entry.line}: section '{name}' is not for the node {node.full}: "
                    f"name it '/**/{node.name}' or '{node.full}'"
                )
            found.update(_section_values(cls, path, name, entry, strict=True))
        elif _is_misspelt(name.rpartition("/")[2], node.name):
            raise ParameterError(f"{path}: line {entry.line}: section '{name}': is '/**/{node.name}' meant?")
    return found


def load(cls: type[Parameters], path: str | Path, node: str) -> Parameters:
    """Make the dataclass from a file.

    Args:
        cls: parameter dataclass of the node.
        path: the file.
        node: name of the node.

    Raises:
        ParameterError: the file has no value for the node, or as file_values and from_mapping.
        OSError: the file cannot be read.
    """
    values = file_values(cls, path, NodeName(node))
    if not values:
        raise ParameterError(f"{path}: no section '/**/{node}'")
    return from_mapping(cls, {name: value for name, value in values.items() if not is_ros_own(name)})


def _sections(path: str | Path, namespace: str, entries: dict[str, Entry]) -> Iterator[tuple[str, Entry]]:
    """Names of nodes, with their namespaces, and what stands below each."""
    for key, entry in entries.items():
        name = f"{namespace}/{key.lstrip('/')}"
        if isinstance(entry.value, dict) and not _is_section(entry.value):
            yield from _sections(path, name, entry.value)
        else:
            yield name, entry


def _is_section(entries: dict[str, Entry]) -> bool:
    return _KEY in entries or not all(isinstance(each.value, dict) for each in entries.values())


def _section_values(cls: type, path: str | Path, section: str, entry: Entry, *, strict: bool) -> dict[str, Any]:
    """Values of one section; a section that is not `strict` may hold what other nodes understand."""
    refuse_repeated(path, section, entry)
    entries = entry.value if isinstance(entry.value, dict) else {}
    strangers = [key for key in entries if key != _KEY]
    if (strict or strangers) and (strangers or _KEY not in entries):
        raise ParameterError(f"{path}: line {entry.line}: section '{section}' must hold '{_KEY}' and nothing else")
    if not isinstance(entries.get(_KEY, Entry(0, {})).value, dict):
        raise ParameterError(f"{path}: line {entry.line}: '{_KEY}' of section '{section}' must hold names and values")
    found = {}
    known = declared(cls)
    for name, each in _flat(entries[_KEY].value if entries else {}):
        if is_ros_own(name):
            found[name] = plain(each.value)
        elif name in known:
            try:
                found[name] = checked(name, known[name].hint, known[name].limits, each.value)
            except ParameterError as error:
                raise ParameterError(f"{path}: line {each.line}: {error}") from error
        elif strict or any(_is_misspelt(name, right) for right in known):
            raise ParameterError(f"{path}: line {each.line}: {unknown(cls, name)}")
    return found


def _flat(entries: dict[str, Entry]) -> Iterator[tuple[str, Entry]]:
    for name, entry in entries.items():
        if isinstance(entry.value, dict):
            yield from ((f"{name}.{inner}", each) for inner, each in _flat(entry.value))
        else:
            yield name, entry


def _pattern(section: str) -> str:
    """Regular expression of the full names that a section is for; * stands for one part of a name, ** for any."""
    parts = {"**": "(/[^/]+)*", "*": "/[^/]+"}
    return "".join(parts.get(part, "/" + re.escape(part)) for part in section.strip("/").split("/"))


def _is_misspelt(found: str, right: str) -> bool:
    return found != right and SequenceMatcher(None, found, right).ratio() >= _ALIKE
