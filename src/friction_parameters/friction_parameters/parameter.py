"""Parameters as fields of frozen dataclasses; by dotted name they are listed, checked and changed.

    @dataclass(frozen=True)
    class Tuning:
        edge_lag: float = constant(0.5, "age of an edge in sample intervals")

    @dataclass(frozen=True)
    class DetectorParameters:
        window: int = parameter(26, "samples of the fit that gives H", minimum=3, maximum=400)

    @dataclass(frozen=True)
    class FrictionSlopeParameters:
        method: str = parameter("slip", "source of the slip rate's sign", choices=("slip", "no_slip"))
        detector: DetectorParameters = group(DetectorParameters())
        tuning: Tuning = constants(Tuning())

The parameter `window` is named `detector.window`. The fields of `tuning` are no parameters: code varies them
with `dataclasses.replace`. Allowed types: bool, int, float, str, tuple[float, ...], tuple[str, ...]; tuples are never
empty, as ROS cannot infer the type of an empty list. A dataclass may refuse combinations of values by raising
ValueError in __post_init__.
"""

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields, is_dataclass, replace
from math import isfinite
from typing import Any, TypeVar, get_type_hints

from friction_parameters.command_line import UserError

Parameters = TypeVar("Parameters")

_CONSTANT = "constant"


class ParameterError(UserError, ValueError):
    """A parameter or a parameter file is not valid; the text, one line, names the error and its place."""

    def __init__(self, text: str) -> None:
        super().__init__(" ".join(text.split()))


def parameter(
    default: Any,
    description: str,
    *,
    unit: str = "",
    minimum: float | None = None,
    maximum: float | None = None,
    choices: tuple[str, ...] = (),
    read_only: bool = False,
) -> Any:
    """Return a field of a parameter dataclass.

    Args:
        default: default value, of the annotated type.
        description: description in one line, without the unit.
        unit: SI unit, empty for a dimensionless number or no number.
        minimum: smallest value allowed (of each element of a tuple).
        maximum: largest value allowed (of each element of a tuple).
        choices: strings allowed (of each element of a tuple).
        read_only: whether it can be set at start only.
    """
    metadata = {
        "description": description,
        "unit": unit,
        "minimum": minimum,
        "maximum": maximum,
        "choices": choices,
        "read_only": read_only,
    }
    return field(default=default, metadata=metadata)


def group(default: Any, *, selector: str = "", methods: tuple[str, ...] = ()) -> Any:
    """Return a field that holds a parameter dataclass: its parameters are named `field.parameter`.

    Args:
        default: instance of the dataclass.
        selector: name of the parameter that chooses a method, where the group serves some methods only.
        methods: values of `selector` that the group serves; for others its parameters are ignored.
    """
    return field(default=default, metadata={"selector": selector, "methods": methods})


def constants(default: Any) -> Any:
    """Return a field that holds a frozen dataclass of constants: no parameters, neither listed nor read from files."""
    return field(default=default, metadata={_CONSTANT: True})


def constant(default: Any, description: str, *, unit: str = "") -> Any:
    """Return a field that is no parameter: a physical quantity with its meaning and unit, for a frozen dataclass."""
    return field(default=default, metadata={_CONSTANT: True, "description": description, "unit": unit})


def is_constant(metadata: Mapping[str, Any]) -> bool:
    """Whether a field was made with `constant` or `constants`, from its metadata."""
    return _CONSTANT in metadata


def max_gap_parameter(default: float) -> Any:
    """Parameter that many nodes have: longest time between two samples of one input that is bridged [s]."""
    text = "longest time between two samples of an input; a longer gap is not interpolated, and the estimate restarts"
    return parameter(default, text, unit="s", minimum=0.001, maximum=2.0)


def minimum_speed_parameter(default: float) -> Any:
    """Parameter that many nodes have: vehicle speed below which nothing is estimated [m/s]."""
    return parameter(default, "no estimate below this vehicle speed", unit="m/s", minimum=0.1, maximum=50.0)


def deadline_parameter(default: float = 0.05, read_only: bool = False) -> Any:
    """Parameter that many nodes have: message time for which the primary input waits for the others [s]."""
    said = "message time a sample waits for the other inputs"
    return parameter(default, said, unit="s", minimum=0.001, maximum=1.0, read_only=read_only)


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
    """Return the parameters of a dataclass and of its groups, by dotted name, in the order of declaration.

    Raises:
        TypeError: a field was not made with `parameter`, `group`, `constant` or `constants`.
    """
    found: dict[str, Declared] = {}
    hints = get_type_hints(cls)
    for each in fields(cls):
        if each.default is MISSING or not each.metadata:
            raise TypeError(f"{cls.__name__}.{each.name} is not a parameter: make it with parameter(...) or group(...)")
        if is_constant(each.metadata):
            continue
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
    """Make the dataclass from values by dotted name, or nested as in a parameter file; the others have their defaults.

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
    """Return the text of an unknown parameter, with the known ones."""
    last = name.split(".")[-1]
    near = [known for known in declared(cls) if known.split(".")[-1] == last]
    perhaps = f", perhaps {' or '.join(near)}" if near else ""
    return f"unknown parameter '{name}'{perhaps}: known are {', '.join(declared(cls))}"


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


def checked(name: str, hint: Any, limits: Any, value: Any) -> Any:
    """Convert and check one value.

    Args:
        name: name of the parameter, for the text of an error.
        hint: annotated type.
        limits: metadata of the field, made by `parameter`.
        value: given value; an integer is accepted for a float, a list for a tuple.

    Raises:
        ParameterError: the type is wrong, or the value is outside range or choices.
    """
    result = converted(name, hint, value)
    elements = result if isinstance(result, tuple) else (result,)
    unit = f" {limits['unit']}" if limits["unit"] else ""
    low, high = limits["minimum"], limits["maximum"]
    for element in elements:
        if limits["choices"] and element not in limits["choices"]:
            raise ParameterError(f"parameter '{name}' = {element!r} must be one of {', '.join(limits['choices'])}")
        # The comparisons are written so that NaN fails them.
        if (low is not None and not element >= low) or (high is not None and not element <= high):
            allowed = f"[{'-inf' if low is None else low}, {'inf' if high is None else high}]"
            raise ParameterError(f"parameter '{name}' = {element}{unit} is outside {allowed}")
        if isinstance(element, float) and not isfinite(element):
            raise ParameterError(f"parameter '{name}' = {element} is not a finite number")
    return result


def converted(name: str, hint: Any, value: Any) -> Any:
    """Convert one value, as `checked` does, without checking its range.

    Raises:
        ParameterError: the type is wrong, or a list is empty.
    """
    if hint not in (tuple[float, ...], tuple[str, ...]):
        return _scalar(name, hint, value)
    if not isinstance(value, (list, tuple)) and not hasattr(value, "tolist"):
        raise ParameterError(f"parameter '{name}' = {value!r} must be a list")
    kind = float if hint == tuple[float, ...] else str
    if not (elements := tuple(_scalar(name, kind, element) for element in value)):
        raise ParameterError(f"parameter '{name}' is empty")
    return elements


def _scalar(name: str, kind: Any, value: Any) -> Any:
    if hasattr(value, "item"):
        value = value.item()
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        try:
            return float(value)
        except OverflowError:
            raise ParameterError(f"parameter '{name}' is too large a number") from None
    if type(value) is not kind:
        raise ParameterError(f"parameter '{name}' = {value!r} must be of type {kind.__name__}")
    return value


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
