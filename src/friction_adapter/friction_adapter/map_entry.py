"""Entries of a signal map file: texts, numbers, and the signals of one quantity."""

import re
from collections.abc import Collection, Mapping
from math import inf, nan
from typing import Any, Final

from friction_adapter.signal_map import ARRIVAL, Flag, Kind, Origin, Quantity, Signal
from friction_adapter.sources import FieldPath
from friction_adapter.stamp_unit import STAMP_UNITS
from friction_adapter.unit_table import EDGES, PERCENT, UNITS, unit_named
from friction_parameters.yaml_file import Entry, YamlEntries, plain
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import Vehicle, Wheel

NUMBER_KEYS = (
    *("combine", "unit", "scale", "offset", "sign", "full_scale", "radius", "counter", "latency", "stddev"),
    *("invalid", "stamp", "stamp_unit"),
)
_LONGEST_LATENCY = 1.0
_RADII = 0.05, 2.0
_KEYS = ("from", "field", "fields", "valid", *NUMBER_KEYS)
_ORIGINS = "{topic: NAME, type: TYPE}, {can: SIGNAL}, {column: NAME}, can or table"
_WHEEL: Final = "{wheel}"
_JOINT: Final = "{joint}"
"""What stands for the name of each wheel, and for its name in wheel_states."""
_ALL: Final = "all"
_TYPE = re.compile(r"[a-zA-Z]\w*/msg/[A-Z]\w*", re.ASCII)


class MapEntries(YamlEntries):
    """Reads the entries of one map; errors name file and line."""

    def text(self, key: str, entry: Entry) -> str:
        """Return a text that is not empty."""
        if not (isinstance(entry.value, str) and entry.value):
            raise self.error(entry, f"'{key}' = {plain(entry.value)!r} must be a text")
        return entry.value

    def one_of(self, key: str, entry: Entry, choices: Collection[str]) -> str:
        """Return a text that is one of several."""
        if entry.value not in choices:
            raise self.error(entry, f"'{key}' = {plain(entry.value)!r} must be one of {', '.join(choices)}")
        return str(entry.value)

    def number(self, key: str, entry: Entry, least: float, most: float) -> float:
        """Return a number between two limits."""
        value = entry.value
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not least <= value <= most:
            raise self.error(entry, f"'{key}' = {plain(value)!r} must be a number from {least:g} to {most:g}")
        return float(value)


