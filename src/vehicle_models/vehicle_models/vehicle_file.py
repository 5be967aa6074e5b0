"""Vehicle files: one YAML file holds all parameters of a car.

    name: my car
    mass: {value: 1620.0, stddev: 60.0}           # a value, or a value with its standard deviation
    front_load_share: 0.58
    wheelbase: 2.68
    centre_of_gravity_height: 0.54
    track: 1.55
    accelerometer: {axis: x, sign: 1}
    all_wheels: {inertia: 1.1, brake_gain: {value: 1.0e-4, stddev: 1.0e-5}}
    axles:
      front: {radius: 0.31}
      rear: {radius: 0.315, driven: true}
    wheels:                                       # the names that topics begin with
      FL: {axle: front, side: left, joint: "car::wheel_fl"}
      FR: {axle: front, side: right, joint: "car::wheel_fr"}
      RL: {axle: rear, side: left, joint: "car::wheel_rl", radius: {value: 0.314, stddev: 0.001}}
      RR: {axle: rear, side: right, joint: "car::wheel_rr"}

A value of an axle holds for its wheels; a value of a wheel overrides it. A standard deviation is that of an error which
is shared by the wheels at its level: all wheels, an axle, or one.
"""

import re
from argparse import ArgumentParser
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, get_type_hints

from friction_parameters.generated import range_text, table_row
from friction_parameters.parameter import ParameterError, checked, parameter
from friction_parameters.yaml_file import Entry, YamlEntries, plain, read_yaml, yaml_text
from vehicle_models.vehicle import FRONT, REAR, Accelerometer, Deviation, SharedBy, Vehicle, Wheel

_SHIPPED = Path(__file__).parent / "vehicles"
_TOPIC_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*")
TWO_AXLES_NEED = ("front_load_share", "wheelbase", "centre_of_gravity_height", "track")
"""Keys that are required for a car with two axles."""
_OF_ONE_WHEEL = ("axle", "side")
_ANY_NUMBER = {"unit": "", "minimum": None, "maximum": None, "choices": ()}


def shipped_vehicles() -> tuple[str, ...]:
    """Names of the vehicle files that come with this package."""
    return tuple(sorted(path.stem for path in _SHIPPED.glob("*.yaml")))


def vehicle_choices() -> str:
    """Say how a car may be given, for help and refusals."""
    return f"a path, or one of those shipped: {', '.join(shipped_vehicles())}"


def vehicle_path(name: str | Path) -> Path:
    """Return the path of a vehicle file.

    Args:
        name: path, or name of a shipped file.

    Raises:
        ParameterError: there is no such file; the text names those shipped.
    """
    if str(name) in shipped_vehicles():
        return _SHIPPED / f"{name}.yaml"
    if str(name) and _is_file(Path(name)):
        return Path(name).absolute()
    what = f"there is no vehicle file '{name}'" if str(name) else "no vehicle file is given ('vehicle_file')"
    raise ParameterError(f"{what}: give {vehicle_choices()}")


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # the name is longer than the system allows, or has a zero in it
        return False


def vehicle_reference(name: str) -> str:
    """Return a name of a car that is valid in every directory: a shipped name as it is, else the absolute path.

    Raises:
        ParameterError: as vehicle_path.
    """
    path = vehicle_path(name)
    return name if name in shipped_vehicles() else str(path)


def vehicle_file_parameter(default: str = "") -> Any:
    """Parameter `vehicle_file` of a node."""
    text = "the car: path of a vehicle file, or the name of a shipped one"
    return parameter(default, text, read_only=True)


def load_vehicle(name: str | Path) -> Vehicle:
    """Read a vehicle.

    Args:
        name: path of a vehicle file, or name of a shipped one.

    Raises:
        ParameterError: there is no such file, a key is unknown, missing or repeated, a value is bad, or the values do
            not make a car. The text is one line with file, line, key, unit and range.
    """
    path = vehicle_path(name)
    return _vehicle(_File(path), read_yaml(path, "vehicle file"))


