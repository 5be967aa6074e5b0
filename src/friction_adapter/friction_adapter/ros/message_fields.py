"""Fields of installed message types."""

import re
from functools import cache
from typing import Any

from friction_adapter.field_path import Fields
from friction_runtime.message_type import UnknownTypeError, message_class

_SEQUENCE = re.compile(r"sequence<(.+?)(?:, \d+)?>|(.+)\[\d+\]")


@cache
def installed_fields(type_name: str) -> Fields:
    """Return the fields of an installed type.

    Raises:
        ValueError: the type is not installed.
    """
    try:
        kind: Any = message_class(type_name)
    except UnknownTypeError as error:
        raise ValueError(str(error)) from error
    return Fields({name: _fields(text) for name, text in kind.get_fields_and_field_types().items()})


def _fields(text: str) -> Fields:
    """Return the fields of a type as rosidl describes it: double, std_msgs/Header, sequence<string>, double[9]."""
    sequence = _SEQUENCE.fullmatch(text)
    element = (sequence[1] or sequence[2]) if sequence else text
    members = installed_fields(element.replace("/", "/msg/")).members if "/" in element else {}
    return Fields(members, is_sequence=sequence is not None)
