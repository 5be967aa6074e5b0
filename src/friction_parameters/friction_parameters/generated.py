"""Parameter files and tables written from the dataclasses, so that nothing is said twice."""

import json
from dataclasses import dataclass
from typing import Any

from friction_parameters.parameter_file import EVERY_NODE
from friction_parameters.values import Declared, declared, values_of

_COMMENT_COLUMN = 44


@dataclass(frozen=True)
class ShippedFile:
    """A parameter file that a package ships."""

    heading: str
    """What it is for; one line each."""
    parameters: Any
    """Its values: an instance of the node's dataclass."""


def parameter_file(node: str, shipped: ShippedFile) -> str:
    """Text of a parameter file of a node with every parameter."""
    lines = [f"# {line}" for line in shipped.heading.splitlines()]
    lines += ["# Written by `make docs` from the dataclass of the node: change it there.", f"{EVERY_NODE}/{node}:"]
    lines.append("  ros__parameters:")
    known, above = declared(type(shipped.parameters)), ""
    for name, value in values_of(shipped.parameters).items():
        outer, _, own = name.rpartition(".")
        for depth, part in enumerate(outer.split(".") if outer != above and outer else ()):
            if outer.split(".")[: depth + 1] != above.split(".")[: depth + 1]:
                lines.append(f"{' ' * (4 + 2 * depth)}{part}:")
        above = outer
        text = f"{' ' * (4 + 2 * (outer.count('.') + 1 if outer else 0))}{own}: {_text(value)}"
        lines.append(f"{text:<{_COMMENT_COLUMN}}  # {_comment(known[name])}")
    return "\n".join(lines) + "\n"


def parameter_table(shipped: ShippedFile) -> str:
    """Markdown table of the parameters of a node."""
    lines = ["| parameter | shipped value | unit | range | |", "|---|---|---|---|---|"]
    values = values_of(shipped.parameters)
    for name, each in declared(type(shipped.parameters)).items():
        start_only = " Start only." if each.limits["read_only"] else ""
        cells = f"`{name}`", f"`{_text(values[name])}`", each.limits["unit"], _range(each), each.limits["description"]
        lines.append(f"| {' | '.join(cells)}.{start_only} |")
    return "\n".join(lines) + "\n"


def _comment(each: Declared) -> str:
    unit = f"[{each.limits['unit']}] " if each.limits["unit"] else ""
    allowed = f" ({_range(each)})" if _range(each) else ""
    return f"{unit}{each.limits['description']}{allowed}{'; start only' if each.limits['read_only'] else ''}"


def _range(each: Declared) -> str:
    limits = each.limits
    if limits["choices"]:
        return ", ".join(limits["choices"])
    if limits["minimum"] is None and limits["maximum"] is None:
        return ""
    if limits["maximum"] is None:
        return f"at least {limits['minimum']:g}"
    if limits["minimum"] is None:
        return f"at most {limits['maximum']:g}"
    return f"{limits['minimum']:g} to {limits['maximum']:g}"


def _text(value: Any) -> str:
    """A value as YAML that ROS and PyYAML read alike."""
    if isinstance(value, tuple):
        return f"[{', '.join(_text(each) for each in value)}]"
    if isinstance(value, float):
        text = repr(value)
        mantissa, exponent, power = text.partition("e")
        return f"{mantissa if '.' in mantissa else mantissa + '.0'}{exponent}{power}"
    return json.dumps(value)