class _File(YamlEntries):
    """Values of a vehicle file."""

    def values(
        self, cls: type, entries: Mapping[str, Entry], shared_by: SharedBy
    ) -> tuple[dict[str, Any], dict[str, Deviation]]:
        """Values of fields of `cls` and their deviations."""
        hints = get_type_hints(cls)
        values, deviations = {}, {}
        for name, limits in file_keys(cls).items():
            if name not in entries:
                continue
            value, stddev = self._value_and_stddev(name, entries[name])
            try:
                values[name] = checked(name, hints[name], limits, plain(value.value))
            except ParameterError as error:
                text = f"'{name}' = {plain(value.value)!r} must be {_must_be(cls, name)}"
                raise self.error(value, text) from error
            if stddev is not None:
                if hints[name] is not float:
                    raise self.error(stddev, f"'stddev' of '{name}': it is no measured quantity")
                deviations[name] = Deviation(self._stddev(name, stddev, limits["unit"]), shared_by)
        return values, deviations

    def _value_and_stddev(self, name: str, entry: Entry) -> tuple[Entry, Entry | None]:
        if not isinstance(entry.value, dict):
            return entry, None
        self.known(entry.value, ("value", "stddev"))
        if "value" not in entry.value:
            raise self.error(entry, f"'{name}' has no 'value'")
        return entry.value["value"], entry.value.get("stddev")

    def _stddev(self, name: str, entry: Entry, unit: str) -> float:
        try:
            stddev = checked(name, float, _ANY_NUMBER, plain(entry.value))
        except ParameterError:
            stddev = -1.0
        if not stddev >= 0.0:
            text = f"'stddev' of '{name}' = {plain(entry.value)!r} must be a number >= 0{_in_brackets(unit)}"
            raise self.error(entry, text)
        return float(stddev)

    def misfit(self, error: ValueError, entries: Mapping[str, Entry]) -> ParameterError:
        """Return an error with the line of the key that the text of `error` begins with."""
        key = str(error).split("'")[1]
        return self.error(entries[key], str(error)) if key in entries else ParameterError(f"{self.path}: {error}")


def file_keys(cls: type) -> dict[str, Mapping[str, Any]]:
    """Fields of a dataclass that are keys of a file, with the arguments of `parameter`."""
    return {each.name: each.metadata for each in fields(cls) if "description" in each.metadata}


def required_keys(cls: type) -> tuple[str, ...]:
    """Fields that have no default."""
    return tuple(each.name for each in fields(cls) if each.name in file_keys(cls) and each.default != each.default)


def _must_be(cls: type, key: str) -> str:
    """Describe the valid values of a key."""
    hint, limits = get_type_hints(cls)[key], file_keys(cls)[key]
    if limits["choices"]:
        return f"one of {range_text(limits)}"
    if hint is bool:
        return "true or false"
    kind = "an integer" if hint is int else "a number"
    return f"{kind}, {range_text(limits)}{_in_brackets(limits['unit'])}"


def _in_brackets(unit: str) -> str:
    return f" [{unit}]" if unit else ""


def _vehicle(file: _File, entries: dict[str, Entry]) -> Vehicle:
    parts = ("accelerometer", "all_wheels", "axles", "wheels")
    file.known(entries, ("name", *file_keys(Vehicle), *parts))
    for key in ("name", "wheels"):
        if key not in entries:
            raise ParameterError(f"{file.path}: '{key}' is missing")
    name = entries["name"]
    if not (isinstance(name.value, str) and name.value):
        raise file.error(name, f"'name' = {plain(name.value)!r} must be a text")
    wheels = _wheels(file, entries)
    values, deviations = file.values(Vehicle, entries, SharedBy.ALL)
    needed = TWO_AXLES_NEED if any(wheel.axle == REAR for wheel in wheels) else ()
    for key in (*required_keys(Vehicle), *needed):
        if key not in values:
            why = ", as a wheel is on the axle 'rear'" if key in needed else ""
            raise ParameterError(f"{file.path}: '{key}' is missing{why}: {_must_be(Vehicle, key)}")
    mounting = _accelerometer(file, entries)
    try:
        return Vehicle(name.value, wheels, **values, accelerometer=mounting, deviations=deviations)
    except ValueError as error:
        raise file.misfit(error, entries) from error


