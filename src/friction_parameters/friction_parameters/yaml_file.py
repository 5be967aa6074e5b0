"""YAML files with line numbers; scalars have the types that the parser of ROS gives them.

So a value in a parameter file, after `-p` and in a vehicle file is read in the same way. Only y and n stay strings,
because y is an axis. Repeated keys, aliases and tags of other kinds are refused.
"""

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from friction_parameters.parameter import ParameterError

_DEEPEST = 20
_WORDS = {
    **dict.fromkeys("true True TRUE yes Yes YES on On ON".split(), True),
    **dict.fromkeys("false False FALSE no No NO off Off OFF".split(), False),
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
    **dict.fromkeys((".inf", ".Inf", ".INF", "+.inf", "+.Inf", "+.INF"), float("inf")),
    **dict.fromkeys(("-.inf", "-.Inf", "-.INF"), float("-inf")),
}
_INTEGER = re.compile(r"[-+]?(0|[1-9][0-9]{0,17})")
_FLOAT = re.compile(r"[-+]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][-+]?[0-9]+)?")
_TAGS = {yaml.ScalarNode: ("str",), yaml.SequenceNode: ("seq", "python/tuple"), yaml.MappingNode: ("map",)}
"""Accepted tags of each kind of node; launch_ros writes a list as a Python tuple."""


@dataclass(frozen=True)
class Entry:
    """A value of a mapping."""

    line: int
    """Line of its key, from 1."""
    value: Any
    """A scalar, a list, or a dict of Entry."""


class YamlEntries:
    """Entries of one file; errors name file and line."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def error(self, entry: Entry, text: str) -> ParameterError:
        """Return an error at an entry."""
        return ParameterError(f"{self.path}: line {entry.line}: {text}")

    def mapping(self, key: str, entry: Entry) -> dict[str, Entry]:
        """Return the entries of a mapping.

        Raises:
            ParameterError: it is none.
        """
        if not isinstance(entry.value, dict):
            raise self.error(entry, f"'{key}' must hold keys and values")
        return entry.value

    def known(self, entries: Mapping[str, Entry], known: Collection[str]) -> None:
        """Refuse a key that is unknown here.

        Raises:
            ParameterError: a key is unknown; the text names those that are known.
        """
        for key, entry in entries.items():
            if key not in known:
                raise self.error(entry, f"unknown key '{key}': known here are {', '.join(known)}")


def read_yaml(path: str | Path, what: str) -> dict[str, Entry]:
    """Read a file that holds one mapping; `what` kind of file it is stands in the text where it cannot be read.

    Raises:
        ParameterError: the file cannot be read, is not YAML, a key is repeated, or its top level is not a mapping.
    """
    try:
        node = _node(Path(path).read_text(encoding="utf-8"))
        if node is None:
            return {}
        if not isinstance(node, yaml.MappingNode):
            raise ParameterError(f"line {node.start_mark.line + 1}: a mapping is expected")
        return _mapping(node, 0)
    except OSError as error:
        raise ParameterError(f"{what} {path}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise ParameterError(f"{path}: not UTF-8 text: {error}") from error
    except ParameterError as error:
        raise ParameterError(f"{path}: {error}") from error


def read_value(text: str) -> Any:
    """Read a value after `name:=` on a command line.

    Raises:
        ParameterError: the text is not YAML.
    """
    node = _node(text)
    return None if node is None else plain(_value(node, 0))


def yaml_text(value: Any) -> str:
    """Return a scalar, a list or a tuple as YAML in one line, which ROS and `read_value` read in the same way."""
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(yaml_text(each) for each in value)}]"
    if isinstance(value, float):
        if value != value or abs(value) == float("inf"):
            return f"{value}".replace("inf", ".inf").replace("nan", ".nan")
        mantissa, exponent, power = repr(value).partition("e")
        return f"{mantissa if '.' in mantissa else mantissa + '.0'}{exponent}{power}"
    if isinstance(value, str):
        return yaml.safe_dump(value, default_style='"', width=float("inf")).strip()
    return (
        {True: "true", False: "false", None: "null"}[value] if value is None or isinstance(value, bool) else str(value)
    )


def plain(value: Any) -> Any:
    """Return a value without its line numbers."""
    if isinstance(value, dict):
        return {key: plain(entry.value) for key, entry in value.items()}
    return value


class _Loader(yaml.BaseLoader):
    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        if self.check_event(yaml.AliasEvent):
            raise yaml.composer.ComposerError(None, None, "aliases are not supported", self.peek_event().start_mark)
        return super().compose_node(parent, index)


def _node(text: str) -> yaml.Node | None:
    try:
        return yaml.compose(text, Loader=_Loader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = f"line {mark.line + 1}: " if mark else ""
        raise ParameterError(f"{where}not YAML: {error.problem or error.context}") from error
    except yaml.YAMLError as error:
        raise ParameterError(f"not YAML: {error}") from error
    except RecursionError:
        raise ParameterError("nested too deep") from None


def _mapping(node: yaml.MappingNode, depth: int) -> dict[str, Entry]:
    found: dict[str, Entry] = {}
    for key_node, value_node in node.value:
        line = key_node.start_mark.line + 1
        if not isinstance(key_node, yaml.ScalarNode):
            raise ParameterError(f"line {line}: a key must be a text")
        key = str(key_node.value)
        if key in found:
            raise ParameterError(f"line {line}: '{key}' is repeated here, first in line {found[key].line}")
        found[key] = Entry(line, _value(value_node, depth + 1))
    return found


def _value(node: yaml.Node, depth: int) -> Any:
    line = node.start_mark.line + 1
    if node.tag.removeprefix("tag:yaml.org,2002:") not in _TAGS[type(node)]:
        raise ParameterError(f"line {line}: the tag '{node.tag}' is not supported")
    if depth > _DEEPEST:
        raise ParameterError(f"line {line}: nested too deep")
    if isinstance(node, yaml.MappingNode):
        return _mapping(node, depth)
    if isinstance(node, yaml.SequenceNode):
        return [plain(_value(each, depth + 1)) for each in node.value]
    text = str(node.value)
    return text if isinstance(node, yaml.ScalarNode) and node.style else _scalar(text)


def _scalar(text: str) -> Any:
    if text in _WORDS:
        return _WORDS[text]
    if _INTEGER.fullmatch(text):
        return int(text)
    return float(text) if _FLOAT.fullmatch(text) else text
