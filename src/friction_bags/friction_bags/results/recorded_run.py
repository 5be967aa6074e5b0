"""The values of a recorded run, topic by topic, as arrays over time."""

from __future__ import annotations

from array import array
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_bags.bag_io.bag_format import BagError, Topic
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.cdr import decode
from friction_bags.results.places import Places, places_of
from friction_runtime.installed import message_class
from friction_runtime.messages import to_nanoseconds
from friction_runtime.reports import report_kind
from vehicle_models.nanoseconds import NANOSECONDS

Array = NDArray[np.float64]

_SAMPLES = "wheel_states"
_SAMPLES_TYPE = "sensor_msgs/msg/JointState"
_TYRES = "friction_msgs/msg/TyreSignals"
"""Type of the topics from which something can be shown without wheel_states."""
VEHICLE = "vehicle"
"""Stands for the name of a wheel in the topics of what speaks of the whole car."""
WHY = "why"
"""Column of what has a validity: 0 where it is valid, else the number of the reason, counted from 1."""
_MOST_REASONS = 100
"""Reasons of one topic that are distinguished."""
_OTHERS = "other reasons"
_UNSET = 86400 * NANOSECONDS
"""Stamps of zero among such that are larger than this [ns] were never set."""
_PROGRESS_EVERY = 5000

_VALID = "validity.valid"

Columns = Mapping[str, tuple[str, ...]]
"""Fields that are read, by the type of the message."""
COLUMNS: Columns = {
    "friction_msgs/msg/WheelSlip": ("slip", "slip_rate", "vehicle_speed", "wheel_speed", _VALID),
    "friction_msgs/msg/FrictionSlope": (
        *("sign", "h", "indicator", _VALID, "crossings", "crossing_sign", "slip_at_crossing", "delay"),
        *("crossing_stamp.sec", "crossing_stamp.nanosec"),
    ),
    "friction_msgs/msg/SlopeVote": ("indicator",),
    "friction_msgs/msg/FrictionCurve": (
        *("theta_1", "theta_2", "theta_3", "lambda_max", "mu_max", "lambda_max_stddev", "mu_max_stddev"),
        *("slip", "mu", "probability_beyond_peak", _VALID),
    ),
    "friction_msgs/msg/SupervisorState": (
        *("state", "demand_torque", "command", "intervention", "release", "limit", "refused_releases", _VALID),
        *("law", "slip_set_point"),
    ),
    "friction_msgs/msg/SupervisorDebug": ("torque_set_point",),
    "friction_msgs/msg/Grip": (
        *(f"{part}.{name}" for part in ("vehicle", "front", "rear") for name in ("mu_x", "mu_used", "mu_used_stddev")),
        *("distance", "mu_proven", "mu_lower", "mu_upper", "evidence", _VALID),
    ),
    "friction_msgs/msg/WheelGrip": ("used.mu_x", "used.mu_used", "used.mu_used_stddev", "mu_proven", _VALID),
    "friction_msgs/msg/VehicleFit": ("brakings", _VALID),
    "friction_msgs/msg/ContactPatch": ("length", "shift", _VALID),
    "friction_msgs/msg/TyreForce": ("fx", "fz", "fx_stddev", "fz_stddev", _VALID),
    "friction_msgs/msg/BrakeCommand": ("command",),
    "friction_msgs/msg/BrakeDemand": ("pressure",),
    "sensor_msgs/msg/FluidPressure": ("fluid_pressure",),
    "sensor_msgs/msg/NavSatFix": ("latitude", "longitude", "status.status"),
    "geometry_msgs/msg/TwistWithCovarianceStamped": ("twist.twist.linear.x",),
}


@dataclass(frozen=True)
class CrossingEvent:
    """A change of the slope's sign, estimated or true."""

    time: float
    """When an estimated crossing was known, the stamp of the first message with it, or when a true one was [s]."""
    sign: int
    """Sign after the crossing: -1 the peak was passed, +1 the stable side was regained."""
    slip: float
    """Slip at the crossing [-], compensated for delay: an estimate of lambda_max."""


@dataclass
class Series:
    """The messages of one topic: the time of their stamps and some of their fields."""

    time: Array
    """Time since the start of the run [s]."""
    columns: Mapping[str, Array]
    reasons: Counter[str] = field(default_factory=Counter)
    """How often each reason was given where a message was not valid: in the order of WHY; … for numbers that vary."""

    def __getitem__(self, column: str) -> Array:
        """Return a field over time."""
        return self.columns[column]


