"""Messages without defaults for fields that are set anyway, and without the checks of their setters."""

from functools import cache
from os import getenv
from typing import Any, Final

_CHECK_FIELDS: Final = getenv("ROS_PYTHON_CHECK_FIELDS") == "1"
_makers: Final[dict[Any, Any]] = {}
"""What makes a message, by its class."""


def new_message(kind: Any) -> Any:
    """Return a message without any field set: the caller sets every one of them.

    The generated constructor makes a default for every field, sub-messages and arrays included, even for those that are
    given. That takes five times as long as setting them. The generated setters and getters are Python functions that
    take six times as long as the slots behind them. A forgotten field is an AttributeError on publishing.

    Args:
        kind: generated message class.
    """
    make = _makers.get(kind)
    if make is None:
        make = _makers[kind] = kind if _CHECK_FIELDS else bare_class(kind)
    return make()


@cache
def bare_class(kind: Any) -> Any:
    """Return a subclass whose fields are the slots themselves. Its messages report the class itself as theirs."""
    fields = {name: getattr(kind, f"_{name}") for name in kind.get_fields_and_field_types()}
    own = {"__slots__": (), "__module__": kind.__module__, "__class__": kind, "__init__": object.__init__}
    # Asked for by repr() of a message with an array, set by copy().
    unchecked = property(lambda _: False, lambda *_: None)
    return type(kind)(kind.__name__, (kind,), {**own, "_check_fields": unchecked, **fields})
