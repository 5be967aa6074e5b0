"""Parameter files and tables written from the dataclasses, so that each parameter is defined once."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

from friction_parameters.parameter import declared, is_constant, only_with, values_of
from friction_parameters.parameter_file import EVERY_NODE
from friction_parameters.yaml_file import yaml_text

_COMMENT_COLUMN = 44
_INDENT = "  "


@dataclass(frozen=True)
class ShippedFile:
    """A parameter file that a package ships."""

    heading: str
    """Comment at the top of the file; may have several lines."""
    parameters: Any
    """Values of the file: an instance of the node's dataclass."""


def parameter_file(node: str, shipped: ShippedFile) -> str:
    """Return the text of a node's parameter file with every parameter."""
    lines = [f"# {line}" for line in shipped.heading.splitlines()]
    lines += ["# Written by `make docs` from the dataclass of the node: change it there.", f"{EVERY_NODE}/{node}:"]
    lines += [f"{_INDENT}ros__parameters:", *_lines(shipped.parameters, 2 * _INDENT)]
    return "\n".join(lines) + "\n"


def parameter_table(shipped: ShippedFile) -> str:
    """Return a Markdown table of the parameters of a node."""
    lines = ["| parameter | shipped value | unit | range | |", "|---|---|---|---|---|"]
    values = values_of(shipped.parameters)
    for name, each in declared(type(shipped.parameters)).items():
        notes = [each.limits["description"], each.only, "start only" if each.limits["read_only"] else ""]
        text = "; ".join(note for note in notes if note)
        lines.append(
            table_row(f"`{name}`", f"`{yaml_text(values[name])}`", each.limits["unit"], range_text(each.limits), text)
        )
    return "\n".join(lines) + "\n"


def range_text(limits: Mapping[str, Any]) -> str:
    """Describe the values that a parameter may have; empty if any."""
    if limits["choices"]:
        return ", ".join(limits["choices"])
    low, high = (None if limits[name] is None else _number(limits[name]) for name in ("minimum", "maximum"))
    if low is None:
        return "" if high is None else f"at most {high}"
    return f"at least {low}" if high is None else f"{low} to {high}"


def table_row(*cells: str) -> str:
    """Return a row of a Markdown table."""
    escaped = [re.sub(r"([|<])", r"\\\1", cell) for cell in cells]
    return f"| {' | '.join(escaped)} |"


def _number(value: float) -> str:
    short = f"{value:g}"
    return short if float(short) == value else str(value)


def _lines(parameters: Any, indent: str) -> Iterator[str]:
    for each in fields(parameters):
        value = getattr(parameters, each.name)
        if is_constant(each.metadata):
            continue
        if is_dataclass(value):
            yield _commented(f"{indent}{each.name}:", only_with(each.metadata))
            yield from _lines(value, indent + _INDENT)
        else:
            # An empty string is not a choice: if written, it would override a value given further left.
            unset = "# " if value == "" else ""
            yield _commented(f"{indent}{unset}{each.name}: {yaml_text(value)}", _comment(each.metadata))


def _commented(text: str, comment: str) -> str:
    return f"{text:<{_COMMENT_COLUMN}}  # {comment}" if comment else text


def _comment(limits: Mapping[str, Any]) -> str:
    unit = f"[{limits['unit']}] " if limits["unit"] else ""
    allowed = f" ({range_text(limits)})" if range_text(limits) else ""
    return f"{unit}{limits['description']}{allowed}{'; start only' if limits['read_only'] else ''}"