class EntryNumbers:
    """Reads these keys of the entry of one quantity."""

    def __init__(self, file: MapEntries, quantity: Quantity, entry: Entry) -> None:
        """Take the entry, a mapping of known keys."""
        self._file = file
        self._quantity = quantity
        self._entry = entry
        self._given = file.mapping(quantity.name, entry)

    def values(self, kind: Kind, stamp: str, stamp_unit: str) -> dict[str, Any]:
        """Return what holds for all wheels, by the name of the field in Signal.

        Args:
            kind: where the signal is found.
            stamp: stamp of the map, for an entry without one.
            stamp_unit: its unit, likewise.

        Raises:
            ParameterError: a value is not valid; the text names file and line.
        """
        unit = self._unit()
        found: dict[str, Any] = {"unit": unit, "stamp": stamp, "stamp_unit": stamp_unit}
        if "stamp_unit" in self._given:
            found["stamp_unit"] = self._file.one_of("stamp_unit", self._given["stamp_unit"], STAMP_UNITS)
        if "stamp" in self._given:
            found["stamp"] = self._file.text("stamp", self._given["stamp"])
        if kind is Kind.TOPIC and found["stamp"] != ARRIVAL:
            check_paths(self._file, self._given.get("stamp", self._entry), found["stamp"])
        for key, default in (("scale", 1.0), ("offset", 0.0), ("stddev", nan), ("full_scale", 1.0)):
            entry = self._given.get(key)
            least = -inf if key in ("scale", "offset") else 0.0
            found[key] = default if entry is None else self._file.number(key, entry, least, 1e12)
        if "scale" in self._given and found["scale"] == 0.0:
            raise self._file.error(self._given["scale"], "'scale' = 0 makes every value the same")
        if (unit == PERCENT) != ("full_scale" in self._given):
            at = self._given.get("full_scale", self._entry)
            si_unit = next(iter(UNITS[self._quantity.dimension]))
            raise self._file.error(at, f"'full_scale' belongs to the unit %: 100 % in {si_unit}")
        counter = self._given.get("counter")
        if (unit == EDGES) != (counter is not None):
            at = self._entry if counter is None else counter
            raise self._file.error(at, "'counter' belongs to the unit edges: the number at which it wraps, as 65536")
        found["counter"] = nan if counter is None else self._file.number("counter", counter, 2.0, 2.0**64)
        if "stddev" in self._given and not self._quantity.has_stddev:
            raise self._file.error(self._given["stddev"], f"the message of '{self._quantity.name}' carries no stddev")
        latency = self._given.get("latency")
        seconds = 0.0 if latency is None else self._file.number("latency", latency, 0.0, _LONGEST_LATENCY)
        found["latency"] = round(seconds * NANOSECONDS)
        radius = self._given.get("radius")
        found["radius"] = nan if radius is None else self._file.number("radius", radius, *_RADII)
        found["sign"] = self._sign()
        found["mean"] = self._combine() == "mean"
        found["invalid"] = self._invalid()
        return found

    def _unit(self) -> str:
        if "unit" not in self._given:
            return ""
        entry = self._given["unit"]
        text = self._file.text("unit", entry)
        unit = unit_named(text, self._quantity.dimension)
        if unit is None:
            known = ", ".join(UNITS[self._quantity.dimension])
            raise self._file.error(entry, f"'{text}' is no unit of '{self._quantity.name}': known are {known}")
        return unit

    def _sign(self) -> int:
        entry = self._given.get("sign")
        if entry is None:
            return 1
        if isinstance(entry.value, bool) or entry.value not in (1, -1):
            raise self._file.error(entry, f"'sign' = {plain(entry.value)!r} must be 1 or -1")
        return int(entry.value)

    def _combine(self) -> str:
        entry = self._given.get("combine")
        if entry is not None and entry.value not in ("sum", "mean"):
            raise self._file.error(entry, f"'combine' = {plain(entry.value)!r} must be sum or mean")
        return "" if entry is None else str(entry.value)

    def _invalid(self) -> tuple[float, ...]:
        entry = self._given.get("invalid")
        if entry is None:
            return ()
        values = entry.value if isinstance(entry.value, list) else [entry.value]
        if not all(isinstance(each, (int, float)) and not isinstance(each, bool) for each in values):
            raise self._file.error(entry, f"'invalid' = {plain(entry.value)!r} must be a number or a list of numbers")
        return tuple(float(each) for each in values)


def check_paths(file: MapEntries, entry: Entry, *paths: str) -> None:
    """Refuse a path that names no field of any message.

    Raises:
        ParameterError: one is none; the text names file and line.
    """
    for path in paths:
        try:
            FieldPath(path)
        except ValueError as error:
            raise file.error(entry, str(error)) from error


