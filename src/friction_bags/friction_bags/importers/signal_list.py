"""Lists the signals of a log, with unit, rate and range where they are known without a map."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from math import isfinite, nan
from pathlib import Path
from typing import Any, Final

import numpy as np
from rosbags.highlevel import AnyReader
from sensor_msgs.msg import JointState

from friction_adapter.sources import CanFrames, Fields
from friction_adapter.stamp_unit import nanoseconds_of, unit_by_steps
from friction_bags.bag_io.bag_format import BagError, Topic
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.cdr import decode, type_name
from friction_bags.importers.can_log import MDF_KIND, open_frames
from friction_bags.importers.log_kind import Kind, kind_of
from friction_bags.importers.mdf_log import channels_of
from friction_bags.importers.mdf_reader import Place, has_frames
from friction_bags.importers.table import is_time, parquet_head
from friction_bags.importers.text_table import TextTable
from friction_bags.remapped_bag import EmbeddedType, fields_in
from friction_parameters.parameter import ParameterError
from vehicle_models.nanoseconds import NANOSECONDS

_ROWS, _FRAMES = 5000, 200_000
"""Rows and frames that are looked at."""
_DEPTH: Final = 4
"""Levels of a message below which no signal is looked for."""


@dataclass(frozen=True)
class ListedSignal:
    """A signal of a log."""

    name: str
    """As a map names it: column, CAN signal, channel, or field of a topic."""
    source: str
    """`table`, `can`, or the topic."""
    type: str = ""
    """Message type of the topic."""
    unit: str = ""
    rate: float = nan
    """[Hz]"""
    low: float = nan
    high: float = nan


def list_signals(path: Path, dbc: Path | None) -> list[ListedSignal]:
    """List the signals of a log.

    Args:
        path: any log that `import` reads.
        dbc: DBC file of a CAN log.

    Raises:
        BagError: the log cannot be read.
        ParameterError: a package is not installed, or a CAN log has no DBC file.
        OSError: there is no such file.
    """
    kind, suffix = kind_of(path)
    if kind is Kind.MDF:
        channels = channels_of(path)
        holds_frames = dbc is not None and has_frames(list(channels))
        return _of_frames(path, MDF_KIND, dbc) if holds_frames else list(_of_channels(channels))
    if kind in (Kind.CAN, Kind.FRAME_TEXT):
        return _of_frames(path, suffix, dbc)
    if kind is Kind.BAG:
        return list(_of_bag(path))
    if kind is Kind.ROS_1:
        return list(_of_ros1(path))
    return _of_columns(path, kind)


def _of_columns(path: Path, kind: Kind) -> list[ListedSignal]:
    if kind is Kind.PARQUET:
        columns, rows = parquet_head(path, _ROWS)
    else:
        table = TextTable(path, ())
        columns = [name for name in table.columns if name]
        rows = [row for _, row, _ in islice(table.rows(columns), _ROWS)]
    clock = next((name for name in columns if is_time(name)), "")
    rate = _rate([row[clock] for row in rows if isfinite(row[clock])]) if clock else nan
    found = []
    for name in columns:
        values = np.array([row[name] for row in rows], dtype=np.float64)
        share = float(np.isfinite(values).mean()) if values.size else 0.0
        found.append(ListedSignal(name, "table", "", "", rate * share, *_range(values)))
    return found


def _rate(stamps: list[float]) -> float:
    unit, step = unit_by_steps(stamps)
    return NANOSECONDS / max(nanoseconds_of(step, unit), 1) if unit and unit != "days" and isfinite(step) else nan


def _range(values: Any) -> tuple[float, float]:
    known = values[np.isfinite(values)]
    return (float(known.min()), float(known.max())) if known.size else (nan, nan)


def _of_frames(path: Path, suffix: str, dbc: Path | None) -> list[ListedSignal]:
    if dbc is None:
        raise ParameterError(f"{path} holds CAN frames: give the DBC file that names their signals, --dbc FILE")
    frames = CanFrames(dbc)
    values: defaultdict[tuple[str, str], list[float]] = defaultdict(list)
    times: list[float] = []
    try:
        with open_frames(path, suffix) as log:
            for frame in islice(log, _FRAMES):
                times.append(frame.timestamp)
                for record in frames.decode(frame.arbitration_id, frame.is_extended_id, bytes(frame.data)):
                    for name, value in record.values.items():
                        values[record.frame, name].append(float(value))
    except BagError:
        raise
    except Exception as error:  # python-can passes on whatever its readers raise
        raise BagError(f"{path} cannot be read: {error!r}") from error
    duration = max(times) - min(times) if times else 0.0
    return [
        ListedSignal(
            f"{frame}.{name}",
            "can",
            "",
            frames.find(f"{frame}.{name}")[2],
            len(each) / duration if duration else nan,
            *_range(np.array(each)),
        )
        for (frame, name), each in values.items()
    ]


def _of_channels(channels: Mapping[str, Sequence[Place]]) -> Iterator[ListedSignal]:
    for name, places in channels.items():
        for place in places:
            title = name if len(places) == 1 else f"{place.group}.{name}"
            yield ListedSignal(title, "can", unit=place.unit)


def _of_bag(path: Path) -> Iterator[ListedSignal]:
    with BagReader(path) as reader:
        duration = max((reader.end - reader.start) / NANOSECONDS, 1e-9)
        for topic, count in reader.counts.items():
            rate = count / duration
            if topic.type == type_name(JointState):
                names = _joints(reader, topic)
                fields = [f"{part}[name={name}]" for part in ("velocity", "position") for name in names]
            else:
                try:
                    fields = list(_leaves(EmbeddedType(topic).fields))
                except BagError:
                    continue
            yield from (ListedSignal(field, topic.name, topic.type, rate=rate) for field in fields)


def _joints(reader: BagReader, topic: Topic) -> list[str]:
    for _, _, data in reader.messages([topic]):
        return list(decode(data, JointState).name)
    return []


def _of_ros1(path: Path) -> Iterator[ListedSignal]:
    try:
        with AnyReader([path]) as reader:
            duration = max(reader.duration / NANOSECONDS, 1e-9)
            for each in reader.connections:
                fields = _leaves(fields_in(reader.typestore, each.msgtype))
                rate = each.msgcount / duration
                yield from (ListedSignal(field, each.topic, each.msgtype, rate=rate) for field in fields)
    except Exception as error:  # rosbags passes on errors of every layer below it
        raise BagError(f"{path} cannot be read: {error}") from error


def _leaves(fields: Fields, before: str = "", depth: int = 0) -> Iterator[str]:
    """Yield the paths of the values of a message, without those in sequences."""
    for name, below in fields.members.items():
        path = f"{before}{name}"
        if below.is_sequence or name == "header":
            continue
        if below.members and depth < _DEPTH:
            yield from _leaves(below, f"{path}.", depth + 1)
        elif not below.members:
            yield path
