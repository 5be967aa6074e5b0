"""Messages to CDR and back, and the definitions of their types.

rclpy's own serialization does not initialise the padding between fields, and appends padding to a message that ends
with an empty sequence of doubles; rosbags pads with zeros and appends nothing, so that equal messages give equal bytes.
Its decoding takes half the time of rclpy's, which is kept for messages with that padding: rosbags refuses them.
"""

import json
import re
from array import array
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from ament_index_python.packages import PackageNotFoundError, get_package_share_directory
from rclpy.serialization import deserialize_message
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from friction_bags.bag_io.bag_format import Topic
from friction_runtime.installed import TYPE_NAME, UnknownTypeError

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


def installed_topic(name: str, kind: type) -> Topic:
    """Return the topic of a message class, with its definition.

    Raises:
        UnknownTypeError: the definition is not installed.
    """
    definition = message_definition(type_name(kind))
    return Topic(name, type_name(kind), definition.text, "ros2msg", definition.type_hash)


def encode(message: Any) -> bytes:
    """Return the CDR of a message, little endian, with its encapsulation header.

    Raises:
        UnknownTypeError: the definition of the message is not installed.
    """
    kind: Any = type(message)
    name = type_name(kind)
    return bytes(_store_of(name).serialize_cdr(_Numpy(message), name))


def decode(data: bytes, kind: Any) -> Any:
    """Decode CDR to an object with the fields of a message: to be read like the message, not to be published.

    Raises:
        ValueError: the data is not a message of this class.
    """
    name = type_name(kind)
    try:
        return _store_of(name).deserialize_cdr(data, name)
    except SerdeError:
        pass
    try:
        return deserialize_message(data, kind)
    except Exception as error:  # rclpy has no common class for errors of its middleware
        raise ValueError(f"not a {name}: {error}") from error


@cache
def _store_of(type_name: str) -> Any:
    """Return the types of rosbags with which a message of an installed type is read and written."""
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(message_definition(type_name).text, type_name))
    return store


class _Numpy:
    """A message whose number sequences are numpy arrays, as rosbags writes them."""

    def __init__(self, message: Any) -> None:
        self._message = message

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._message, name)
        return np.array(value, dtype=value.typecode) if isinstance(value, array) else value


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