@dataclass
class RecordedRun:
    """A run, read from a bag."""

    wheels: tuple[str, ...]
    """Names of the wheels of the car."""
    start: int
    """First stamp of wheel_states, or of anything where there is none [ns]."""
    series: Mapping[str, Series]
    """Series by topic, without the namespace."""
    samples: Array
    """Time [s] of each message of wheel_states."""
    notes: Mapping[str, str] = field(default_factory=dict)
    """Notes of the bag."""
    problems: tuple[str, ...] = ()
    """What could not be read."""
    not_read: tuple[str, ...] = ()
    """Topics of the bag that are not among the series; those without a message are marked."""

    def get(self, topic: str) -> Series | None:
        """Return the series of a topic, None where the bag has no message of it."""
        return self.series.get(topic)

    def places(self) -> Places:
        """Return the places of the drive: of the receiver that has most fixes."""
        receivers = [each for each in self.series.values() if {"latitude", "longitude"} <= each.columns.keys()]
        most = max(receivers, key=lambda each: each.time.size, default=None)
        if most is None:
            return Places(np.empty(0, np.int64), np.empty(0), np.empty(0))
        stamps = self.start + np.round(most.time * NANOSECONDS).astype(np.int64)
        return places_of(stamps, most["latitude"], most["longitude"], most["status.status"])

    def crossings(self, topic: str) -> list[CrossingEvent]:
        """Return the slope crossings of a friction_slope topic; times as in the truth, or when first known."""
        series = self.get(topic)
        if series is None:
            return []
        seconds, nanoseconds = series["crossing_stamp.sec"], series["crossing_stamp.nanosec"]
        rows = np.flatnonzero(np.diff(series["crossings"], prepend=0.0) > 0.0)
        compensated = (seconds - self.start // NANOSECONDS) + (nanoseconds - self.start % NANOSECONDS) / NANOSECONDS
        time = compensated if topic.startswith("truth/") else series.time
        return [
            CrossingEvent(float(time[row]), int(series["crossing_sign"][row]), float(series["slip_at_crossing"][row]))
            for row in rows
        ]


class _Rows:
    """The messages of one topic as they come."""

    def __init__(self, topic: Topic, columns: Columns) -> None:
        self._columns = columns.get(topic.type, ())
        self._kind = message_class(topic.type)
        self._get = [attrgetter(column) for column in self._columns]
        self._judged = _VALID in self._columns
        self._stamps = array("q")
        self._values = array("d")
        self._why = array("d")
        self._texts: dict[str, str] = {}
        self._numbers: dict[str, float] = {}
        self._reasons: Counter[str] = Counter()
        self._varying: set[str] = set()
        self._without_unset = False
        self.refused = 0
        """Messages that could not be decoded."""

    def __len__(self) -> int:
        return len(self._stamps)

    def take(self, data: bytes) -> None:
        try:
            message: Any = decode(data, self._kind)
        except ValueError:
            self.refused += 1
            return
        self._stamps.append(to_nanoseconds(message.header.stamp))
        self._values.extend([float(get(message)) for get in self._get])
        if self._judged:
            self._why.append(0.0 if message.validity.valid else self._number(message.validity.text))

    @property
    def stamps(self) -> NDArray[np.int64]:
        """Stamps [ns] in the order of recording, without those that are ignored."""
        stamps = np.array(self._stamps, dtype=np.int64)
        return stamps[self._kept(stamps)]

    @property
    def unset(self) -> int:
        """Messages that are ignored because their stamp was never set."""
        return len(self._stamps) - self.stamps.size

    def leave_unset_out(self) -> None:
        """Leave messages with a stamp of zero out."""
        self._without_unset = True

    def series(self, start: int) -> Series:
        """Return the rows in the order of their stamps."""
        stamps = np.array(self._stamps, dtype=np.int64)
        order = np.flatnonzero(self._kept(stamps))
        order = order[np.argsort(stamps[order], kind="stable")]
        table = np.array(self._values).reshape(stamps.size, len(self._columns))[order]
        columns = {column.removeprefix("validity."): table[:, i] for i, column in enumerate(self._columns)}
        if self._judged:
            columns[WHY] = np.array(self._why)[order]
        reasons = {self._shown(text): count for text, count in self._reasons.items()}
        return Series((stamps[order] - start) / NANOSECONDS, columns, Counter(reasons))

    def _shown(self, text: str) -> str:
        """Return a reason, without the numbers that were not the same in all messages."""
        return report_kind(text).replace("#", "…") if text in self._varying else text

    def _kept(self, stamps: NDArray[np.int64]) -> NDArray[np.bool_]:
        return (stamps != 0) | (not self._without_unset)

    def _number(self, text: str) -> float:
        kind = report_kind(text)
        if kind not in self._texts:
            self._texts[kind] = text if len(self._texts) < _MOST_REASONS else _OTHERS
        reason = self._texts[kind]
        if reason not in (text, _OTHERS):
            self._varying.add(reason)
        self._reasons[reason] += 1
        return self._numbers.setdefault(reason, 1.0 + len(self._numbers))


def read_run(
    bag: Path,
    wheels: Sequence[str] | None = None,
    prefix: str = "/",
    progress: Callable[[float], None] = lambda _: None,
    columns: Columns = COLUMNS,
) -> RecordedRun:
    """Read a bag of the graph.

    Args:
        bag: directory of the bag.
        wheels: names of the wheels of the car; None for those that the topics name.
        prefix: namespace of the topics, with a slash at either end.
        progress: called with the share that has been read, 0 to 1.
        columns: what is read of it, by default all that can be shown.

    Raises:
        BagError: the bag cannot be read, or holds no message that can be shown.
    """
    with BagReader(bag) as reader:
        named = {topic: topic.name.removeprefix(prefix) for topic in reader.counts if topic.name.startswith(prefix)}
        rows = _rows_of(reader, named, progress, columns)
        notes, problems = reader.custom_data, list(reader.problems)
        others = [_named_other(topic, topic in rows) for topic in reader.counts if topic not in rows or not rows[topic]]
    if max((int(each.stamps.max(initial=0)) for each in rows.values()), default=0) > _UNSET:
        for each in rows.values():
            each.leave_unset_out()
    for topic, each in rows.items():
        problems += [f"{named[topic]}: {each.refused} messages cannot be decoded"] if each.refused else []
        problems += [f"{named[topic]}: {each.unset} messages without a stamp are ignored"] if each.unset else []
    read = {named[topic]: each for topic, each in rows.items() if each.stamps.size}
    if not read:
        raise BagError(f"{bag} holds no message below {prefix} that can be shown")
    start = _start(read)
    if wheels is None:
        wheels = sorted(_wheels_of([topic for topic, each in rows.items() if each], named))
    rows.clear()
    series = {name: read.pop(name).series(start) for name in list(read)}  # frees each: an hour of them is gigabytes
    samples = series.pop(_SAMPLES).time if _SAMPLES in series else np.empty(0)
    return RecordedRun(tuple(wheels), start, series, samples, notes, tuple(problems), tuple(sorted(others)))


def _rows_of(
    reader: BagReader, named: Mapping[Topic, str], progress: Callable[[float], None], columns: Columns
) -> dict[Topic, _Rows]:
    """Read the topics of which something is shown."""
    taken = [topic for topic, name in named.items() if topic.type in columns or _is_samples(topic, name)]
    rows = {topic: _Rows(topic, columns) for topic in taken}
    total = max(reader.message_count, 1)
    for number, (topic, _, data) in enumerate(reader.messages(rows)):
        rows[topic].take(data)
        if number % _PROGRESS_EVERY == 0:
            progress(number / total)
    return rows


def _named_other(topic: Topic, known: bool) -> str:
    return f"{topic.name} (no message)" if known else topic.name


def require_samples(reader: BagReader) -> None:
    """Refuse a bag from which nothing can be shown.

    Raises:
        BagError: the bag holds neither wheel_states nor tyre signals.
    """
    if not has_wheel_states(reader) and not any(t.type == _TYRES and count for t, count in reader.counts.items()):
        raise BagError(f"{reader.bag} holds no /{_SAMPLES} and no tyre signals: nothing can be shown of it")


def has_wheel_states(reader: BagReader) -> bool:
    """Whether a bag has messages of wheel_states."""
    return any(topic.name == f"/{_SAMPLES}" and count for topic, count in reader.counts.items())


def _is_samples(topic: Topic, name: str) -> bool:
    return name == _SAMPLES and topic.type == _SAMPLES_TYPE


def _start(read: Mapping[str, _Rows]) -> int:
    """Return the first stamp of wheel_states, in the order of recording, or the least of all where there is none."""
    if _SAMPLES in read:
        return int(read[_SAMPLES].stamps[0])
    return min(int(rows.stamps.min()) for rows in read.values())


def _wheels_of(topics: Sequence[Topic], named: Mapping[Topic, str]) -> set[str]:
    """Return the wheels that topics name: what stands before the last part of a name."""
    of_wheels = [
        named[topic].removeprefix("truth/")
        for topic in topics
        if topic.type.startswith("friction_msgs/") or named[topic].endswith("/brake_pressure")
    ]
    return {name.rpartition("/")[0] for name in of_wheels} - {"", VEHICLE}
