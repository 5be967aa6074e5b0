"""Parameter files on the command line of a node, checked before the middleware starts.

The middleware merges what it understands of a file and passes over the rest without a word. So each file is read here,
by the reader of the offline runner, and the middleware is given what that found.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml

from friction_parameters.parameter import ParameterError
from friction_parameters.parameter_file import EVERY_NODE, NodeName, file_values

_BEGIN, _END = "--ros-args", "--"
_FILE = "--params-file"
_REMAP = ("-r", "--remap")


def with_checked_files(arguments: Sequence[str], name: str, cls: type, directory: Path) -> list[str]:
    """Put files that hold what is meant for a node, and is right, in place of the parameter files.

    Args:
        arguments: command line of the node.
        name: of the node, unless it is remapped.
        cls: its parameter dataclass.
        directory: for the new files.

    Returns:
        The command line with the new files.

    Raises:
        ParameterError: a file cannot be read, or file_values refuses it.
    """
    node = _node_name(arguments, name)
    result: list[str] = []
    inside, places = False, iter(range(len(arguments)))
    for place in places:
        word = arguments[place]
        inside = word == _BEGIN or (inside and word != _END)
        if not (inside and word == _FILE and place + 1 < len(arguments)):
            result.append(word)
            continue
        path = arguments[next(places)]
        try:
            values = file_values(cls, path, node)
        except OSError as error:
            raise ParameterError(f"parameter file {path}: {error.strerror}") from error
        if values:
            result += [_FILE, str(_write(directory / f"{place}.yaml", values))]
    return result


def _node_name(arguments: Sequence[str], name: str) -> NodeName:
    """Name of the node after remapping."""
    namespace, inside = "/", False
    for word, following in zip(arguments, [*arguments[1:], ""], strict=True):
        inside = word == _BEGIN or (inside and word != _END)
        if inside and word in _REMAP:
            rule, _, value = following.partition(":=")
            rule = rule.rpartition(":")[2]
            if rule == "__ns":
                namespace = value
            elif rule in ("__node", "__name"):
                name = value
    return NodeName(name, namespace)


def _write(path: Path, values: dict[str, Any]) -> Path:
    plain = {key: list(value) if isinstance(value, tuple) else value for key, value in values.items()}
    path.write_text(yaml.safe_dump({EVERY_NODE: {"ros__parameters": plain}}), encoding="utf-8")
    return path
