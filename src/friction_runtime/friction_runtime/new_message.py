"""Messages without defaults for fields that are set anyway, and without the checks of their setters."""

from os import getenv
from typing import Any

_CHECK_FIELDS = getenv("ROS_PYTHON_CHECK_FIELDS") == "1"
_bare_classes: dict[Any, Any] = {}
"""By message class."""


def new_message(kind: Any) -> Any:
    """Return a message without any field set: the caller sets every one of them.

    The generated constructor makes a default for every field, sub-messages and arrays included, even for those that are
    given. That takes five times as long as setting them. The generated setters and getters are Python functions that
    take six times as long as the slots behind them. A forgotten field is an AttributeError on publishing.

    Args:
        kind: generated message class.
    """
    bare = _bare_classes.get(kind)
    if bare is None:
        bare = _bare_classes[kind] = kind if _CHECK_FIELDS else _bare_class(kind)
    message = bare.__new__(bare)
    message._check_fields = _CHECK_FIELDS
    return message


def _bare_class(kind: Any) -> Any:
    """Return a subclass whose fields are the slots themselves. Its messages say that they are of the class itself."""
    fields = {name: getattr(kind, f"_{name}") for name in kind.get_fields_and_field_types()}
    own = {"__slots__": (), "__module__": kind.__module__, "__class__": kind}
    return type(kind)(kind.__name__, (kind,), {**own, **fields})
