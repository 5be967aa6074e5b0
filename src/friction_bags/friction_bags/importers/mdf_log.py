"""Logs in MDF 3 and 4, through asammdf."""

import logging
from collections.abc import Iterator, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np

from friction_adapter.ros.messages import RecordMapper
from friction_adapter.signal_map import SignalMap
from friction_adapter.sources import Sources
from friction_bags.bag_io.bag_format import BagError
from friction_bags.importers.start_offset import start_offset
from friction_parameters.command_line import install_line
from friction_parameters.parameter import ParameterError
from friction_runtime.processor import Output
from vehicle_models.nanoseconds import NANOSECONDS

INSTALL_LINE = install_line("asammdf")
_MOST_LISTED = 30
_FRAMES = "CAN_DataFrame"
"""Channel of the frames of a bus, by the standard of ASAM."""


def has_frames(path: Path) -> bool:
    """Whether a log holds CAN frames as they were on the bus.

    Raises:
        BagError, ParameterError, OSError: as MdfLog.
    """
    mdf = open_mdf(path)
    try:
        return _FRAMES in mdf.channels_db
    finally:
        mdf.close()


def open_mdf(path: Path) -> Any:
    """Open a log.

    Raises:
        BagError, ParameterError, OSError: as MdfLog.
    """
    try:
        from asammdf import MDF
    except ImportError as error:
        raise ParameterError(f"MDF logs need one more package: {INSTALL_LINE}") from error
    path.stat()
    logging.getLogger("asammdf").setLevel(logging.CRITICAL)  # what it prints, it raises too
    try:
        return MDF(path)
    except Exception as error:  # asammdf passes on whatever its parsers raise
        raise BagError(f"{path} cannot be read: {error}") from error


class MdfLog:
    """A log, read through a signal map whose CAN signals are the names of channels.

    The channels of a group have the same times, as the signals of a CAN frame.
    """

    def __init__(self, path: Path, signal_map: SignalMap) -> None:
        """Find the signals of the map.

        Raises:
            BagError: the log cannot be read.
            ParameterError: asammdf is not installed, or the log lacks a channel.
            OSError: there is no such log.
        """
        self._path = path
        self._mdf = open_mdf(path)
        self._needed: dict[str, dict[str, tuple[int, int]]] = {}
        """Group and place of each channel that is needed, by its name and that of its source."""
        self._mapper = RecordMapper(signal_map, Sources(can=self))
        self._is_offset = signal_map.stamp_offset != 0
        self._share = 0.0

    def find(self, name: str) -> tuple[str, str, str]:
        """Return group, name within it and unit of a channel, given as NAME or GROUP.NAME, groups numbered from 0.

        Raises:
            ValueError: there is no such channel, or several; the text names those there are.
        """
        channels = self._mdf.channels_db
        group, _, rest = name.partition(".")
        only = int(group) if group.isdecimal() and rest in channels else None
        channel = name if only is None else rest
        places = [place for place in channels.get(channel, ()) if only in (None, place[0])]
        if len(places) > 1:
            several = ", ".join(f"{place[0]}.{channel}" for place in places)
            raise ValueError(f"several channels have the name '{channel}': {several}")
        if not places:
            near = get_close_matches(name, list(channels), _MOST_LISTED, 0.4) or sorted(channels)[:_MOST_LISTED]
            frames = (
                "; it holds CAN frames: give a DBC file, 'can: {dbc: FILE}' or --dbc" if _FRAMES in channels else ""
            )
            raise ValueError(f"{self._path} has no channel '{name}': there are {', '.join(near)}{frames}")
        number, index = places[0]
        source = f"group {number}"
        self._needed.setdefault(source, {})[channel] = (number, index)
        return source, channel, self._mdf.get_channel_unit(channel, group=number, index=index) or ""

    def messages(self) -> Iterator[Output]:
        """Yield topics and messages.

        Raises:
            BagError: a channel cannot be read.
        """
        groups = {source: self._columns(channels) for source, channels in self._needed.items()}
        names = list(groups)
        times = np.concatenate([groups[name][0] for name in names])
        numbers = np.repeat(np.arange(len(names)), [groups[name][0].size for name in names])
        rows = np.concatenate([np.arange(groups[name][0].size) for name in names])
        order = np.argsort(times, kind="stable")
        is_kept = self._is_offset or not times.size
        offset = 0 if is_kept else start_offset(float(times[order[0]])) * NANOSECONDS
        for done, at in enumerate(order.tolist()):
            self._share = done / order.size
            source = names[numbers[at]]
            record = {channel: values[rows[at]] for channel, values in groups[source][1].items()}
            stamp = round(float(times[at]) * NANOSECONDS) + offset
            for topic, message in self._mapper.take(source, record, stamp):
                yield f"/{topic}", message
        self._mdf.close()

    @property
    def notes(self) -> Sequence[str]:
        """None."""
        return ()

    def share(self) -> float:
        """Return the share of the samples that have been read."""
        return self._share

    def problems(self) -> dict[str, int]:
        """Return how often something could not be used, by what it is."""
        return self._mapper.problems_at_end()

    def _columns(self, channels: dict[str, tuple[int, int]]) -> tuple[Any, dict[str, Any]]:
        """Return times [s] and values of the channels of one group, NaN where a value is marked as invalid."""
        times, columns = np.empty(0), {}
        for name, (group, index) in channels.items():
            try:
                found = self._mdf.get(name, group=group, index=index, ignore_invalidation_bits=True)
                values = np.array(found.samples, dtype=np.float64)
            except Exception as error:  # asammdf passes on whatever its parsers raise
                raise BagError(f"{self._path}: channel '{name}' cannot be read: {error}") from error
            if found.invalidation_bits is not None:
                values[np.asarray(found.invalidation_bits, dtype=bool)] = np.nan
            times, columns[name] = found.timestamps, values
        return times, columns
