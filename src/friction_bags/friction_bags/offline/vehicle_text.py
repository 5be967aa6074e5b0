"""Text of a vehicle file with other radii; comments and everything else stay as they are."""

from collections.abc import Mapping

import yaml

Edit = tuple[int, int, str]
"""Begin and end of the text to replace, and the new text."""


def with_radii(text: str, found: Mapping[str, tuple[float, float]]) -> str:
    """Set the radii of the wheels in the text of a vehicle file.

    Args:
        text: text of a valid vehicle file.
        found: radius and its standard deviation [m] by the name of the wheel.

    Returns:
        The new text.
    """
    top = yaml.compose(text, Loader=yaml.SafeLoader)
    wheels = _value(top, "wheels")
    edits: list[Edit] = []
    for wheel, (radius, stddev) in found.items():
        # to 0.01 mm and 0.001 mm: no calibration is more accurate
        values = {"value": f"{radius:.5f}", "stddev": f"{max(stddev, 1e-6):.6f}"}
        mapping = _value(wheels, wheel)
        given = _value(mapping, "radius")
        if isinstance(given, yaml.MappingNode):
            edits += [_entry(given, key, value) for key, value in values.items()]
        else:
            edits.append(_entry(mapping, "radius", f"{{value: {values['value']}, stddev: {values['stddev']}}}"))
    for begin, end, new in sorted(edits, reverse=True):
        text = text[:begin] + new + text[end:]
    return text


def _value(mapping: yaml.Node | None, key: str) -> yaml.Node | None:
    if isinstance(mapping, yaml.MappingNode):
        for name, value in mapping.value:
            if name.value == key:
                return value
    return None


def _entry(mapping: yaml.Node | None, key: str, new: str) -> Edit:
    """Return the edit that sets a key of a mapping; a new key goes before the others."""
    assert isinstance(mapping, yaml.MappingNode)
    present = _value(mapping, key)
    if present is not None:
        return present.start_mark.index, present.end_mark.index, new
    if mapping.flow_style:
        begin = mapping.start_mark.index + 1
        return begin, begin, f"{key}: {new}{', ' if mapping.value else ''}"
    begin, column = mapping.start_mark.index, mapping.start_mark.column
    return begin, begin, f"{key}: {new}\n{' ' * column}"
