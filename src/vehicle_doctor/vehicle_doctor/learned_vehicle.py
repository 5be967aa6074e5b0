"""Vehicle file with the values learned from a drive; comments and everything else stay as they are."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import yaml

from friction_parameters.parameter import ParameterError
from vehicle_doctor.findings import Finding, Verdict
from vehicle_models.vehicle import Vehicle, specified_stddev
from vehicle_models.vehicle_file import load_vehicle


def learned_values(findings: Sequence[Finding], vehicle: Vehicle) -> dict[str, tuple[float, float]]:
    """Return the values to write, with their deviations, by dotted key.

    A value known from several signals is their mean, its standard deviation the largest with their spread. One that
    agrees with the file is omitted where the file is more accurate.
    """
    by_key: dict[str, list[tuple[float, float]]] = {}
    contradicted: set[str] = set()
    for finding in findings:
        for key, pair in finding.learned.items():
            by_key.setdefault(key, []).append(pair)
            if finding.verdict in (Verdict.WARN, Verdict.FAIL):
                contradicted.add(key)
    found = {}
    for key, pairs in by_key.items():
        values, deviations = np.array(pairs).T
        pair = float(values.mean()), float(np.hypot(deviations.max(), values.std()))
        specified = stddev_in_file(vehicle, key)
        is_told = np.isfinite(pair).all() and (key in contradicted or specified is None or pair[1] < specified)
        if is_told:
            found[key] = pair
    return found


def stddev_in_file(vehicle: Vehicle, key: str) -> float | None:
    """Return the deviation that the file states for a dotted key; None where it states none."""
    *path, name = key.split(".")
    part = vehicle.wheel(path[1]) if path[:1] == ["wheels"] else vehicle.accelerometer if path else vehicle
    return specified_stddev(part.deviations, name)


def learned_file(findings: Sequence[Finding], source: Path) -> tuple[str, list[str]]:
    """Return the text of the vehicle file with what was learned, and why what of it is left out.

    Args:
        findings: of a drive of this car.
        source: its vehicle file.
    """
    text, left_out = source.read_text(encoding="utf-8"), []
    for key, (value, stddev) in learned_values(findings, load_vehicle(source)).items():
        trial = with_values(text, {key: (value, stddev)})
        fault = _fault(trial, source)
        if fault:
            left_out.append(f"{key} = {value:.4g} ± {stddev:.2g} is not written: {fault}")
        else:
            text = trial
    return text, left_out


def _fault(text: str, source: Path) -> str:
    """Return why a text is no vehicle file; empty where it is one."""
    with TemporaryDirectory() as directory:
        trial = Path(directory, source.name)
        trial.write_text(text, encoding="utf-8")
        try:
            load_vehicle(trial)
        except ParameterError as error:
            return str(error).replace(str(trial), source.name)
    return ""


Edit = tuple[int, int, str]
"""Begin and end of the text to replace, and the new text."""
_EXACT = ("accelerometer.sign",)
"""Keys without a deviation."""


def with_values(text: str, learned: Mapping[str, tuple[float, float]]) -> str:
    """Set values and deviations in the text of a vehicle file, one after the other.

    Args:
        text: text of a valid vehicle file.
        learned: value and its standard deviation by dotted key, such as `wheels.FL.radius` or `accelerometer.bias`.

    Returns:
        The new text.
    """
    for key, (value, stddev) in learned.items():
        text = _with_value(text, key.split("."), value, None if key in _EXACT else stddev)
    return text


def _with_value(text: str, path: list[str], value: float, stddev: float | None) -> str:
    node = yaml.compose(text, Loader=yaml.SafeLoader)
    missing = list(path)
    while len(missing) > 1 and (inner := _value(node, missing[0])) is not None:
        node = inner
        missing.pop(0)
    values = {"value": _number(value)} if stddev is None else {"value": _number(value), "stddev": _number(stddev)}
    given = _value(node, missing[0])
    if isinstance(given, yaml.MappingNode) and stddev is not None:
        edits = [_entry(given, key, each) for key, each in values.items()]
    else:
        new = values["value"] if stddev is None else f"{{value: {values['value']}, stddev: {values['stddev']}}}"
        for key in reversed(missing[1:]):
            new = f"{{{key}: {new}}}"
        edits = [_entry(node, missing[0], new)]
    for begin, end, new in sorted(edits, reverse=True):
        text = text[:begin] + new + text[end:]
    return text


def _number(value: float) -> str:
    """Five digits, in a form that YAML takes for a number."""
    text = f"{value:.5g}"
    mantissa, e, exponent = text.partition("e")
    return text if not e or "." in mantissa else f"{mantissa}.0e{exponent}"


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
