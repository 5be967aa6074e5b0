"""Parameter dataclasses by the names of their parameters: flat, dotted, checked."""

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields, is_dataclass, replace
from typing import Any, TypeVar, get_type_hints

from friction_parameters.parameter import ParameterError, checked

Parameters = TypeVar("Parameters")


@dataclass(frozen=True)
class Declared:
    """A parameter as its dataclass declares it."""

    name: str
    """Dotted name: those of the groups it belongs to, then its own."""
    hint: Any
    """Annotated type."""
    default: Any
    limits: Mapping[str, Any]
    """Arguments of `parameter`: description, unit, minimum, maximum, choices, read_only."""
    only: str = ""
    """Text that names the methods it serves, if not all."""


def declared(cls: type) -> dict[str, Declared]:
    """Return the parameters of a dataclass and of those it holds, by dotted name, in the order of declaration.

    Raises:
        TypeError: a field was not made with `parameter` or `group`.
    """
    found: dict[str, Declared] = {}
    hints = get_type_hints(cls)
    for each in fields(cls):
        if each.default is MISSING or not each.metadata:
            raise TypeError(f"{cls.__name__}.{each.name} is not a parameter: make it with parameter(...) or group(...)")
        if is_dataclass(hints[each.name]):
            for inner in declared(hints[each.name]).values():
                name = f"{each.name}.{inner.name}"
                only = ", ".join(filter(None, (only_with(each.metadata), inner.only)))
                found[name] = Declared(name, inner.hint, _value(each.default, inner.name), inner.limits, only)
        else:
            found[each.name] = Declared(each.name, hints[each.name], each.default, each.metadata)
    return found


def only_with(metadata: Mapping[str, Any]) -> str:
    """Return a text that names the methods a group serves, from the metadata of its field; empty if all."""
    return f"only with {metadata['selector']} {_one_of(metadata['methods'])}" if metadata["selector"] else ""


def values_of(parameters: Any) -> dict[str, Any]:
    """Return the values of a parameter dataclass by dotted name."""
    return {name: _value(parameters, name) for name in declared(type(parameters))}


def from_mapping(cls: type[Parameters], values: Mapping[str, Any]) -> Parameters:
    """Make the dataclass from names and values; the other parameters have their defaults.

    Args:
        cls: a parameter dataclass.
        values: values by dotted name, or nested as in a parameter file.

    Raises:
        ParameterError: a name is unknown, a type is wrong, a value is out of range, or the combination is refused.
    """
    return changed(cls(), flattened(values))


def changed(parameters: Parameters, values: Mapping[str, Any]) -> Parameters:
    """Make a copy of a parameter dataclass with other values, by dotted name.

    Raises:
        ParameterError: as from_mapping.
    """
    known = declared(type(parameters))
    accepted = {}
    for name, value in values.items():
        if name not in known:
            raise ParameterError(unknown(type(parameters), name))
        accepted[name] = checked(name, known[name].hint, known[name].limits, value)
    try:
        return _replaced(parameters, accepted)
    except ParameterError:
        raise
    except ValueError as error:
        raise ParameterError(str(error)) from error


def flattened(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return a nested mapping as a flat one with dotted names."""
    found: dict[str, Any] = {}
    for name, value in values.items():
        if isinstance(value, Mapping):
            found.update({f"{name}.{inner}": each for inner, each in flattened(value).items()})
        else:
            found[str(name)] = value
    return found


def unknown(cls: type, name: str) -> str:
    """Return the text of an unknown parameter: its new place if it was renamed, or the known parameters."""
    if place := moved(cls, name):
        return f"parameter '{name}' no longer exists: {place}"
    last = name.split(".")[-1]
    near = [known for known in declared(cls) if known.split(".")[-1] == last]
    perhaps = f", perhaps {' or '.join(near)}" if near else ""
    return f"unknown parameter '{name}'{perhaps}: known are {', '.join(declared(cls))}"


def moved(cls: type, name: str) -> str:
    """Return the new place of a renamed parameter, from MOVED of the class; empty if there is none."""
    places: Mapping[str, str] = getattr(cls, "MOVED", {})
    return places.get(name, "")


def ignored(parameters: Any) -> list[str]:
    """Return texts on parameters that were set for a method that is not chosen, one per group."""
    lines = []
    for each in fields(parameters):
        selector, methods = each.metadata.get("selector", ""), each.metadata.get("methods", ())
        if not selector or getattr(parameters, selector) in methods:
            continue
        inner, default = getattr(parameters, each.name), each.default
        names = [
            f"{each.name}.{name}" for name in declared(type(inner)) if _value(inner, name) != _value(default, name)
        ]
        if names:
            chosen = getattr(parameters, selector)
            lines.append(f"{', '.join(names)}: ignored, as '{selector}' is '{chosen}', not {_one_of(methods)}")
    return lines


def _one_of(names: tuple[str, ...]) -> str:
    return " or ".join(filter(None, (", ".join(names[:-1]), names[-1])))


def _value(parameters: Any, name: str) -> Any:
    for part in name.split("."):
        parameters = getattr(parameters, part)
    return parameters


def _replaced(parameters: Parameters, values: Mapping[str, Any], group: str = "") -> Parameters:
    own = {name: value for name, value in values.items() if "." not in name}
    inner: dict[str, dict[str, Any]] = {}
    for name, value in values.items():
        outer, dot, rest = name.partition(".")
        if dot:
            inner.setdefault(outer, {})[rest] = value
    for outer, changes in inner.items():
        try:
            own[outer] = _replaced(getattr(parameters, outer), changes, f"{group}{outer}.")
        except ParameterError:
            raise
        except ValueError as error:
            raise ParameterError(f"{group}{outer}: {error}") from error
    return replace(parameters, **own)  # type: ignore[type-var]
