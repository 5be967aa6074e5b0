"""ROS parameter files: the values for a node, and errors for entries that look meant for the node but do not match.

    /**:                       # every node
      ros__parameters: {use_sim_time: true}
    /**/friction_slope:        # the node of this name in any namespace
      ros__parameters:
        detector: {window: 6}
    /my_car/friction_slope:    # its full name, as `ros2 param dump` writes it

A later section overrides an earlier one. Sections of other nodes are ignored.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from difflib import SequenceMatcher
from pathlib import Path
from typing import Any, TypeVar

from friction_parameters.parameter import ParameterError, checked, declared, from_mapping, unknown
from friction_parameters.yaml_file import Entry, read_yaml

Parameters = TypeVar("Parameters")

EVERY_NODE = "/**"
_KEY = "ros__parameters"
_ANY = ("*", "**")
_ROS_OWN = ("use_sim_time", "start_type_description_service")
_QOS = "qos_overrides."
_ALIKE = 0.85
"""Share of common letters above which one name is taken for a misspelling of another."""


@dataclass(frozen=True)
class NodeName:
    """Name of a node and its namespace."""

    name: str
    namespace: str = "/"
    remapped: bool = False
    """Whether the user gave this name. Then a similar one may be that of a second node: friction_slope_fl and _fr."""

    @property
    def full(self) -> str:
        """Full name, such as /my_car/friction_slope."""
        return f"/{self.namespace.strip('/')}/{self.name}".replace("//", "/")


def is_ros_own(name: str) -> bool:
    """Whether this is a parameter that ROS declares on every node."""
    return name in _ROS_OWN or name.startswith(_QOS)


def file_values(cls: type, path: str | Path, node: NodeName) -> dict[str, Any]:
    """Return the values of a file for a node, by dotted name, converted and checked; those of ROS as they are.

    Args:
        cls: parameter dataclass of the node.
        path: the file.
        node: the node.

    Raises:
        ParameterError: the file cannot be read or is not YAML, a key occurs twice, a parameter is unknown, a
            value is bad, or the name of a section is nearly that of the node, or is that of the node without matching
            its full name. The text is one line with file and line.
    """
    entries = read_yaml(path, "parameter file")
    if _KEY in entries:
        raise ParameterError(f"{path}: line {entries[_KEY].line}: '{_KEY}' stands below no name of a node")
    found: dict[str, Any] = {}
    lines: dict[str, int] = {}
    misspelt = ""
    for section, entry in _sections(node, "", entries):
        where = f"{path}: line {entry.line}"
        own = section.rpartition("/")[2]
        if own not in (node.name, *_ANY):
            if _is_misspelt(own, node.name):
                misspelt = misspelt or f"{where}: section '{section}': is '/**/{node.name}' meant?"
            continue
        if not re.fullmatch(_pattern(section), node.full):
            if own in _ANY:
                continue
            raise ParameterError(
                f"{where}: section '{section}' is not for the node {node.full}: "
                f"name it '/**/{node.name}' or '{node.full}'"
            )
        if section in lines:
            raise ParameterError(f"{where}: '{section}' is repeated here, first in line {lines[section]}")
        lines[section] = entry.line
        found.update(_section_values(cls, path, section, entry, strict=own not in _ANY))
    if misspelt and not (node.remapped and any(name.endswith(f"/{node.name}") for name in lines)):
        raise ParameterError(misspelt)
    return found


def load(cls: type[Parameters], path: str | Path, node: str) -> Parameters:
    """Make the dataclass from a file.

    Args:
        cls: parameter dataclass of the node.
        path: the file.
        node: name of the node.

    Raises:
        ParameterError: the file has no value for the node, or as file_values and from_mapping.
    """
    values = file_values(cls, path, NodeName(node))
    if not values:
        raise ParameterError(f"{path}: no section '/**/{node}'")
    return from_mapping(cls, {name: value for name, value in values.items() if not is_ros_own(name)})


def _sections(node: NodeName, namespace: str, entries: dict[str, Entry]) -> Iterator[tuple[str, Entry]]:
    """Yield full name and content of the sections of a file in its order, however their namespaces are written."""
    for key, entry in entries.items():
        name = f"{namespace}/{key.strip('/')}"
        below = entry.value
        meant = key.strip("/").rpartition("/")[2] in (node.name, *_ANY)
        if isinstance(below, dict) and _KEY not in below and not (meant and not _holds_section(below)):
            yield from _sections(node, name, below)
        else:
            yield name, entry


def _holds_section(entries: dict[str, Entry]) -> bool:
    return any(
        isinstance(each.value, dict) and (_KEY in each.value or _holds_section(each.value)) for each in entries.values()
    )


def _section_values(cls: type, path: str | Path, name: str, section: Entry, *, strict: bool) -> dict[str, Any]:
    """Return the values of one section; a section that is not `strict` may hold parameters of other nodes."""
    entries = section.value if isinstance(section.value, dict) else {}
    strangers = set(entries) - {_KEY}
    if strangers or (strict and _KEY not in entries):
        raise ParameterError(f"{path}: line {section.line}: section '{name}' must hold '{_KEY}' and nothing else")
    values = entries[_KEY].value if entries else {}
    if values is not None and not isinstance(values, dict):
        raise ParameterError(f"{path}: line {entries[_KEY].line}: '{_KEY}' must hold names and values")
    known = declared(cls)
    found: dict[str, Any] = {}
    lines: dict[str, int] = {}
    for name, each in _flat(values or {}):
        if name in lines:
            raise ParameterError(f"{path}: line {each.line}: '{name}' is repeated here, first in line {lines[name]}")
        lines[name] = each.line
        try:
            if is_ros_own(name):
                found[name] = ros_value(name, each.value)
            elif name in known:
                found[name] = checked(name, known[name].hint, known[name].limits, each.value)
            elif strict:
                raise ParameterError(unknown(cls, name))
        except ParameterError as error:
            raise ParameterError(f"{path}: line {each.line}: {error}") from error
    return found


def ros_value(name: str, value: Any) -> Any:
    """Return the value of a parameter that ROS declares.

    Raises:
        ParameterError: it has the wrong type.
    """
    if not isinstance(value, bool if name in _ROS_OWN else (bool, int, str)):
        raise ParameterError(f"parameter '{name}' = {value!r} has the wrong type")
    return value


def _flat(entries: dict[str, Entry]) -> Iterator[tuple[str, Entry]]:
    for name, entry in entries.items():
        if isinstance(entry.value, dict):
            yield from ((f"{name}.{inner}", each) for inner, each in _flat(entry.value))
        else:
            yield name, entry


def _pattern(section: str) -> str:
    """Return a regular expression for the full names of a section; * stands for one part of a name, ** for any."""
    parts = {"**": "(/[^/]+)*", "*": "/[^/]+"}
    return "".join(parts.get(part, "/" + re.escape(part)) for part in section.strip("/").split("/"))


def _is_misspelt(found: str, right: str) -> bool:
    """Whether one name is nearly another. friction_slope_rear and friction_slope2 are not: they name a second node."""
    if found != f"{right}_node" and re.fullmatch(re.escape(right) + "(_.*|[0-9]+)", found):
        return False
    letters = [re.sub("[^a-z0-9]", "", name.lower()) for name in (found, right, f"{right}_node")]
    if letters[0] in letters[1:]:
        return True
    return 2 * abs(len(found) - len(right)) < len(right) and SequenceMatcher(None, found, right).ratio() >= _ALIKE
