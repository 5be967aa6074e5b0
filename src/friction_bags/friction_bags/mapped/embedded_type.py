"""Messages of a topic whose type need not be installed, by the definition in the bag."""

from contextlib import suppress
from typing import Any

from rosbags.interfaces import Nodetype
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore

from friction_adapter.field_path import Fields
from friction_bags.bag_io.bag_format import BagError, Topic
from friction_bags.bag_io.cdr import decode, message_definition
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
        self._store: Any = get_typestore(Stores.EMPTY)
        try:
            of_text = get_types_from_idl(text) if encoding == "ros2idl" else get_types_from_msg(text, topic.type)
            self._store.register(of_text)
            self.fields = fields_in(self._store, topic.type)
            """Fields of the type."""
        except Exception as error:  # rosbags passes on whatever its parser raises
            raise BagError(f"{topic.name}: the definition of {topic.type} cannot be read") from error

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


def fields_in(store: Any, type_name: str) -> Fields:
    """Return the fields of a type in a store of rosbags.

    Raises:
        KeyError: it, or one that it refers to, is not there.
    """
    return Fields({name: _fields(store, description) for name, description in store.fielddefs[type_name][1]})


def _fields(store: Any, description: Any) -> Fields:
    kind, details = description
    if kind in (Nodetype.ARRAY, Nodetype.SEQUENCE):
        return Fields(_fields(store, details[0]).members, is_sequence=True)
    return fields_in(store, details) if kind == Nodetype.NAME else Fields({})
