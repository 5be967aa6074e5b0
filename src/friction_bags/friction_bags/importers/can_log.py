"""Logs of a CAN bus as messages by a signal map."""

from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from friction_adapter.ros.messages import RecordMapper
from friction_adapter.signal_map import SignalMap
from friction_adapter.sources import INSTALL_LINE, CanFrames, Sources
from friction_bags.bag_io.bag_format import BagError
from friction_bags.importers.asc_stamps import LATER, AscStamps
from friction_bags.importers.blf_objects import count_objects
from friction_parameters.parameter import ParameterError
from friction_runtime.processor import Output
from vehicle_models.nanoseconds import NANOSECONDS

"""Logs that count from their own beginning: a stamp of 0 s is no stamp, so they are put later."""

START_OFFSET = 1000
"""By how much such a log is put later [s]."""
_EARLIEST = 1.0
"""A log that begins before it counts from its beginning [s]."""
SUFFIXES = (".asc", ".blf", ".log", ".trc")
_CSV_BEGIN = "timestamp,arbitration_id,"
"""Begin of the first line of a CSV file that python-can has written: one of frames, and no table."""


def start_offset(first: float) -> int:
    """Return what to add to the times of a log whose first time is `first` [s]; NaN is no time and asks for nothing."""
    return START_OFFSET if first < _EARLIEST else 0


def is_can_log(path: Path) -> bool:
    """Whether a path is that of a CAN log.

    Raises:
        OSError: there is no such file.
    """
    if path.suffix.lower() != ".csv":
        return path.suffix.lower() in SUFFIXES
    with path.open("rb") as stream:
        return stream.readline(200).startswith(_CSV_BEGIN.encode())


class CanLog:
    """A log, read through a signal map."""

    def __init__(self, path: Path, signal_map: SignalMap, dbc: Path | None) -> None:
        """Find the signals of the map.

        Args:
            path: path of the log, for which is_can_log holds; its suffix is its format.
            signal_map: the map.
            dbc: DBC file in place of that of the map; None for that of the map.

        Raises:
            ParameterError: a package is not installed, there is no DBC file, or it lacks a signal.
            OSError: there is no such log.
        """
        try:
            import can
        except ImportError as error:
            raise ParameterError(f"CAN logs need two more packages: {INSTALL_LINE}") from error
        dbc = dbc or signal_map.can.dbc
        if dbc is None:
            raise ParameterError(f"{signal_map.path}: {path} needs a DBC file: 'can: {{dbc: FILE}}', or --dbc")
        path.stat()
        self._can = can
        self._path = path
        self._size = max(path.stat().st_size, 1)
        self._file: Any = None
        self._frames = CanFrames(dbc)
        self._mapper = RecordMapper(signal_map, Sources(can=self._frames))
        self._frames.keep(self._mapper.sources)
        self.notes = self._frames.notes
        """What is to be known of the DBC file."""
        self._is_offset = signal_map.stamp_offset != 0
        self._bus = signal_map.can.bus
        self._buses: defaultdict[str, set[str]] = defaultdict(set)
        self._cut_off = ""

    def messages(self) -> Iterator[Output]:
        """Yield topics and messages.

        Raises:
            BagError: the log cannot be read, or not to its end.
        """
        offset: int | None = 0 if self._is_offset else None
        later = LATER if self._is_asc else 0
        for frame in self._logged():
            bus = str(frame.channel)
            if self._bus and bus != self._bus:
                continue
            decoded = self._frames.decode(frame.arbitration_id, frame.is_extended_id, bytes(frame.data))
            time = frame.timestamp - later
            if offset is None:
                offset = start_offset(time) * NANOSECONDS
            for record in decoded:
                self._buses[record.frame].add(bus)
                stamp = round(time * NANOSECONDS) + offset
                for topic, message in self._mapper.take(record.name, record.values, stamp):
                    yield f"/{topic}", message

    def share(self) -> float:
        """Return the share of the log that has been read."""
        if self._file is None or self._file.closed:
            return 0.0
        binary = getattr(self._file, "buffer", self._file)  # a text stream has no position while it is read
        return float(binary.tell() / self._size)

    def problems(self) -> dict[str, int]:
        """Return how often something could not be used, by what it is."""
        undecoded = self._frames.undecoded
        found = {self._cut_off: 0} if self._cut_off else {}
        for frame, buses in self._buses.items():
            if len(buses) > 1:
                several = ", ".join(sorted(buses))
                found[f"frame {frame} comes on the buses {several}: 'can: {{bus: N}}' in the map takes one of them"] = 0
        found |= dict.fromkeys(self._frames.not_in_log(), 0)
        found |= self._mapper.problems_at_end()
        return {**found, **({"frame that cannot be decoded": undecoded} if undecoded else {})}

    @property
    def _is_asc(self) -> bool:
        return self._path.suffix.lower() == ".asc"

    def _reader(self) -> Any:
        """Open the log."""
        if self._is_asc:
            return self._can.ASCReader(AscStamps(self._path))
        if self._path.suffix.lower() == ".blf":
            objects = count_objects(self._path)
            if objects.there < objects.stated or not objects.is_whole:
                stated = f", and its header states {objects.stated}" if objects.stated else ""
                self._cut_off = f"the log is cut off: {objects.there} objects are there{stated}"
        return self._can.LogReader(self._path)

    def _logged(self) -> Iterator[Any]:
        """Yield the frames with data."""
        try:
            with self._reader() as log:
                self._file = log.file
                for frame in log:
                    if not (frame.is_error_frame or frame.is_remote_frame):
                        yield frame
        except BagError:
            raise
        except Exception as error:  # python-can passes on whatever its readers raise
            raise BagError(f"{self._path} cannot be read, or not to its end: {error}") from error
