"""One parameter: a dataclass field that carries its description, unit, range and choices.

    @dataclass(frozen=True)
    class DetectorParameters:
        window: int = parameter(28, "samples of the fit that gives H", minimum=3, maximum=400)

    @dataclass(frozen=True)
    class FrictionSlopeParameters:
        method: str = parameter("slip", "where the sign comes from", choices=("slip", "no_slip"))
        detector: DetectorParameters = group(DetectorParameters())

The algorithm's dataclass holds the field; a node's dataclass holds the algorithm's, so that its parameter is
`detector.window`. Allowed types: bool, int, float, str, tuple[float, ...], tuple[str, ...]; tuples are never empty, as
ROS cannot infer the type of an empty list. A dataclass may refuse combinations of values by raising ValueError in
__post_init__.
"""

from dataclasses import field
from math import isfinite
from typing import Any


class ParameterError(ValueError):
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
