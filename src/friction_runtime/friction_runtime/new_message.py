"""Messages without the defaults that nobody reads."""

from os import getenv
from typing import Any

_CHECK_FIELDS = getenv("ROS_PYTHON_CHECK_FIELDS") == "1"


def new_message(kind: Any) -> Any:
    """Message of a class, none of its fields set: the caller sets every one of them.

    The generated constructor makes a default of every field, sub-messages and arrays too, even of those that are given,
    which takes five times as long as setting them. A field that is forgotten is an AttributeError on publishing.

    Args:
        kind: generated class of a message.
    """
    message = kind.__new__(kind)
    message._check_fields = _CHECK_FIELDS
    return message
