"""Vehicle files: one YAML file says all that the graph knows of a car.

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

What is said of an axle holds for its wheels, what is said of a wheel decides. A standard deviation is of an error that
the wheels share for which it is said: of all wheels, of an axle, of one.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any, get_type_hints

from friction_parameters.parameter import ParameterError, checked, parameter
from friction_parameters.yaml_source import Entry, read_yaml, refuse_repeated
from vehicle_models.vehicle import FRONT, REAR, Accelerometer, Deviation, SharedBy, Vehicle, Wheel

_SHIPPED = Path(__file__).parent / "vehicles"
_TOPIC_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*")
_TWO_AXLES = ("front_load_share", "wheelbase", "centre_of_gravity_height", "track")
"""What a car with two axles must give."""
_OF_ONE_WHEEL = ("axle", "side")


def shipped_vehicles() -> tuple[str, ...]:
    """Names of the vehicle files that come with this package."""
    return tuple(sorted(path.stem for path in _SHIPPED.glob("*.yaml")))


def vehicle_path(name: str | Path) -> Path:
    """Path of a vehicle file.

    Args:
        name: path, or name of a shipped file.

    Raises:
        ParameterError: there is no such file; the text names those shipped.
    """
    if str(name) in shipped_vehicles():
        return _SHIPPED / f"{name}.yaml"
    if str(name) and Path(name).is_file():
        return Path(name).absolute()
    what = f"there is no vehicle file '{name}'" if str(name) else "no vehicle file is given ('vehicle_file')"
    raise ParameterError(f"{what}: give a path, or one of those shipped: {', '.join(shipped_vehicles())}")


def vehicle_file_parameter(default: str = "") -> Any:
    """Parameter `vehicle_file` of a node."""
    text = "the car: path of a vehicle file, or the name of a shipped one"
    return parameter(default, text, read_only=True)


def moved(key: str) -> str:
    """Say where a parameter that was a node's stands now, for its MOVED."""
    return f"it is '{key}' of the vehicle file (parameter 'vehicle_file')"


def load_vehicle(name: str | Path) -> Vehicle:
    """Read a vehicle.

    Args:
        name: path of a vehicle file, or name of a shipped one.

    Raises:
        ParameterError: in one line with file, line, key, unit and range: there is no such file, a key is unknown or
            missing or stands twice, a value is bad, or the whole makes no car.
    """
    path = vehicle_path(name)
    try:
        return _vehicle(_File(path), read_yaml(path))
    except OSError as error:
        raise ParameterError(f"{path}: {error.strerror}") from error


