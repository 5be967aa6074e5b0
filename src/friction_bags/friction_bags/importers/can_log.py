"""Logs of a CAN bus as messages by a signal map."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

from friction_adapter.ros.messages import RecordMapper
from friction_adapter.signal_map import SignalMap
from friction_adapter.sources import INSTALL_LINE, CanFrames, Sources
from friction_bags.bag_io.bag_format import BagError
from friction_bags.importers import mdf_reader
from friction_bags.importers.blf_objects import count_objects
from friction_bags.importers.child import from_child
from friction_bags.importers.frame_lines import LATER, FrameLines
from friction_bags.importers.frame_text import FrameText
from friction_bags.importers.start_offset import start_offset
from friction_parameters.parameter import ParameterError
from friction_runtime.processor import Output
from vehicle_models.nanoseconds import NANOSECONDS

MDF_KIND: Final = ".mf4"
TEXT_KINDS: Final = (".asc", ".csv", ".log", ".trc")
"""Kinds that are texts."""
_READERS: Final = {
    ".asc": "ASCReader",
    ".blf": "BLFReader",
    ".csv": "CSVReader",
    ".log": "CanutilsLogReader",
    ".trc": "TRCReader",
}
"""Classes of python-can by the kind of log."""


class CanLog:
    """A log, read through a signal map."""

    def __init__(self, path: Path, signal_map: SignalMap, dbc: Path | None, kind: str) -> None:
        """Find the signals of the map.

        Args:
            path: path of the log.
            signal_map: the map.
            dbc: DBC file in place of that of the map; None for that of the map.
            kind: suffix that python-can reads it by; empty for frames as text.

        Raises:
            ParameterError: a package is not installed, there is no DBC file, or it lacks a signal.
            OSError: there is no such log.
        """
        dbc = dbc or signal_map.can.dbc
        if dbc is None:
            raise ParameterError(f"{signal_map.path}: {path} needs a DBC file: 'can: {{dbc: FILE}}', or --dbc")
        self._size = max(path.stat().st_size, 1)
        self._path = path
        self._kind = kind
        self._log: Any = None
        self._frames = CanFrames(dbc)
        self._mapper = RecordMapper(signal_map, Sources(can=self._frames))
        self._frames.keep(self._mapper.sources)
        self._is_offset = signal_map.stamp_offset != 0
        self._bus = signal_map.can.bus
        self._buses: dict[str, None] = {}
        self._buses_of: defaultdict[str, set[str]] = defaultdict(set)
        self._cut_off = ""
        self._unread = 0
        """Lines of a text that are, or were, those of frames, and are not."""

    @property
    def notes(self) -> Sequence[str]:
        """What is to be known of the DBC file."""
        return self._frames.notes

    def messages(self) -> Iterator[Output]:
        """Yield topics and messages.

        Raises:
            BagError: the log cannot be read, or not to its end.
        """
        offset: int | None = 0 if self._is_offset else None
        later = LATER if self._kind == ".asc" else 0
        for frame in self._logged():
            bus = str(frame.channel)
            self._buses[bus] = None
            if self._bus and bus != self._bus:
                continue
            decoded = self._frames.decode(frame.arbitration_id, frame.is_extended_id, bytes(frame.data))
            time = frame.timestamp - later
            if offset is None:
                offset = start_offset(time) * NANOSECONDS
            for record in decoded:
                self._buses_of[record.frame].add(bus)
                stamp = round(time * NANOSECONDS) + offset
                for topic, message in self._mapper.take(record.name, record.values, stamp):
                    yield f"/{topic}", message

    def share(self) -> float:
        """Return the share of the log that has been read."""
        stream = getattr(self._log, "file", None)
        if stream is None or stream.closed:
            return 0.0
        binary = getattr(stream, "buffer", stream)  # a text stream has no position while it is read
        return min(float(binary.tell() / self._size), 1.0)

    def problems(self) -> dict[str, int]:
        """Return how often something could not be used, by what it is."""
        found = dict.fromkeys(filter(None, (self._cut_off,)), 0)
        if self._bus and self._bus not in self._buses:
            found[f"there is no bus {self._bus}: the buses are {', '.join(self._buses) or 'none'}"] = 0
        for frame, buses in self._buses_of.items():
            if len(buses) > 1:
                several = ", ".join(sorted(buses))
                found[f"frame {frame} comes on the buses {several}: 'can: {{bus: N}}' in the map takes one of them"] = 0
        found |= dict.fromkeys(self._frames.not_in_log(), 0)
        counted = {"frame that cannot be decoded": self._frames.undecoded, "line that is no frame": self._unread}
        return {**found, **self._mapper.problems_at_end(), **{text: count for text, count in counted.items() if count}}

    def _logged(self) -> Iterator[Any]:
        """Yield the frames with data."""
        if self._kind == ".blf":
            objects = count_objects(self._path)
            if objects.there < objects.stated or not objects.is_whole:
                stated = f", and its header states {objects.stated}" if objects.stated else ""
                self._cut_off = f"the log is cut off: {objects.there} objects are there{stated}"
        self._log = open_frames(self._path, self._kind)
        count = 0
        try:
            with self._log as log:
                for frame in log:
                    count += 1
                    if not (frame.is_error_frame or frame.is_remote_frame):
                        yield frame
            self._count_lines(count)
        except BagError:
            raise
        except Exception as error:  # python-can passes on whatever its readers raise
            raise BagError(f"{self._path} cannot be read, or not to its end: {error!r}") from error

    def _count_lines(self, frames: int) -> None:
        """Compare the frames that came with the lines of a text."""
        if isinstance(self._log, FrameText):
            self._unread, is_cut_off = self._log.unread, self._log.is_cut_off
        elif isinstance(lines := getattr(self._log, "file", None), FrameLines):
            self._unread, is_cut_off = max(lines.frames - frames, 0), lines.is_cut_off
        else:
            return
        if is_cut_off:
            self._cut_off = "the last line has no end: the log may be cut off"


class _MdfFrames:
    """Frames of an MDF log, in place of a reader of python-can."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def __iter__(self) -> Iterator[Any]:
        """Yield the frames."""
        for batch in from_child(mdf_reader.frames, self._path):
            yield from batch

    def __enter__(self) -> "_MdfFrames":
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Do nothing: the child ends with its iterator."""


def open_frames(path: Path, kind: str) -> Any:
    """Open a log as an iterator of python-can's messages, which is also a context; kind as for CanLog.

    Raises:
        BagError: the log cannot be read.
        ParameterError: python-can is not installed.
    """
    try:
        import can
    except ImportError as error:
        raise ParameterError(f"CAN logs need two more packages: {INSTALL_LINE}") from error
    try:
        if not kind:
            return FrameText(path)
        if kind == MDF_KIND:
            return _MdfFrames(path)
        return getattr(can, _READERS[kind])(FrameLines(path, kind) if kind in TEXT_KINDS else path)
    except Exception as error:  # as above
        raise BagError(f"{path} cannot be read: {error!r}") from error
