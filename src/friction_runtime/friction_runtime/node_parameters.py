"""Parameters of a dataclass declared on a node, and kept up to date."""

from collections.abc import Callable
from typing import Any, TypeVar

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from friction_parameters.parameter import (
    Declared,
    ParameterError,
    changed,
    checked,
    converted,
    declared,
    unknown,
    values_of,
)
from friction_parameters.parameter_file import is_ros_own

Parameters = TypeVar("Parameters")


def declare(node: Node, cls: type[Parameters], apply: Callable[[Parameters], None]) -> Parameters:
    """Declare the parameters on a node, return their values, and call `apply` after each later change.

    A change is refused, with the reason, when a value is bad or when `apply` raises ValueError. An integer is accepted
    for a float, at start and later.

    Raises:
        ParameterError: a value given at start is bad, or an unknown parameter was given.
    """
    known = declared(cls)
    given: dict[str, Any] = {}
    for name, override in node._parameter_overrides.items():
        if name in known:
            given[name] = checked(name, known[name].hint, known[name].limits, override.value)
        elif not is_ros_own(name):
            raise ParameterError(f"node {node.get_fully_qualified_name()}: {unknown(cls, name)}")
    current = changed(cls(), given)
    for name, value in values_of(current).items():
        # The value is declared, not the default: an override of the wrong kind of number has been converted.
        listed = list(value) if isinstance(value, tuple) else value
        node.declare_parameter(name, listed, _descriptor(known[name]), ignore_override=True)

    def on_set(changes: list[Parameter]) -> SetParametersResult:
        nonlocal current
        named = {change.name: change.value for change in changes if change.name in known}
        if not named:
            return SetParametersResult(successful=True)
        try:
            candidate = changed(current, named)
            apply(candidate)
        except ValueError as error:
            return SetParametersResult(successful=False, reason=str(error))
        current = candidate
        return SetParametersResult(successful=True)

    def with_right_numbers(changes: list[Parameter]) -> list[Parameter]:
        # Before ROS compares the types: it does not convert them.
        return [_converted(known[change.name], change) if change.name in known else change for change in changes]

    node.add_pre_set_parameters_callback(with_right_numbers)
    node.add_on_set_parameters_callback(on_set)
    return current


def _converted(parameter: Declared, change: Parameter) -> Parameter:
    try:
        value = converted(parameter.name, parameter.hint, change.value)
    except ParameterError:
        return change  # refused further on
    return Parameter(parameter.name, value=list(value) if isinstance(value, tuple) else value)


def _descriptor(parameter: Declared) -> ParameterDescriptor:
    limits = parameter.limits
    unit = f" [{limits['unit']}]" if limits["unit"] else ""
    descriptor = ParameterDescriptor(
        name=parameter.name,
        description=limits["description"] + unit,
        read_only=limits["read_only"],
        additional_constraints=f"one of {', '.join(limits['choices'])}" if limits["choices"] else "",
    )
    low, high = limits["minimum"], limits["maximum"]
    if low is not None and high is not None:
        if parameter.hint is float:
            descriptor.floating_point_range = [FloatingPointRange(from_value=float(low), to_value=float(high))]
        elif parameter.hint is int:
            descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high), step=1)]
    return descriptor
