"""Definitions of message types that are installed, as rosbag2 embeds them in a bag."""

import json
import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from ament_index_python.packages import PackageNotFoundError, get_package_share_directory

from friction_runtime.message_type import TYPE_NAME, UnknownTypeError

_SEPARATOR = "=" * 80
_FIELD_TYPE = re.compile(r"^\s*((?:[A-Za-z]\w*/)*[A-Za-z]\w*)(?:<=\d+)?(?:\[[^\]]*\])?\s+[A-Za-z]\w*")
_PRIMITIVES = frozenset(
    "bool byte char float32 float64 int8 uint8 int16 uint16 int32 uint32 int64 uint64 string wstring".split()
)


@dataclass(frozen=True)
class MessageDefinition:
    """Definition of a message type."""

    text: str
    """Text in the ros2msg encoding: its own .msg file, then those of all types it refers to."""
    type_hash: str
    """RIHS01 hash."""


@cache
def message_definition(type_name: str) -> MessageDefinition:
    """Return the definition of an installed type, from the share directory of its package.

    Args:
        type_name: e.g. sensor_msgs/msg/JointState.

    Raises:
        UnknownTypeError: the type or one it refers to is not installed.
    """
    own = _msg_path(type_name)
    texts = {_short(type_name): own.read_text(encoding="utf-8")}
    waiting = [_short(type_name)]
    while waiting:
        current = waiting.pop(0)
        for referred in _references(current, texts[current]):
            if referred not in texts:
                texts[referred] = _msg_path(referred).read_text(encoding="utf-8")
                waiting.append(referred)
    parts = [
        text if name == _short(type_name) else f"{_SEPARATOR}\nMSG: {name}\n{text}" for name, text in texts.items()
    ]
    return MessageDefinition("\n".join(part.rstrip("\n") for part in parts) + "\n", _type_hash(own, type_name))


@cache
def type_name(kind: Any) -> str:
    """Return the name of a message class, e.g. sensor_msgs/msg/JointState."""
    return f"{kind.__module__.split('.')[0]}/msg/{kind.__name__}"


def _references(owner: str, text: str) -> list[str]:
    """Return the types that a .msg file refers to, as package/Name, in their order."""
    found = []
    for line in text.splitlines():
        match = _FIELD_TYPE.match(line.split("#", 1)[0])
        if match is None or match[1] in _PRIMITIVES:
            continue
        name = match[1]
        if "/" not in name:
            name = f"{owner.split('/')[0]}/{name}"
        found.append(_short(name))
    return found


def _short(type_name: str) -> str:
    return type_name.replace("/msg/", "/")


def _msg_path(type_name: str) -> Path:
    if not TYPE_NAME.fullmatch(type_name):
        raise UnknownTypeError(f"{type_name!r} is not the name of a type")
    package, name = _short(type_name).split("/")
    try:
        path = Path(get_package_share_directory(package), "msg", f"{name}.msg")
    except (PackageNotFoundError, ValueError) as error:
        raise UnknownTypeError(f"type {type_name} is not installed: package {package} was not found") from error
    if not path.is_file():
        raise UnknownTypeError(f"type {type_name}: package {package} has no definition {name}.msg")
    return path


def _type_hash(msg_path: Path, type_name: str) -> str:
    described = json.loads(msg_path.with_suffix(".json").read_text(encoding="utf-8"))
    package, name = _short(type_name).split("/")
    wanted = f"{package}/msg/{name}"
    return next(str(each["hash_string"]) for each in described["type_hashes"] if each["type_name"] == wanted)
