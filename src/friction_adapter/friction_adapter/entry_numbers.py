"""Interpretation of the numbers of an entry of `signals`: unit, scale, sign, age, invalid values."""

from math import inf, nan
from typing import Any

from friction_adapter.field_path import FieldPath
from friction_adapter.map_entries import MapEntries
from friction_adapter.quantities import Quantity
from friction_adapter.signal_map import ARRIVAL, Kind
from friction_adapter.unit_table import EDGES, PERCENT, UNITS, unit_named
from friction_parameters.yaml_file import Entry, plain
from vehicle_models.nanoseconds import NANOSECONDS

NUMBER_KEYS = (
    *("combine", "unit", "scale", "offset", "sign", "full_scale", "radius", "counter", "latency", "stddev"),
    *("invalid", "stamp"),
)
_LONGEST_LATENCY = 1.0
_RADII = 0.05, 2.0


class EntryNumbers:
    """Reads these keys of the entry of one quantity."""

    def __init__(self, file: MapEntries, quantity: Quantity, entry: Entry) -> None:
        """Take the entry, a mapping of known keys."""
        self._file = file
        self._quantity = quantity
        self._entry = entry
        self._given = file.mapping(quantity.name, entry)

    def values(self, kind: Kind, stamp: str) -> dict[str, Any]:
        """Return what holds for all wheels, by the name of the field in Signal.

        Args:
            kind: where the signal is found.
            stamp: stamp of the map, for an entry without one.

        Raises:
            ParameterError: a value is not valid; the text names file and line.
        """
        unit = self._unit()
        found: dict[str, Any] = {"unit": unit, "stamp": stamp}
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
