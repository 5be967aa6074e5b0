"""Crash-safe writing of rosbag2 bags: mcap, ros2 profile, embedded definitions, chunks written in time."""

from collections.abc import Mapping
from pathlib import Path
from types import TracebackType

from friction_bags.bag_io.bag_format import BagError, Topic, write_metadata
from friction_bags.bag_io.mcap_writer import Compression, McapWriter


class BagWriter:
    """A bag of one mcap file. Leaving the context closes it, even after an error: what was written is kept."""

    def __init__(
        self,
        bag: Path,
        *,
        compression: Compression = "zstd",
        chunk_size: int = 1 << 20,
        custom_data: Mapping[str, str] | None = None,
    ) -> None:
        """Make the directory and the file.

        Args:
            bag: directory to be made; it must not exist.
            compression: compression of each chunk.
            chunk_size: size at which a chunk is closed [bytes].
            custom_data: notes for metadata.yaml.

        Raises:
            BagError: the directory exists or cannot be made.
        """
        try:
            bag.mkdir(parents=True)
            self._file = McapWriter(bag / f"{bag.name}_0.mcap", compression=compression, chunk_size=chunk_size)
        except FileExistsError:
            raise BagError(f"{bag} exists: give another name, or remove it; nothing is overwritten") from None
        except OSError as error:
            raise BagError(f"{bag} cannot be made: {error.strerror}") from error
        self._bag = bag
        self._custom_data = dict(custom_data or {})
        self._open = True

    def add_topic(self, topic: Topic) -> int:
        """Declare a topic, once; return its channel."""
        return self._file.add_topic(topic)

    def write(self, channel: int, stamp: int, data: bytes, sent: int | None = None, sequence: int = 0) -> None:
        """Append a message, see McapWriter.write.

        Raises:
            BagError: the disk is full or fails.
        """
        try:
            self._file.write(channel, stamp, data, sent, sequence)
        except OSError as error:
            raise self._failed(error) from error

    def flush(self) -> None:
        """Make what was written so far survive a kill of this process.

        Raises:
            BagError: the disk is full or fails.
        """
        try:
            self._file.flush()
        except OSError as error:
            raise self._failed(error) from error

    def close(self) -> None:
        """Write index, footer and metadata.yaml; a second call does nothing.

        Raises:
            BagError: the disk is full or fails.
        """
        if not self._open:
            return
        self._open = False
        try:
            write_metadata(self._bag, "mcap", [self._file.finish()], self._custom_data)
        except OSError as error:
            raise self._failed(error) from error

    def __enter__(self) -> "BagWriter":
        """Return itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Close."""
        self.close()

    def _failed(self, error: OSError) -> BagError:
        self._open = False
        self._file.abandon()
        return BagError(
            f"{self._bag}: writing failed: {error.strerror}. What was flushed before is kept: "
            f"make room, then run `python3 -m friction_bags reindex {self._bag}`"
        )
