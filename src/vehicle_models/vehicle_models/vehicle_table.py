"""The keys of a vehicle file as a Markdown table, from the dataclasses that hold them."""

from dataclasses import fields
from typing import Any

from friction_parameters.generated import range_text, table_row
from friction_parameters.yaml_file import yaml_text
from vehicle_models.vehicle import Accelerometer, Vehicle, Wheel
from vehicle_models.vehicle_file import TWO_AXLES_NEED, file_keys, required_keys

_PARTS = (("", Vehicle), ("accelerometer.", Accelerometer), ("wheels.NAME.", Wheel))


def vehicle_table() -> str:
    """Markdown table of the keys."""
    lines = [table_row("key", "unit", "range", "default", ""), "|---|---|---|---|---|"]
    for prefix, cls in _PARTS:
        defaults = {each.name: each.default for each in fields(cls)}
        required = (*required_keys(cls), "axle")
        for key, limits in file_keys(cls).items():
            default = "required" if key in required else _default(key, defaults[key])
            lines.append(
                table_row(f"`{prefix}{key}`", limits["unit"], range_text(limits), default, limits["description"])
            )
    return "\n".join(lines) + "\n"


def _default(key: str, value: Any) -> str:
    return "required if there is a rear axle" if key in TWO_AXLES_NEED else f"`{yaml_text(value)}`"
