"""Reads MDF logs through asammdf, which may crash on a damaged one: to be run by `from_child`."""

import logging
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

_FRAMES: Final = "CAN_DataFrame"
"""Channel of the frames of a bus, by the standard of ASAM."""
_BATCH: Final = 1000
"""Frames that are sent at once."""


class Place(NamedTuple):
    """Where a channel is."""

    group: int
    place: int
    """In the group."""
    unit: str
    """As the log has it."""


class LoggedFrame(NamedTuple):
    """A frame as it was on the bus, with the names that python-can gives to its parts."""

    timestamp: float
    """[s]"""
    arbitration_id: int
    is_extended_id: bool
    channel: str
    data: bytes
    is_error_frame: bool = False
    is_remote_frame: bool = False


def channels(path: Path) -> Iterator[tuple[str, list[Place]]]:
    """Yield the names of the channels of a log, with their places."""
    mdf = _opened(path)
    for name, places in mdf.channels_db.items():
        units = [mdf.get_channel_unit(name, group=group, index=index) or "" for group, index in places]
        yield name, [Place(group, index, unit) for (group, index), unit in zip(places, units, strict=True)]


def has_frames(names: Sequence[str]) -> bool:
    """Whether a log with these channels holds the frames of a bus."""
    return _FRAMES in names


def frames(path: Path) -> Iterator[list[LoggedFrame]]:
    """Yield the frames of a log in the order of their times, some at once."""
    from can import MF4Reader

    logging.getLogger("asammdf").setLevel(logging.CRITICAL)
    batch: list[LoggedFrame] = []
    with MF4Reader(path) as log:
        for each in log:
            flags = each.is_error_frame, each.is_remote_frame
            head = each.timestamp, each.arbitration_id, each.is_extended_id, str(each.channel)
            batch.append(LoggedFrame(*head, bytes(each.data or b""), *flags))
            if len(batch) == _BATCH:
                yield batch
                batch = []
    yield batch


def columns(path: Path, wanted: Sequence[tuple[str, int, int]]) -> Iterator[tuple[str, int, Any, Any]]:
    """Yield name, group, times [s] and values of channels, given by name, group and index; NaN: marked as invalid."""
    mdf = _opened(path)
    for name, group, index in wanted:
        found = mdf.get(name, group=group, index=index, ignore_invalidation_bits=True)
        values = np.array(found.samples, dtype=np.float64)
        if found.invalidation_bits is not None:
            values[np.asarray(found.invalidation_bits, dtype=bool)] = np.nan
        yield name, group, np.asarray(found.timestamps, dtype=np.float64), values


def _opened(path: Path) -> Any:
    from asammdf import MDF

    logging.getLogger("asammdf").setLevel(logging.CRITICAL)  # what it prints, it raises too
    return MDF(path)