class SignalEntry:
    """Reads the entry of one quantity."""

    def __init__(self, file: MapEntries, quantity: Quantity, entry: Entry, vehicle: Vehicle) -> None:
        """Refuse unknown keys.

        Raises:
            ParameterError: a key is unknown, or `from` is missing.
        """
        self._file = file
        self._quantity = quantity
        self._entry = entry
        self._vehicle = vehicle
        self._given = file.mapping(quantity.name, entry)
        self._without: set[str] = set()
        """Wheels without this signal, by the map."""
        file.known(self._given, _KEYS)
        if "from" not in self._given:
            raise file.error(entry, f"'{quantity.name}' has no 'from': one of {_ORIGINS}")

    def signals(self, stamp: str, stamp_unit: str) -> list[Signal]:
        """Return the signals, one a wheel where the quantity is that of a wheel.

        Args:
            stamp: stamp of the map, for an entry without one.
            stamp_unit: its unit, likewise.

        Raises:
            ParameterError: a value is not valid; the text names file and line.
        """
        kind, topics, name = self._origin()
        fields = self._fields(kind, name)
        flags = self._flags(kind)
        numbers = EntryNumbers(self._file, self._quantity, self._entry).values(kind, stamp, stamp_unit)
        wheels = [wheel for wheel in self._targets() if wheel in fields and wheel in topics]
        missing = [wheel for wheel in self._vehicle.wheel_names if wheel not in (*wheels, *self._without)]
        if self._quantity.name == "wheel_speed" and (missing or not wheels):
            raise self._file.error(
                self._entry,
                f"'wheel_speed' lacks {', '.join(missing or self._without)} of the car '{self._vehicle.name}': give "
                "null in 'fields' to a wheel whose speed was not recorded",
            )
        return [
            Signal(
                self._quantity,
                wheel,
                Origin(kind, topics[wheel], self._type() if kind is Kind.TOPIC else ""),
                fields[wheel],
                self._entry.line,
                flag=flags[wheel],
                **numbers,
            )
            for wheel in wheels
        ]

    def _targets(self) -> tuple[str, ...]:
        return self._vehicle.wheel_names if self._quantity.per_wheel else ("",)

    def _origin(self) -> tuple[Kind, Mapping[str, str], str]:
        """Return kind, topic by wheel, and the name of the CAN signal or column that stands beside `from`."""
        entry = self._given["from"]
        none = dict.fromkeys(self._targets(), "")
        if entry.value in ("can", "table"):
            return Kind(entry.value), none, ""
        if not isinstance(entry.value, dict):
            raise self._file.error(entry, f"'from' = {plain(entry.value)!r} must be one of {_ORIGINS}")
        origin = self._file.mapping("from", entry)
        self._file.known(origin, ("topic", "type", "can", "column"))
        if "topic" in origin:
            if set(origin) != {"topic", "type"}:
                raise self._file.error(entry, "'from' needs topic and type: {topic: NAME, type: package/msg/Type}")
            topics = self._of_targets("topic", origin["topic"])
            return Kind.TOPIC, {wheel: names[0] for wheel, names in topics.items()}, ""
        if len(origin) != 1 or "type" in origin:
            raise self._file.error(entry, f"'from' must be one of {_ORIGINS}")
        key, given = next(iter(origin.items()))
        return Kind.CAN if key == "can" else Kind.TABLE, none, self._file.text(key, given)

    def _type(self) -> str:
        entry = self._given["from"].value["type"]
        name = self._file.text("type", entry)
        if not _TYPE.fullmatch(name):
            raise self._file.error(entry, f"'type' = {name!r} is no message type: package/msg/Type")
        return name

    def _fields(self, kind: Kind, name: str) -> dict[str, tuple[str, ...]]:
        """Return fields by wheel."""
        given = [key for key in ("field", "fields") if key in self._given]
        if len(given) + bool(name) != 1:
            what = "twice" if given else "nowhere: add 'field' or 'fields'"
            raise self._file.error(self._entry, f"the field of '{self._quantity.name}' is given {what}")
        entry = Entry(self._entry.line, name) if name else self._given[given[0]]
        found = self._of_targets(given[0] if given else "from", entry)
        if kind is Kind.TOPIC:
            check_paths(self._file, entry, *(field for fields in found.values() for field in fields))
        return found

    def _of_targets(self, key: str, entry: Entry) -> dict[str, tuple[str, ...]]:
        """Return texts by wheel: from a text with {wheel}, a list, or a mapping of wheels and axles."""
        if isinstance(entry.value, dict):
            if not self._quantity.per_wheel:
                raise self._file.error(entry, f"'{self._quantity.name}' is that of the car: give one text")
            return self._of_wheels(key, entry.value)
        texts = self._texts(key, entry)
        if not self._quantity.per_wheel:
            return {"": texts}
        if key != "topic" and not _differs("".join(texts)) and not self._topics_differ():
            wheels = ", ".join(f"{name}: ..." for name in self._vehicle.wheel_names)
            raise self._file.error(
                entry, f"'{self._quantity.name}' is that of each wheel: give {{{wheels}}}, or a text with {_WHEEL}"
            )
        return {wheel.name: tuple(_of_wheel(text, wheel) for text in texts) for wheel in self._vehicle.wheels}

    def _topics_differ(self) -> bool:
        origin = self._given["from"].value
        topic = origin["topic"].value if isinstance(origin, dict) and "topic" in origin else ""
        return isinstance(topic, dict) or _differs(str(topic))

    def _of_wheels(self, key: str, given: Mapping[str, Entry]) -> dict[str, tuple[str, ...]]:
        """Return texts by wheel from a mapping: a wheel's own text goes before its axle's, that before `all`."""
        wheels = {wheel.name: wheel for wheel in self._vehicle.wheels}
        places = dict.fromkeys(place for wheel in wheels.values() for place in _places(wheel))
        self._file.known(given, tuple(dict.fromkeys((*wheels, *places))))
        found: dict[str, tuple[str, ...]] = {}
        for name, wheel in wheels.items():
            chosen = _first_in(given, name, wheel)
            if chosen is not None and chosen.value is None:
                self._without.add(name)
            elif chosen is not None:
                found[name] = self._texts(key, chosen)
        return found

    def _texts(self, key: str, entry: Entry) -> tuple[str, ...]:
        if not isinstance(entry.value, list):
            return (self._file.text(key, entry),)
        if "combine" not in self._given:
            raise self._file.error(entry, f"'{key}' names several: add 'combine', sum or mean")
        if not entry.value or not all(isinstance(each, str) and each for each in entry.value):
            raise self._file.error(entry, f"'{key}' = {entry.value!r} must hold texts")
        return tuple(entry.value)

    def _flags(self, kind: Kind) -> dict[str, Flag | None]:
        """Return the flag of each wheel."""
        if "valid" not in self._given:
            return dict.fromkeys(self._targets())
        entry = self._given["valid"]
        given = self._file.mapping("valid", entry)
        self._file.known(given, ("field", "fields", "is"))
        place = given.get("field", given.get("fields"))
        if "is" not in given or place is None:
            raise self._file.error(entry, "'valid' must be {field: FIELD, is: VALUE}")
        value = given["is"].value
        if not isinstance(value, (bool, int, float, str)):
            raise self._file.error(given["is"], f"'is' = {plain(value)!r} must be a number, a text, true or false")
        single = not isinstance(place.value, dict) and not _differs(str(place.value))
        fields = (
            dict.fromkeys(self._targets(), (self._file.text("valid", place),))
            if single
            else self._of_targets("valid", place)
        )
        if kind is Kind.TOPIC:
            check_paths(self._file, place, *(each for texts in fields.values() for each in texts))
        return {name: Flag(fields[name][0], value) if name in fields else None for name in self._targets()}


def _differs(text: str) -> bool:
    """Whether a text stands for another one at each wheel."""
    return _WHEEL in text or _JOINT in text


def _first_in(given: Mapping[str, Entry], name: str, wheel: Wheel) -> Entry | None:
    return next((given[key] for key in (name, *_places(wheel)) if key in given), None)


def _places(wheel: Wheel) -> tuple[str, ...]:
    """Return the other names of a wheel, the most specific first: front_left, front, all."""
    return f"{wheel.axle}_{wheel.side}", wheel.axle, _ALL


def _of_wheel(text: str, wheel: Wheel) -> str:
    return text.replace(_WHEEL, wheel.name).replace(_JOINT, wheel.joint)
