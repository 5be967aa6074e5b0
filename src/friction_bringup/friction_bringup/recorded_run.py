"""The values of a recorded run, topic by topic, as arrays over time."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from operator import attrgetter
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rclpy.serialization import deserialize_message

from friction_bags.bag_io.bag_format import BagError
from friction_bags.bag_io.bag_reader import BagReader
from friction_bringup.braking_metrics import CrossingEvent, hardest_braking
from friction_runtime.message_type import message_class
from friction_runtime.stamps import to_nanoseconds
from vehicle_models.nanoseconds import NANOSECONDS

Array = NDArray[np.float64]

_SAMPLES = "/wheel_states"
_TYRES = "friction_msgs/msg/TyreSignals"
"""Type of the topics from which something can be shown without wheel_states."""

_COLUMNS: Mapping[str, tuple[str, ...]] = {
    "friction_msgs/msg/WheelSlip": ("slip", "slip_rate", "vehicle_speed", "wheel_speed", "valid"),
    "friction_msgs/msg/FrictionSlope": (
        *("sign", "h", "indicator", "valid", "crossings", "crossing_sign", "slip_at_crossing", "delay"),
        *("crossing_stamp.sec", "crossing_stamp.nanosec"),
    ),
    "friction_msgs/msg/SlopeVote": ("indicator",),
    "friction_msgs/msg/FrictionCurve": ("lambda_max", "mu_max", "lambda_max_stddev", "mu_max_stddev", "mu", "valid"),
    "friction_msgs/msg/SupervisorState": (
        *("state", "demand_torque", "command", "release", "cap", "refused_releases", "caps", "valid"),
        *("law", "slip_set_point", "torque_set_point"),
    ),
    "friction_msgs/msg/ContactPatch": ("valid",),
    "friction_msgs/msg/TyreForce": ("fx", "fz", "valid"),
    "friction_msgs/msg/BrakeCommand": ("command",),
    "friction_msgs/msg/BrakeDemand": ("pressure",),
    "sensor_msgs/msg/FluidPressure": ("fluid_pressure",),
    "geometry_msgs/msg/TwistWithCovarianceStamped": ("twist.twist.linear.x",),
}


@dataclass
class Series:
    """The messages of one topic: the time of their stamps and some of their fields."""

    time: Array
    """Time since the start of the run [s]."""
    columns: Mapping[str, Array]
    reasons: Counter[str] = field(default_factory=Counter)
    """How often each reason was given where the message was not valid."""

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
    """Series by topic, without the namespace's leading slash."""
    samples: Array
    """Time [s] of each message of wheel_states."""

    def get(self, topic: str) -> Series | None:
        """Return the series of a topic, None where the bag has no message of it."""
        return self.series.get(topic)

    def hardest_braking(self) -> tuple[float, float] | None:
        """Return begin and end [s] of the hardest braking by the estimated speed; None where there is none."""
        slip = self.get(f"{self.wheels[0]}/slip")
        return None if slip is None else hardest_braking(slip.time, slip["vehicle_speed"])

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


def read_run(bag: Path, wheels: Sequence[str]) -> RecordedRun:
    """Read a bag of the graph.

    Args:
        bag: directory of the bag.
        wheels: names of the wheels of the car.

    Raises:
        BagError: the bag cannot be read, or holds neither wheel_states nor tyre signals.
    """
    rows: dict[str, list[tuple[int, list[float]]]] = {}
    types: dict[str, str] = {}
    reasons: dict[str, Counter[str]] = {}
    samples: list[int] = []
    with BagReader(bag) as reader:
        require_samples(reader)
        wanted = [topic for topic in reader.counts if topic.type in _COLUMNS or topic.name == _SAMPLES]
        getters = {t: [attrgetter(column) for column in _COLUMNS.get(t.type, ())] for t in wanted}
        for topic, _, data in reader.messages(wanted):
            message = deserialize_message(data, message_class(topic.type))
            stamp = to_nanoseconds(message.header.stamp)
            if topic.name == _SAMPLES:
                samples.append(stamp)
                continue
            name = topic.name.lstrip("/")
            types[name] = topic.type
            rows.setdefault(name, []).append((stamp, [float(get(message)) for get in getters[topic]]))
            if not getattr(message, "valid", True):
                reasons.setdefault(name, Counter())[message.reason_text] += 1
    start = samples[0] if samples else min((stamp for values in rows.values() for stamp, _ in values), default=0)
    series = {
        name: _series(values, start, _COLUMNS[types[name]], reasons.get(name, Counter()))
        for name, values in rows.items()
    }
    return RecordedRun(tuple(wheels), start, series, _seconds(samples, start))


def require_samples(reader: BagReader) -> None:
    """Refuse a bag from which nothing can be shown.

    Raises:
        BagError: the bag holds neither wheel_states nor tyre signals.
    """
    if not has_wheel_states(reader) and not any(t.type == _TYRES and count for t, count in reader.counts.items()):
        raise BagError(f"{reader.bag} holds no {_SAMPLES} and no tyre signals: nothing can be shown of it")


def has_wheel_states(reader: BagReader) -> bool:
    """Whether a bag has messages of wheel_states."""
    return any(topic.name == _SAMPLES and count for topic, count in reader.counts.items())


def _series(
    values: list[tuple[int, list[float]]], start: int, columns: tuple[str, ...], reasons: Counter[str]
) -> Series:
    values.sort(key=lambda row: row[0])
    table = np.array([row for _, row in values], dtype=np.float64)
    return Series(
        _seconds([stamp for stamp, _ in values], start),
        {column: table[:, i] for i, column in enumerate(columns)},
        reasons,
    )


def _seconds(stamps: list[int], start: int) -> Array:
    return np.array([(stamp - start) / NANOSECONDS for stamp in stamps])
