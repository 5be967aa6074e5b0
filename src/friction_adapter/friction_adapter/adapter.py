"""Signals of a map as values of this graph's messages: SI units, one instant each. No middleware."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import nan
from typing import Any

from friction_adapter.sampling import EdgeCounters, SampleGrouping, Values
from friction_adapter.signal_map import ARRIVAL, BRAKE_PRESSURE, QUANTITIES, WHEEL_STATES, Kind, Signal, SignalMap
from friction_adapter.sources import PAGE, TABLE, Found, Read, Sources
from friction_adapter.stamp_unit import nanoseconds_of, unit_by_pace
from friction_adapter.unit_table import UNITS, Conversion, conversion, is_rim_speed, unit_named
from friction_parameters.parameter import ParameterError
from vehicle_models.nanoseconds import NANOSECONDS

_LATEST = (1 << 31) * NANOSECONDS
"""Later than any stamp that a message can hold [ns]: its seconds have 31 bits and a sign."""
UNREADABLE = (LookupError, ValueError, TypeError, AttributeError, OverflowError)
"""What a message or row without the value raises."""


@dataclass(frozen=True)
class Target:
    """A message that is made."""

    topic: str
    """Relative topic."""
    message: str
    """Topic without the wheel."""
    wheel: str
    """Name of the wheel; empty for a message of the car."""
    parts: tuple[str, ...]
    """Quantity of each value, or wheel of each speed in wheel_states."""
    required: tuple[int, ...]
    """Places of which one must hold a number, else nothing is sent."""


@dataclass(frozen=True)
class Output:
    """Values for one message."""

    target: int
    """Its number."""
    stamp: int
    """[ns]."""
    values: Sequence[float]
    """By part of the target, in SI units; NaN where there is none."""


@dataclass
class _Take:
    """What one source gives to one target."""

    target: int
    stamp: Callable[[Any, int], int]
    reads: list[tuple[int, Callable[[Any], float]]]
    """Place and reader of each value."""
    counters: EdgeCounters | None = None
    """What makes speeds of the values, where they are counters."""


class Adapter:
    """Takes records of the sources, returns values of messages."""

    def __init__(self, signal_map: SignalMap, sources: Sources) -> None:
        """Find every signal.

        Raises:
            ParameterError: one is not there, or its unit contradicts the DBC file; the text names file, line and what
                there is.
        """
        self._map = signal_map
        self._sources = sources
        self.targets = _targets(signal_map)
        self.stddevs: list[dict[str, float]] = [{} for _ in self.targets]
        """Standard deviation by part of each target [SI unit], where the map states it."""
        self._groupings: list[SampleGrouping] = []
        self._takes: dict[str, list[_Take]] = {}
        for number, target in enumerate(self.targets):
            self._bind(number, target)
        self._titles = frozenset(signal.title for signal in signal_map.signals)
        self.silent = set(self._titles)
        """Signals that have not had a value yet."""
        self.unreadable: dict[str, int] = {}
        """Values that a record did not hold, by signal."""
        self.refused = 0
        """Messages that were not made, as their stamp is none that a message can hold."""
        self._firsts: dict[str, tuple[int, int]] = {}
        """First stamp and arrival of each source whose stamps are numbers [ns]."""
        self._units: dict[str, str] = {}
        """Unit by which its stamps run as fast as they arrive."""

    @property
    def sources(self) -> tuple[str, ...]:
        """Names of the sources that are needed."""
        return tuple(self._takes)

    @property
    def incomplete(self) -> int:
        """Instants that ended without one of their sources."""
        return sum(each.incomplete for each in self._groupings)

    @property
    def mistaken_units(self) -> dict[str, str]:
        """Unit that the stamps of a source seem to be in, where it is not that in which they are read."""
        return {source: unit for source, unit in self._units.items() if unit not in ("", "s")}

    def take(self, source: str, record: Any, arrival: int) -> list[Output]:
        """Take a message, frame or row.

        Args:
            source: its source.
            record: the message, or values by name.
            arrival: when it arrived or was recorded [ns].

        Returns:
            What it completes, in the order of the targets. A source that is not needed gives nothing.
        """
        made: list[Output] = []
        for take in self._takes.get(source, ()):
            try:
                stamp = take.stamp(record, arrival)
            except UNREADABLE:
                stamp = -1
            if not 0 <= stamp < _LATEST:
                self.refused += 1
                continue
            values: Values = [(place, read(record)) for place, read in take.reads]
            if take.counters is not None:
                counted = take.counters.speeds(stamp, values)
                if counted is None:
                    continue
                stamp, values = counted
            for at, found in self._groupings[take.target].add(source, stamp, values):
                if any(found[place] == found[place] for place in self.targets[take.target].required):
                    made.append(Output(take.target, at, found))
        return made

    def reset(self) -> None:
        """Start again, as after construction."""
        self.silent = set(self._titles)
        self.unreadable.clear()
        self.refused = 0
        self._firsts.clear()
        self._units.clear()
        for grouping in self._groupings:
            grouping.reset()
        for takes in self._takes.values():
            for take in takes:
                if take.counters is not None:
                    take.counters.reset()

    def _bind(self, number: int, target: Target) -> None:
        takes: dict[str, _Take] = {}
        stamped: dict[str, Signal] = {}
        ranges: dict[str, dict[int, float]] = {}
        pitches: dict[str, dict[int, float]] = {}
        for signal in self._map.signals:
            if not _belongs(signal, target):
                continue
            part = signal.wheel if target.message == WHEEL_STATES else signal.quantity.name
            found = [self._found(signal, field) for field in signal.fields]
            source = self._source(signal, found)
            convert = self._conversion(signal, found)
            if signal.stddev == signal.stddev:
                self.stddevs[number][part] = convert.of_difference(signal.stddev)
            first = stamped.setdefault(source, signal)
            if (first.stamp, first.latency) != (signal.stamp, signal.latency):
                raise self._error(signal, f"it shares a message with {first.title}, and so its stamp and latency")
            if source not in takes:
                takes[source] = _Take(number, self._stamp_reader(signal, source), [])
            read = self._reader(signal, [each.read for each in found], convert)
            place = target.parts.index(part)
            takes[source].reads.append((place, read))
            if signal.counter == signal.counter:
                ranges.setdefault(source, {})[place] = convert.of_difference(signal.counter)
                pitches.setdefault(source, {})[place] = convert.of_difference(1.0)
        for source, of_source in ranges.items():
            takes[source].counters = EdgeCounters(of_source, pitches[source])
        self._groupings.append(SampleGrouping(takes, len(target.parts), self._map.together))
        for source, take in takes.items():
            self._takes.setdefault(source, []).append(take)

    def _source(self, signal: Signal, found: Sequence[Found]) -> str:
        """Return the one source of a signal and its flag."""
        flags = [] if signal.flag is None else [self._found(signal, signal.flag.field)]
        every = {each.source for each in (*found, *flags)}
        # What is in all pages of a frame is in each of them.
        names = sorted(name for name in every if not any(other.startswith(f"{name}{PAGE}") for other in every))
        if len(names) > 1:
            raise self._error(signal, f"its fields come from {', '.join(names)}: they must come together")
        return names[0]

    def _conversion(self, signal: Signal, found: Sequence[Found]) -> Conversion:
        dimension, unit = signal.quantity.dimension, self._unit(signal, found)
        if signal.radius == signal.radius and not is_rim_speed(dimension, unit):
            raise self._error(signal, f"'radius' belongs to speeds of a rim, such as km/h, not to {unit}")
        return conversion(
            dimension,
            unit,
            self._map.vehicle.wheel(signal.wheel) if signal.wheel else None,
            scale=signal.scale / len(signal.fields) if signal.mean else signal.scale,
            offset=signal.offset,
            sign=signal.sign,
            full_scale=signal.full_scale,
            radius=signal.radius,
        )

    def _reader(self, signal: Signal, reads: Sequence[Read], conversion: Conversion) -> Callable[[Any], float]:
        """Return what reads a value in SI units, NaN where there is none."""
        convert = conversion.function()
        raw = _raw(reads, frozenset(signal.invalid))
        flag = signal.flag
        is_valid = None if flag is None else _test(self._found(signal, flag.field).read, flag.is_value)
        title = signal.title

        def read(record: Any) -> float:
            try:
                value = convert(raw(record)) if is_valid is None or is_valid(record) else nan
                if self.silent and value == value:
                    self.silent.discard(title)
                return value
            except UNREADABLE:
                self.unreadable[title] = self.unreadable.get(title, 0) + 1
                return nan

        return read

    def _found(self, signal: Signal, field: str) -> Found:
        try:
            return self._sources.find(signal.origin, field)
        except ValueError as error:
            raise self._error(signal, str(error)) from error

    def _unit(self, signal: Signal, found: Sequence[Found]) -> str:
        """Return the unit of a signal: that of the map, else that of the DBC file, else the SI unit."""
        dimension = signal.quantity.dimension
        for each in found:
            stated = unit_named(each.unit, dimension)
            if not each.unit or (signal.unit and signal.unit == stated):
                continue
            if signal.unit and stated:
                raise self._error(signal, f"its unit is {signal.unit} here, and {stated} where it comes from")
            if stated:
                return stated
            if not signal.unit:
                known = ", ".join(UNITS[dimension])
                raise self._error(signal, f"it comes in '{each.unit}': give its unit, one of {known}")
        return signal.unit or next(iter(UNITS[dimension]))

    def _stamp_reader(self, signal: Signal, source: str) -> Callable[[Any, int], int]:
        shift = self._map.stamp_offset - signal.latency
        if signal.stamp == ARRIVAL or signal.origin.kind is Kind.CAN:
            return lambda _, arrival: arrival + shift
        if source == TABLE:
            read = self._found(signal, signal.stamp).read
            return lambda record, _: nanoseconds_of(read(record), "s") + shift  # the table brings seconds
        read = self._stamp_field(signal)
        return self._paced(source, signal, lambda record: _nanoseconds(read(record), signal.stamp_unit) + shift)

    def _paced(self, source: str, signal: Signal, stamp_of: Callable[[Any], int]) -> Callable[[Any, int], int]:
        """Return what reads a stamp, and compares how fast stamps and arrivals run where no unit is given."""
        if signal.stamp_unit:
            return lambda record, _: stamp_of(record)

        def read(record: Any, arrival: int) -> int:
            stamp = stamp_of(record)
            if source not in self._units:
                first = self._firsts.setdefault(source, (stamp, arrival))
                if arrival - first[1] >= NANOSECONDS:
                    pace = (stamp - first[0]) / NANOSECONDS
                    self._units[source] = unit_by_pace(pace, (arrival - first[1]) / NANOSECONDS)
            return stamp

        return read

    def _stamp_field(self, signal: Signal) -> Read:
        """Return what reads a stamp, a message of sec and nanosec or a number of seconds."""
        with_seconds = f"{signal.stamp}.sec"
        try:
            self._sources.find(signal.origin, with_seconds)
        except ValueError:
            return self._found(signal, signal.stamp).read
        read = self._sources.find(signal.origin, with_seconds).read
        rest = self._sources.find(signal.origin, f"{signal.stamp}.nanosec").read
        return lambda record: (read(record), rest(record))

    def _error(self, signal: Signal, text: str) -> ParameterError:
        return ParameterError(f"{self._map.path}: line {signal.line}: {signal.title}: {text}")


def _targets(signal_map: SignalMap) -> tuple[Target, ...]:
    """Return the messages that a map can make, in the order in which those of one instant are sent."""
    targets = []
    for message in dict.fromkeys(each.message for each in QUANTITIES.values()):
        signals = [each for each in signal_map.signals if each.quantity.message == message]
        if message == WHEEL_STATES:
            parts = tuple(signal.wheel for signal in signals)
            if signals:
                targets.append(Target(message, message, "", parts, tuple(range(len(parts)))))
        elif message == BRAKE_PRESSURE:
            targets += [Target(f"{each.wheel}/{message}", message, each.wheel, (message,), (0,)) for each in signals]
        elif signals:
            parts = tuple(name for name, each in QUANTITIES.items() if each.message == message)
            targets.append(Target(message, message, "", parts, (0,)))
    return tuple(targets)


def _belongs(signal: Signal, target: Target) -> bool:
    return signal.quantity.message == target.message and (not target.wheel or signal.wheel == target.wheel)


def _raw(reads: Sequence[Read], invalid: frozenset[float]) -> Callable[[Any], float]:
    """Return what reads the raw value, or the sum of several; NaN where one of them is invalid."""
    if len(reads) == 1 and not invalid:
        return reads[0]

    def total(record: Any) -> float:
        values = [float(read(record)) for read in reads]
        return nan if invalid.intersection(values) else sum(values)

    return total


def _test(read: Read, value: float | str) -> Callable[[Any], bool]:
    return lambda record: bool(read(record) == value)


def _nanoseconds(stamp: Any, unit: str) -> int:
    """Return a stamp in nanoseconds: seconds and their rest, or a number in a unit."""
    if isinstance(stamp, tuple):
        seconds, rest = stamp
        return int(seconds) * NANOSECONDS + int(rest)
    return nanoseconds_of(stamp if isinstance(stamp, int) else float(stamp), unit)
