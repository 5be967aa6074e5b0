"""Parameters as typed, frozen dataclasses: declared once, the same for a node, a parameter file and a test.

    @dataclass(frozen=True)
    class SlopeParameters:
        wheels: tuple[str, ...] = parameter(("front_left",), "names of the wheels", read_only=True)
        radius: float = parameter(0.3, "effective rolling radius", unit="m", minimum=0.05, maximum=2.0)

Allowed types: bool, int, float, str, tuple[float, ...], tuple[str, ...]. A dataclass may refuse combinations of
values by raising ValueError in __post_init__.
"""

from collections.abc import Callable, Mapping
from dataclasses import MISSING, Field, field, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, get_type_hints

import yaml
from ament_index_python.packages import get_package_share_directory

if TYPE_CHECKING:
    from rclpy.node import Node

Parameters = TypeVar("Parameters")


class ParameterError(ValueError):
    """A parameter has a value that makes no sense; the text names it."""


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
    """Field of a parameter dataclass.

    Args:
        default: its default; its type must be the annotated one.
        description: one line, without the unit.
        unit: SI unit, empty for a dimensionless number or no number.
        minimum: smallest value allowed (of each element of a tuple).
        maximum: largest value allowed (of each element of a tuple).
        choices: the texts allowed (of each element of a tuple).
        read_only: it can be set at start only.
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


def check_wheels(wheels: tuple[str, ...]) -> None:
    """Check the parameter 'wheels': names, at least one, each once.

    Raises:
        ParameterError: they are not.
    """
    if not wheels or len(set(wheels)) != len(wheels) or "" in wheels:
        raise ParameterError(f"parameter 'wheels' = {list(wheels)} must name at least one wheel, each once")


def per_wheel(name: str, values: tuple[float, ...], wheels: tuple[str, ...]) -> dict[str, float]:
    """Spread a parameter over the wheels: one value for all, or one each.

    Raises:
        ParameterError: neither one value nor one a wheel.
    """
    if len(values) == 1:
        return dict.fromkeys(wheels, values[0])
    if len(values) != len(wheels):
        raise ParameterError(
            f"parameter '{name}' has {len(values)} values for {len(wheels)} wheels: give one, or one each"
        )
    return dict(zip(wheels, values, strict=True))


def from_mapping(cls: type[Parameters], values: Mapping[str, Any]) -> Parameters:
    """Make the dataclass from names and values; what is not named has its default.

    Raises:
        ParameterError: a name is unknown, a type is wrong, a value is out of range, or the combination is refused.
    """
    known = {f.name: f for f in fields(cls)}  # type: ignore[arg-type]
    unknown = sorted(set(values) - set(known))
    if unknown:
        raise ParameterError(f"unknown parameter '{unknown[0]}': known are {', '.join(known)}")
    hints = get_type_hints(cls)
    checked = {name: _checked(known[name], hints[name], value) for name, value in values.items()}
    try:
        return cls(**checked)
    except ParameterError:
        raise
    except ValueError as error:
        raise ParameterError(str(error)) from error


def shipped_file(package: str, name: str = "") -> Path:
    """Parameter file that a package ships: `name`, or the one named like the package.

    Raises:
        PackageNotFoundError: the package is not installed.
    """
    return Path(get_package_share_directory(package), "config", f"{name or package}.yaml")


def load(cls: type[Parameters], path: str | Path, node_name: str) -> Parameters:
    """Make the dataclass from a ROS parameter file: the section of `node_name`, over that of `/**`.

    Raises:
        ParameterError: the file has neither section, or from_mapping refuses its values.
        OSError: the file cannot be read.
    """
    sections = yaml.safe_load(Path(path).read_text(encoding="utf-8")) or {}
    keys = ("/**", f"/**/{node_name}", node_name, f"/{node_name}")
    wanted = [sections[key]["ros__parameters"] for key in keys if key in sections]
    if not wanted:
        raise ParameterError(f"{path}: no section '{node_name}' and no section '/**'")
    merged: dict[str, Any] = {}
    for section in wanted:
        merged.update(section)
    merged.pop("use_sim_time", None)
    return from_mapping(cls, merged)


def declare(node: "Node", cls: type[Parameters], apply: Callable[[Parameters], None]) -> Parameters:
    """Declare the parameters on a node, return their values, and keep `apply` told of each later change.

    A change is refused, with the reason, when a value is bad or when `apply` raises ValueError.

    Raises:
        ParameterError: a value given at start is bad, or an unknown parameter was given.
    """
    from rcl_interfaces.msg import SetParametersResult
    from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
    from rclpy.parameter import Parameter as RosParameter

    known = fields(cls)  # type: ignore[arg-type]
    names = {f.name for f in known}
    for given in node._parameter_overrides:
        if given not in names and given != "use_sim_time" and not given.startswith("qos_overrides."):
            raise ParameterError(
                f"unknown parameter '{given}' for node {node.get_name()}: known are {', '.join(names)}"
            )
    hints = get_type_hints(cls)
    values: dict[str, Any] = {}
    for f in known:
        default = list(f.default) if isinstance(f.default, tuple) else f.default
        try:
            values[f.name] = node.declare_parameter(f.name, default, _descriptor(f, hints[f.name])).value
        except (InvalidParameterTypeException, InvalidParameterValueException) as error:
            raise ParameterError(f"parameter '{f.name}': {error}") from error
    current = from_mapping(cls, values)

    def on_set(changes: list[RosParameter]) -> SetParametersResult:
        nonlocal current
        named = {change.name: change.value for change in changes if change.name in names}
        if not named:
            return SetParametersResult(successful=True)
        try:
            checked = {f.name: _checked(f, hints[f.name], named[f.name]) for f in known if f.name in named}
            candidate = replace(current, **checked)  # type: ignore[type-var]
            apply(candidate)
        except ValueError as error:
            return SetParametersResult(successful=False, reason=str(error))
        current = candidate
        return SetParametersResult(successful=True)

    node.add_on_set_parameters_callback(on_set)
    return current


def _checked(declared: "Field[Any]", hint: Any, value: Any) -> Any:
    """Convert and check one value."""
    name, meta = declared.name, declared.metadata
    if declared.default is MISSING:
        raise TypeError(f"field '{name}' has no default: make it with parameter(...)")
    elements: tuple[Any, ...]
    if hint in (tuple[float, ...], tuple[str, ...]):
        if not isinstance(value, (list, tuple)) and not hasattr(value, "tolist"):
            raise ParameterError(f"parameter '{name}' = {value!r} must be a list")
        kind = float if hint == tuple[float, ...] else str
        elements = tuple(_converted(name, kind, element) for element in value)
        result: Any = elements
    else:
        result = _converted(name, hint, value)
        elements = (result,)
    unit = f" {meta['unit']}" if meta["unit"] else ""
    for element in elements:
        if meta["choices"] and element not in meta["choices"]:
            raise ParameterError(f"parameter '{name}' = '{element}' must be one of {', '.join(meta['choices'])}")
        low, high = meta["minimum"], meta["maximum"]
        # The comparisons are written so that NaN fails them.
        if (low is not None and not element >= low) or (high is not None and not element <= high):
            raise ParameterError(f"parameter '{name}' = {element}{unit} is outside [{low}, {high}]")
        if isinstance(element, float) and element != element:
            raise ParameterError(f"parameter '{name}' is not a number")
    return result


def _converted(name: str, kind: Any, value: Any) -> Any:
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if hasattr(value, "item"):
        value = value.item()
    if type(value) is not kind:
        raise ParameterError(f"parameter '{name}' = {value!r} must be of type {kind.__name__}")
    return value


def _descriptor(declared: "Field[Any]", hint: Any) -> Any:
    from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor

    meta = declared.metadata
    unit = f" [{meta['unit']}]" if meta["unit"] else ""
    descriptor = ParameterDescriptor(
        name=declared.name,
        description=meta["description"] + unit,
        read_only=meta["read_only"],
        additional_constraints=f"one of {', '.join(meta['choices'])}" if meta["choices"] else "",
    )
    low, high = meta["minimum"], meta["maximum"]
    if low is not None and high is not None:
        if hint is float:
            descriptor.floating_point_range = [FloatingPointRange(from_value=float(low), to_value=float(high))]
        elif hint is int:
            descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high), step=1)]
    return descriptor
