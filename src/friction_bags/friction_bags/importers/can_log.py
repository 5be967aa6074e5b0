"""Logs of a CAN bus as messages by a signal map."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from friction_adapter.ros.messages import RecordMapper
from friction_adapter.signal_map import SignalMap
from friction_adapter.sources import INSTALL_LINE, CanFrames, Sources
from friction_bags.bag_io.bag_format import BagError
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
        self._is_offset = signal_map.stamp_offset != 0

    def messages(self) -> Iterator[Output]:
        """Yield topics and messages.

        Raises:
            BagError: the log cannot be read, or not to its end.
        """
        offset: int | None = 0 if self._is_offset else None
        for frame in self._logged():
            if offset is None:
                offset = start_offset(frame.timestamp) * NANOSECONDS
            decoded = self._frames.decode(frame.arbitration_id, frame.is_extended_id, bytes(frame.data))
            if decoded is not None:
                stamp = round(frame.timestamp * NANOSECONDS) + offset
                for topic, message in self._mapper.take(decoded.name, decoded.values, stamp):
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
        return {**self._mapper.problems(), **({"frame that cannot be decoded": undecoded} if undecoded else {})}

    def _logged(self) -> Iterator[Any]:
        """Yield the frames with data."""
        try:
            with self._can.LogReader(self._path) as log:
                self._file = log.file
                for frame in log:
                    if not (frame.is_error_frame or frame.is_remote_frame):
                        yield frame
        except Exception as error:  # python-can passes on whatever its readers raise
            raise BagError(f"{self._path} cannot be read, or not to its end: {error}") from error
