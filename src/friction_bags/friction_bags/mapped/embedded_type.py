"""Messages of a topic whose type need not be installed, by the definition in the bag."""

from contextlib import suppress
from typing import Any

from rosbags.interfaces import Nodetype
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore

from friction_adapter.field_path import Fields
from friction_bags.bag_io.bag_format import BagError, Topic
from friction_bags.bag_io.cdr import decode
from friction_bags.bag_io.message_definition import message_definition
from friction_runtime.message_type import UnknownTypeError, message_class

_PADDING = 4
"""Bytes that rclpy appends to a message that ends with an empty sequence of doubles."""


class EmbeddedType:
    """The type of one topic."""

    def __init__(self, topic: Topic) -> None:
        """Read the definition.

        Raises:
            BagError: the bag holds none, or a damaged one, and the type is not installed.
        """
        self._name = topic.type
        self._kind: Any = None
        try:
            self._kind = message_class(topic.type)
            text, encoding = message_definition(topic.type).text, "ros2msg"
        except UnknownTypeError as error:
            if not topic.definition:
                raise BagError(f"{topic.name}: {error}; the bag holds no definition of it") from error
            text, encoding = topic.definition, topic.definition_encoding
        try:
            self._types = get_types_from_idl(text) if encoding == "ros2idl" else get_types_from_msg(text, topic.type)
            self.fields = Fields(self._members(topic.type))
            """Fields of the type."""
        except Exception as error:  # rosbags passes on whatever its parser raises
            raise BagError(f"{topic.name}: the definition of {topic.type} cannot be read") from error
        self._store: Any = get_typestore(Stores.EMPTY)
        self._store.register(self._types)

    def decode(self, data: bytes) -> Any:
        """Decode CDR to an object with the fields of the message.

        Raises:
            ValueError: the data is not a message of this type.
        """
        if self._kind is not None:
            return decode(data, self._kind)
        try:
            return self._store.deserialize_cdr(data, self._name)
        except SerdeError as error:
            with suppress(SerdeError):
                return self._store.deserialize_cdr(data[:-_PADDING], self._name)
            raise ValueError(f"not a {self._name}: {error}") from error

    def _members(self, name: str) -> dict[str, Fields]:
        return {member: self._fields(description) for member, description in self._types[name][1]}

    def _fields(self, description: Any) -> Fields:
        kind, details = description
        if kind in (Nodetype.ARRAY, Nodetype.SEQUENCE):
            return Fields(self._fields(details[0]).members, is_sequence=True)
        return Fields(self._members(details) if kind == Nodetype.NAME else {})