def _accelerometer(file: _File, entries: dict[str, Entry]) -> Accelerometer:
    given = file.mapping("accelerometer", entries.get("accelerometer", Entry(0, {})))
    file.known(given, tuple(file_keys(Accelerometer)))
    values, deviations = file.values(Accelerometer, given, SharedBy.ALL)
    try:
        return Accelerometer(**values, deviations=deviations)
    except ValueError as error:
        raise file.misfit(error, given) from error


def _wheels(file: _File, entries: dict[str, Entry]) -> tuple[Wheel, ...]:
    common = tuple(name for name in file_keys(Wheel) if name not in _OF_ONE_WHEEL)
    all_wheels = file.mapping("all_wheels", entries.get("all_wheels", Entry(0, {})))
    file.known(all_wheels, common)
    axles = file.mapping("axles", entries.get("axles", Entry(0, {})))
    file.known(axles, (FRONT, REAR))
    for axle, entry in axles.items():
        file.known(file.mapping(axle, entry), common)
    parts = (all_wheels, {axle: entry.value for axle, entry in axles.items()})
    wheels = tuple(
        _wheel(file, name, entry, parts) for name, entry in file.mapping("wheels", entries["wheels"]).items()
    )
    for axle, entry in axles.items():
        if not any(wheel.axle == axle for wheel in wheels):
            raise file.error(entry, f"'{axle}': no wheel is on this axle")
    return wheels


def _wheel(file: _File, name: str, entry: Entry, common: tuple[dict[str, Entry], dict[str, dict[str, Entry]]]) -> Wheel:
    """Make a wheel from its own keys, those of its axle and of all wheels; `common` holds all wheels and the axles."""
    given = file.mapping(name, entry)
    file.known(given, ("joint", *file_keys(Wheel)))
    if not _TOPIC_NAME.fullmatch(name):
        raise file.error(
            entry,
            f"wheel '{name}': topics begin with this name, so it is of letters, digits and _, with no digit first; "
            "what wheel_states calls the wheel is its 'joint'",
        )
    joint = given.get("joint", Entry(entry.line, name))
    if not (isinstance(joint.value, str) and joint.value):
        raise file.error(joint, f"'joint' = {plain(joint.value)!r} must be a text")
    if "axle" not in given:
        raise file.error(entry, f"'axle' of wheel '{name}' is missing: one of {FRONT}, {REAR}")
    own, own_deviations = file.values(Wheel, given, SharedBy.WHEEL)
    values, deviations = file.values(Wheel, common[0], SharedBy.ALL)
    of_axle, axle_deviations = file.values(Wheel, common[1].get(own["axle"], {}), SharedBy.AXLE)
    for found, stated in ((of_axle, axle_deviations), (own, own_deviations)):
        values.update(found)
        deviations = {key: each for key, each in deviations.items() if key not in found} | stated
    for key in required_keys(Wheel):
        if key not in values:
            raise file.error(entry, f"'{key}' of wheel '{name}' is missing: {_must_be(Wheel, key)}")
    return Wheel(name, joint.value, **values, deviations=deviations)


def add_vehicle_argument(parser: ArgumentParser, otherwise: str) -> None:
    """Add `--vehicle`, empty by default; `otherwise` names the car that holds without it."""
    text = f"the car: {vehicle_choices()} (default: {otherwise})"
    parser.add_argument("--vehicle", default="", metavar="NAME|FILE", help=text)


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
