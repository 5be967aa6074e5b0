"""Logs in MDF 3 and 4 as messages by a signal map."""

from collections.abc import Iterator, Mapping, Sequence
from difflib import get_close_matches
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

import numpy as np

from friction_adapter.ros.messages import RecordMapper
from friction_adapter.signal_map import SignalMap
from friction_adapter.sources import Sources
from friction_bags.importers import mdf_reader
from friction_bags.importers.child import from_child
from friction_bags.importers.mdf_reader import Place, has_frames
from friction_bags.importers.start_offset import start_offset
from friction_parameters.command_line import install_line
from friction_parameters.parameter import ParameterError
from friction_runtime.processor import Output
from vehicle_models.nanoseconds import NANOSECONDS

INSTALL_LINE: Final = install_line("asammdf")
_MOST_LISTED: Final = 30


def channels_of(path: Path) -> dict[str, list[Place]]:
    """Return the places of the channels of a log, by name.

    Raises:
        BagError: the log cannot be read.
        ParameterError: asammdf is not installed.
        OSError: there is no such log.
    """
    path.stat()
    if find_spec("asammdf") is None:
        raise ParameterError(f"MDF logs need one more package: {INSTALL_LINE}")
    return dict(from_child(mdf_reader.channels, path))


class MdfLog:
    """A log, read through a signal map whose CAN signals are the names of channels.

    The channels of a group have the same times, as the signals of a CAN frame.
    """

    def __init__(self, path: Path, signal_map: SignalMap, channels: Mapping[str, list[Place]]) -> None:
        """Find the signals of the map among the channels, which are those of `channels_of`.

        Raises:
            ParameterError: the log lacks a channel.
        """
        self._path = path
        self._channels = channels
        self._needed: dict[str, dict[str, Place]] = {}
        """Place of each channel that is needed, by its name and that of its source."""
        self._mapper = RecordMapper(signal_map, Sources(can=self))
        self._is_offset = signal_map.stamp_offset != 0
        self._share = 0.0
        self._timeless = 0
        """Samples whose time is no number."""

    def find(self, name: str) -> tuple[str, str, str]:
        """Return group, name within it and unit of a channel, given as NAME or GROUP.NAME, groups numbered from 0.

        Raises:
            ValueError: there is no such channel, or several; the text names those there are.
        """
        channels = self._channels
        group, _, rest = name.partition(".")
        only = int(group) if group.isdecimal() and rest in channels else None
        channel = name if only is None else rest
        places = [place for place in channels.get(channel, ()) if only in (None, place.group)]
        if len(places) > 1:
            several = ", ".join(f"{place.group}.{channel}" for place in places)
            raise ValueError(f"several channels have the name '{channel}': {several}")
        if not places:
            near = get_close_matches(name, list(channels), _MOST_LISTED, 0.4) or sorted(channels)[:_MOST_LISTED]
            frames = (
                "; it holds CAN frames: 'can: {dbc: FILE}' in the map, or --dbc" if has_frames(list(channels)) else ""
            )
            raise ValueError(f"{self._path} has no channel '{name}': there are {', '.join(near)}{frames}")
        source = f"group {places[0].group}"
        self._needed.setdefault(source, {})[channel] = places[0]
        return source, channel, places[0].unit

    def messages(self) -> Iterator[Output]:
        """Yield topics and messages.

        Raises:
            BagError: a channel cannot be read.
        """
        wanted = [(name, each.group, each.place) for of in self._needed.values() for name, each in of.items()]
        groups: dict[str, tuple[Any, dict[str, Any]]] = {}
        for name, group, times, values in from_child(mdf_reader.columns, self._path, wanted):
            groups.setdefault(f"group {group}", (times, {}))[1][name] = values
        names = list(groups)
        times = np.concatenate([groups[name][0] for name in names])
        numbers = np.repeat(np.arange(len(names)), [groups[name][0].size for name in names])
        rows = np.concatenate([np.arange(groups[name][0].size) for name in names])
        order = np.argsort(times, kind="stable")
        has_time = np.isfinite(times[order])
        self._timeless, order = int((~has_time).sum()), order[has_time]
        is_kept = self._is_offset or not order.size
        offset = 0 if is_kept else start_offset(float(times[order[0]])) * NANOSECONDS
        for done, at in enumerate(order.tolist()):
            self._share = done / order.size
            source = names[numbers[at]]
            record = {channel: values[rows[at]] for channel, values in groups[source][1].items()}
            stamp = round(float(times[at]) * NANOSECONDS) + offset
            for topic, message in self._mapper.take(source, record, stamp):
                yield f"/{topic}", message

    @property
    def notes(self) -> Sequence[str]:
        """None."""
        return ()

    def share(self) -> float:
        """Return the share of the samples that have been read."""
        return self._share

    def problems(self) -> dict[str, int]:
        """Return how often something could not be used, by what it is."""
        timeless = {"sample without a time": self._timeless} if self._timeless else {}
        return {**self._mapper.problems_at_end(), **timeless}
