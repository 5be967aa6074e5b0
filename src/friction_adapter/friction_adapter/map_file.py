"""Signal maps as files.

    vehicle: my_car.yaml                # beside this file, or the name of a shipped one
    stamp: header.stamp                 # or another field or column, or arrival
    signals:
      wheel_speed:
        from: {topic: /wheel_speeds, type: raptor_dbw_msgs/msg/WheelSpeedReport}
        fields: {FL: front_left, FR: front_right, RL: rear_left, RR: rear_right}
        unit: km/h
      brake_pressure: {from: {can: "P_{wheel}"}, unit: bar, latency: 0.01}
      acceleration: {from: {can: LongAcc}, unit: g, sign: -1}
      speed: {from: {topic: /velocity_status, type: autoware_vehicle_msgs/msg/VelocityReport},
              field: longitudinal_velocity, stddev: 0.3}

There are no expressions. A mistake is refused with file and line.
"""

from argparse import ArgumentParser
from collections.abc import Mapping
from pathlib import Path

from friction_adapter.map_entry import MapEntries, SignalEntry
from friction_adapter.signal_map import ARRIVAL, QUANTITIES, CanBus, SignalMap
from friction_adapter.stamp_unit import STAMP_UNITS
from friction_parameters.parameter import ParameterError
from friction_parameters.yaml_file import Entry, read_yaml
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle_file import load_vehicle, shipped_vehicles, vehicle_choices, vehicle_reference

_SHIPPED = Path(__file__).parent / "maps"
_KEYS = ("vehicle", "stamp", "stamp_unit", "stamp_offset", "together", "can", "notes", "signals")
_LARGEST_OFFSET = 1e10
"""Seconds, which is the year 2286."""


def shipped_maps() -> tuple[str, ...]:
    """Names of the maps that come with this package."""
    return tuple(sorted(path.stem for path in _SHIPPED.glob("*.yaml")))


def map_choices() -> str:
    """Say how a map may be given, for help and refusals."""
    return f"a path, or one of those shipped: {', '.join(shipped_maps())}"


def map_path(name: str | Path) -> Path:
    """Return the path of a map.

    Args:
        name: path, or name of a shipped map.

    Raises:
        ParameterError: there is no such map; the text names those shipped.
    """
    path = _SHIPPED / f"{name}.yaml" if str(name) in shipped_maps() else Path(name)
    if not path.is_file():
        raise ParameterError(f"there is no signal map '{name}': give {map_choices()}")
    return path


def map_reference(name: str) -> str:
    """Return a name of a map that is valid in every directory: a shipped name as it is, else the absolute path.

    Raises:
        ParameterError: as map_path.
    """
    path = map_path(name)
    return name if name in shipped_maps() else str(path.absolute())


def load_map(name: str | Path, vehicle: str = "") -> SignalMap:
    """Read a map.

    Args:
        name: path, or name of a shipped map.
        vehicle: vehicle file that holds in place of that of the map; empty for that of the map.

    Raises:
        ParameterError: there is no such map or vehicle, or the map is not valid; one line of text with file and line.
    """
    path = map_path(name)
    top = read_yaml(path, "signal map")
    file = MapEntries(path)
    file.known(top, _KEYS)
    if "signals" not in top:
        raise ParameterError(f"{path}: 'signals' is missing")
    if not vehicle and "vehicle" not in top:
        raise ParameterError(f"{path}: 'vehicle' is missing: the map is for any car, so give one, {vehicle_choices()}")
    reference = vehicle_reference(vehicle) if vehicle else _vehicle_reference(file, top["vehicle"])
    car = load_vehicle(reference)
    stamp = file.text("stamp", top["stamp"]) if "stamp" in top else "header.stamp"
    stamp_unit = file.one_of("stamp_unit", top["stamp_unit"], STAMP_UNITS) if "stamp_unit" in top else ""
    signals = []
    for quantity, entry in file.mapping("signals", top["signals"]).items():
        if quantity not in QUANTITIES:
            raise file.error(entry, f"unknown signal '{quantity}': known are {', '.join(QUANTITIES)}")
        signals += SignalEntry(file, QUANTITIES[quantity], entry, car).signals(stamp, stamp_unit)
    _refuse_alone(file, file.mapping("signals", top["signals"]))
    notes = file.mapping("notes", top["notes"]) if "notes" in top else {}
    return SignalMap(
        path,
        car,
        reference,
        tuple(signals),
        _nanoseconds(file, top, "stamp_offset", 0.0, -_LARGEST_OFFSET, _LARGEST_OFFSET),
        _nanoseconds(file, top, "together", 0.005, 0.0, 1.0),
        _can_bus(file, top, stamp == ARRIVAL),
        {key: str(each.value) for key, each in notes.items()},
    )


def _vehicle_reference(file: MapEntries, entry: Entry) -> str:
    """Return the name of a shipped vehicle file as it is, else the path, which is seen from the map."""
    name = file.text("vehicle", entry)
    if name in shipped_vehicles():
        return name
    beside = file.path.absolute().parent / name
    if not beside.is_file():
        shipped = ", ".join(shipped_vehicles())
        raise file.error(entry, f"there is no vehicle file {beside}; those shipped are {shipped}")
    return str(beside)


def _refuse_alone(file: MapEntries, given: Mapping[str, Entry]) -> None:
    """Refuse a map of no signal, and a signal whose message has no meaning without another one."""
    if not given:
        raise ParameterError(f"{file.path}: 'signals' names none: known are {', '.join(QUANTITIES)}")
    for name, entry in given.items():
        needed = QUANTITIES[name].needs
        if needed and needed not in given:
            raise file.error(entry, f"'{name}' goes into the message of '{needed}', which is not mapped: leave it out")


def _can_bus(file: MapEntries, top: Mapping[str, Entry], by_arrival: bool) -> CanBus:
    if "can" not in top:
        return CanBus()
    given = file.mapping("can", top["can"])
    file.known(given, ("dbc", "topic", "bus"))
    texts = {key: file.text(key, entry) for key, entry in given.items() if key != "bus"}
    bus = str(given["bus"].value) if "bus" in given else ""
    dbc = file.path.absolute().parent / texts["dbc"] if "dbc" in texts else None
    if dbc is not None and not dbc.is_file():
        raise file.error(given["dbc"], f"there is no DBC file {dbc}")
    return CanBus(dbc, texts.get("topic", ""), bus, by_arrival)


def _nanoseconds(
    file: MapEntries, top: Mapping[str, Entry], key: str, default: float, least: float, most: float
) -> int:
    seconds = file.number(key, top[key], least, most) if key in top else default
    return round(seconds * NANOSECONDS)


def add_map_argument(parser: ArgumentParser) -> None:
    """Add `--map`, empty by default."""
    text = f"signal map of what is no topic of this graph: {map_choices()}"
    parser.add_argument("--map", default="", metavar="NAME|FILE", help=text)