class _File:
    """Reads the entries of one file; errors name file and line."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def error(self, entry: Entry, text: str) -> ParameterError:
        return ParameterError(f"{self.path}: line {entry.line}: {text}")

    def mapping(self, key: str, entry: Entry) -> dict[str, Entry]:
        """Entries of a mapping."""
        if not isinstance(entry.value, dict):
            raise self.error(entry, f"'{key}' must hold keys and values")
        return entry.value

    def known(self, entries: Mapping[str, Entry], known: tuple[str, ...]) -> None:
        """Refuse a key that means nothing here."""
        for key, entry in entries.items():
            if key not in known:
                raise self.error(entry, f"unknown key '{key}': known here are {', '.join(known)}")

    def values(
        self, cls: type, entries: Mapping[str, Entry], shared_by: SharedBy
    ) -> tuple[dict[str, Any], dict[str, Deviation]]:
        """Values of fields of `cls` and their deviations."""
        hints = get_type_hints(cls)
        values, deviations = {}, {}
        for name, limits in _limits(cls).items():
            if name not in entries:
                continue
            entry = entries[name]
            given, stddev = self._value_and_stddev(name, entry)
            try:
                values[name] = checked(name, hints[name], limits, given)
            except ParameterError as error:
                raise self.error(entry, str(error).replace("parameter '", "'", 1)) from error
            if stddev is not None:
                if hints[name] is not float:
                    raise self.error(entry, f"'{name}' has no standard deviation")
                unit = f" {limits['unit']}" if limits["unit"] else ""
                if not isinstance(stddev, (int, float)) or not 0.0 < stddev < float("inf"):
                    raise self.error(entry, f"'stddev' of '{name}' = {stddev}{unit} must be a number > 0")
                deviations[name] = Deviation(float(stddev), shared_by)
        return values, deviations

    def _value_and_stddev(self, name: str, entry: Entry) -> tuple[Any, Any]:
        if not isinstance(entry.value, dict):
            return entry.value, None
        self.known(entry.value, ("value", "stddev"))
        if "value" not in entry.value:
            raise self.error(entry, f"'{name}' has no 'value'")
        stddev = entry.value.get("stddev")
        return entry.value["value"].value, None if stddev is None else stddev.value


def _limits(cls: type) -> dict[str, Mapping[str, Any]]:
    """Fields of a dataclass that a file gives, with their limits."""
    return {each.name: each.metadata for each in fields(cls) if "description" in each.metadata}


def _vehicle(file: _File, entries: dict[str, Entry]) -> Vehicle:
    for key, entry in entries.items():
        refuse_repeated(file.path, key, entry)
    parts = ("name", "accelerometer", "all_wheels", "axles", "wheels")
    file.known(entries, (*parts[:1], *_limits(Vehicle), *parts[1:]))
    for key in ("name", "mass", "wheels"):
        if key not in entries:
            raise ParameterError(f"{file.path}: '{key}' is missing")
    if not isinstance(entries["name"].value, str):
        raise file.error(entries["name"], f"'name' = {entries['name'].value} must be a text")
    values, deviations = file.values(Vehicle, entries, SharedBy.ALL)
    wheels = tuple(_wheels(file, entries))
    if any(wheel.axle == REAR for wheel in wheels):
        for key in _TWO_AXLES:
            if key not in entries:
                raise ParameterError(f"{file.path}: '{key}' is missing: a car with two axles needs it")
    try:
        mounting = _accelerometer(file, entries)
        return Vehicle(entries["name"].value, wheels, **values, accelerometer=mounting, deviations=deviations)
    except ParameterError:
        raise
    except ValueError as error:
        raise ParameterError(f"{file.path}: {error}") from error


def _accelerometer(file: _File, entries: dict[str, Entry]) -> Accelerometer:
    if "accelerometer" not in entries:
        return Accelerometer()
    given = file.mapping("accelerometer", entries["accelerometer"])
    file.known(given, tuple(_limits(Accelerometer)))
    values, deviations = file.values(Accelerometer, given, SharedBy.ALL)
    try:
        return Accelerometer(**values, deviations=deviations)
    except ValueError as error:
        raise file.error(entries["accelerometer"], f"'accelerometer': {error}") from error


def _wheels(file: _File, entries: dict[str, Entry]) -> Iterator[Wheel]:
    common = tuple(name for name in _limits(Wheel) if name not in _OF_ONE_WHEEL)
    all_wheels = file.mapping("all_wheels", entries.get("all_wheels", Entry(0, {})))
    file.known(all_wheels, common)
    axles = file.mapping("axles", entries.get("axles", Entry(0, {})))
    file.known(axles, (FRONT, REAR))
    for axle, entry in axles.items():
        file.known(file.mapping(axle, entry), common)
    for name, entry in file.mapping("wheels", entries["wheels"]).items():
        given = file.mapping(name, entry)
        file.known(given, ("joint", *_limits(Wheel)))
        if not _TOPIC_NAME.fullmatch(name):
            raise file.error(entry, f"wheel '{name}': topics begin with it, so letters, digits and _ only; see 'joint'")
        joint = given["joint"].value if "joint" in given else name
        if not (isinstance(joint, str) and joint):
            raise file.error(given["joint"], f"'joint' = {joint} must be a text")
        axle = given["axle"].value if "axle" in given else None
        if axle not in (FRONT, REAR):
            raise file.error(entry, f"wheel '{name}': 'axle' must be {FRONT} or {REAR}")
        values: dict[str, Any] = {}
        deviations: dict[str, Deviation] = {}
        of_axle = axles[axle].value if axle in axles else {}
        for part, shared_by in ((all_wheels, SharedBy.ALL), (of_axle, SharedBy.AXLE), (given, SharedBy.WHEEL)):
            found, stated = file.values(Wheel, part, shared_by)
            values.update(found)
            deviations = {key: each for key, each in deviations.items() if key not in found or key in stated} | stated
        missing = [each.name for each in fields(Wheel) if each.default is not MISSING and each.default != each.default]
        for key in missing:
            if key not in values:
                raise file.error(entry, f"'{key}' of wheel '{name}' is missing")
        yield Wheel(name, joint, **values, deviations=deviations)
