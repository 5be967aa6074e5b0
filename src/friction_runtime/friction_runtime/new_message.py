"""Messages without defaults for fields that are set anyway."""

from os import getenv
from typing import Any

_CHECK_FIELDS = getenv("ROS_PYTHON_CHECK_FIELDS") == "1"


def new_message(kind: Any) -> Any:
    """Return a message without any field set: the caller sets every one of them.

    The generated constructor makes a default for every field, sub-messages and arrays included, even for those that are
    given. That takes five times as long as setting them. A forgotten field is an AttributeError on publishing.

    Args:
        kind: generated message class.
    """
    message = kind.__new__(kind)
    message._check_fields = _CHECK_FIELDS
    return message
