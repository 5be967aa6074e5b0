"""Algorithms import no messages: the enums that stand for constants of messages have their names and values."""

from __future__ import annotations

import ast
import re
from enum import IntEnum
from pathlib import Path
from typing import Any

import friction_msgs.msg
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from friction_msgs.msg import BrakeCommand, FrictionCurveDebug, SupervisorState, Validity

import abs_supervisor.arbitration
import abs_supervisor.intervention
import abs_supervisor.state_machine
import friction_curve_id.interface
import friction_runtime.processor
import vehicle_models.brake_actuator
import vehicle_models.reason

SOURCES = Path(__file__).parents[1] / "src"
MESSAGES = SOURCES / "friction_msgs" / "msg"
MIRRORED: list[tuple[type[IntEnum], Any, str]] = [
    (vehicle_models.brake_actuator.Command, BrakeCommand, ""),
    (abs_supervisor.state_machine.Cause, SupervisorState, "CAUSE_"),
    (abs_supervisor.state_machine.State, SupervisorState, "S0 S1 S21 S22"),
    (abs_supervisor.arbitration.Change, SupervisorState, "CHANGE_"),
    (abs_supervisor.arbitration.Law, SupervisorState, "LAW_"),
    (abs_supervisor.intervention.Limit, SupervisorState, "LIMIT_"),
    (abs_supervisor.intervention.Phase, SupervisorState, "STANDBY ACTIVE RETURN"),
    (abs_supervisor.intervention.Release, SupervisorState, "RELEASE_"),
    (friction_curve_id.interface.RestartCause, FrictionCurveDebug, "RESTART_"),
    (friction_runtime.processor.Level, DiagnosticStatus, ""),
    (vehicle_models.reason.Reason, Validity, ""),
]
"""Enum, message, and which of its constants: those of a prefix, those named, or all but the ones with a prefix."""
OF_OTHERS = {"STALE"}
"""Constant without an enum: that of aggregators."""


def constants(message: Any, which: str) -> dict[str, int]:
    """Values of constants of a message, by their names without prefix."""
    attributes: Any = type(message).__prepare__(message.__name__, ())
    values = {name: value for name, value in attributes.items() if "__" not in name and name not in OF_OTHERS}
    if which.endswith("_"):
        found = {name.removeprefix(which): value for name, value in values.items() if name.startswith(which)}
    elif which:
        found = {name: values[name] for name in which.split()}
    else:
        others = {name for _, other, names in MIRRORED if other is message for name in names.split()}
        found = {name: value for name, value in values.items() if not name.startswith(tuple(others))}
    return {name: value[0] if isinstance(value, bytes) else value for name, value in found.items()}


OF_NO_MESSAGE = {"friction_curve_id.car.unknowns.Unknown"}
"""Places in an array."""


@pytest.mark.parametrize(
    ("enum", "message", "which"), MIRRORED, ids=[f"{enum.__module__}.{enum.__name__}" for enum, _, _ in MIRRORED]
)
def test_enum_has_the_constants_of_the_message(enum: type[IntEnum], message: Any, which: str) -> None:
    assert {member.name: member.value for member in enum} == constants(message, which)


def test_validity_is_a_block_of_its_own_in_every_message_of_an_estimate() -> None:
    kinds = [kind for name, kind in vars(friction_msgs.msg).items() if name[0].isupper() and kind is not Validity]
    fields = [kind.get_fields_and_field_types() for kind in kinds]
    assert not [each for each in fields if {"valid", "reason", "text"} & each.keys()]
    assert sum("friction_msgs/Validity" in each.values() for each in fields) == 10


def test_every_field_has_a_comment() -> None:
    declared = re.compile(r"^[\w/\[\]]+ +\w+(?! *=)\b(?! *=).*$", re.MULTILINE)
    fields = [line for file in MESSAGES.glob("*.msg") for line in declared.findall(file.read_text())]
    assert len(fields) > 100
    assert not [line for line in fields if "#" not in line]


def test_readme_lists_every_message() -> None:
    readme = (MESSAGES.parent / "README.md").read_text()
    listed = re.findall(r"^\| `(\w+)` \|", readme, re.MULTILINE)
    assert sorted(listed) == sorted(file.stem for file in MESSAGES.glob("*.msg"))


def test_every_enum_of_the_packages_that_has_numbers_is_compared() -> None:
    found = {
        f"{'.'.join(file.relative_to(package.parent).with_suffix('').parts)}.{node.name}"
        for package in (setup.parent / setup.parent.name for setup in SOURCES.glob("*/setup.py"))
        for file in package.rglob("*.py")
        for node in ast.walk(ast.parse(file.read_text()))
        if isinstance(node, ast.ClassDef) and any(ast.unparse(base).endswith("IntEnum") for base in node.bases)
    }
    assert found - OF_NO_MESSAGE == {f"{enum.__module__}.{enum.__name__}" for enum, _, _ in MIRRORED}
