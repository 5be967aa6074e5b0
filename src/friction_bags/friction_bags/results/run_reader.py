"""Recorded runs from messages: those of a bag, or those that estimators make of one."""

from __future__ import annotations

from array import array
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_bags.bag_io.bag_format import BagError
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.cdr import decode
from friction_bags.results.recorded_run import COLUMNS, VALID, VEHICLE, WHY, Columns, RecordedRun, Series
from friction_runtime.installed import message_class
from friction_runtime.messages import to_nanoseconds
from friction_runtime.reports import report_kind
from vehicle_models.nanoseconds import NANOSECONDS

_SAMPLES = "wheel_states"
_SAMPLES_TYPE = "sensor_msgs/msg/JointState"
_TYRES = "friction_msgs/msg/TyreSignals"
"""Type of the topics from which something can be shown without wheel_states."""
_MOST_REASONS = 100
"""Reasons of one topic that are distinguished."""
_OTHERS = "other reasons"
_UNSET = 86400 * NANOSECONDS
"""Stamps of zero among such that are larger than this [ns] were never set."""
_PROGRESS_EVERY = 5000


class RunCollector:
    """Collects messages topic by topic, as they come."""

    def __init__(self, columns: Columns = COLUMNS) -> None:
        """Start without messages; `columns`: what is read of them, by default all that can be shown."""
        self._columns = columns
        self._rows: dict[str, _Rows] = {}
        self._of_wheels: set[str] = set()

    def adds(self, name: str, kind: str) -> bool:
        """Return whether something is shown of a topic, and take its messages from now on.

        Args:
            name: of the topic, without the namespace.
            kind: type of its messages.
        """
        if name in self._rows or not (kind in self._columns or (name == _SAMPLES and kind == _SAMPLES_TYPE)):
            return False
        self._rows[name] = _Rows(kind, self._columns.get(kind, ()))
        if kind.startswith("friction_msgs/") or name.endswith("/brake_pressure"):
            self._of_wheels.add(name)
        return True

    def decode(self, name: str, data: bytes) -> None:
        """Take a message of a topic as CDR."""
        self._rows[name].decode(data)

    def take(self, name: str, message: Any) -> None:
        """Take a message of a topic."""
        self._rows[name].take(message)

    def has(self, name: str) -> bool:
        """Whether a topic has a message so far."""
        return bool(self._rows[name])

    def run(
        self,
        wheels: Sequence[str] | None,
        notes: Mapping[str, str],
        problems: Sequence[str] = (),
        not_read: Sequence[str] = (),
    ) -> RecordedRun:
        """Return the run and forget the messages; arguments as in RecordedRun, `wheels` as in read_run.

        Raises:
            BagError: there is no message.
        """
        rows, found = self._rows, list(problems)
        if max((int(each.stamps.max(initial=0)) for each in rows.values()), default=0) > _UNSET:
            for each in rows.values():
                each.leave_unset_out()
        for name, each in rows.items():
            found += [f"{name}: {each.refused} messages cannot be decoded"] if each.refused else []
            found += [f"{name}: {each.unset} messages without a stamp are ignored"] if each.unset else []
        read = {name: each for name, each in rows.items() if each.stamps.size}
        if not read:
            raise BagError("no message can be shown")
        start = _start(read)
        if wheels is None:
            wheels = sorted(_wheels_of(name for name in self._of_wheels if rows[name]))
        rows.clear()
        series = {name: read.pop(name).series(start) for name in list(read)}  # frees each: an hour of them is gigabytes
        samples = series.pop(_SAMPLES).time if _SAMPLES in series else np.empty(0)
        return RecordedRun(tuple(wheels), start, series, samples, notes, tuple(found), tuple(sorted(not_read)))


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
    collector = RunCollector(columns)
    with BagReader(bag) as reader:
        named = {topic: topic.name.removeprefix(prefix) for topic in reader.counts if topic.name.startswith(prefix)}
        taken = {topic: name for topic, name in named.items() if collector.adds(name, topic.type)}
        total = max(reader.message_count, 1)
        for number, (topic, _, data) in enumerate(reader.messages(taken)):
            collector.decode(taken[topic], data)
            if number % _PROGRESS_EVERY == 0:
                progress(number / total)
        others = [topic.name for topic in reader.counts if topic not in taken]
        others += [f"{topic.name} (no message)" for topic, name in taken.items() if not collector.has(name)]
        try:
            return collector.run(wheels, reader.custom_data, reader.problems, others)
        except BagError as error:
            raise BagError(f"{bag} holds no message below {prefix} that can be shown") from error


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


def _start(read: Mapping[str, _Rows]) -> int:
    """Return the first stamp of wheel_states, in the order of recording, or the least of all where there is none."""
    if _SAMPLES in read:
        return int(read[_SAMPLES].stamps[0])
    return min(int(rows.stamps.min()) for rows in read.values())


def _wheels_of(topics: Iterable[str]) -> set[str]:
    """Return the wheels that topics name: what stands before the last part of a name."""
    return {name.removeprefix("truth/").rpartition("/")[0] for name in topics} - {"", VEHICLE}


class _Rows:
    """The messages of one topic as they come."""

    def __init__(self, kind: str, columns: tuple[str, ...]) -> None:
        self._columns = columns
        self._kind = message_class(kind)
        self._get = [attrgetter(column) for column in self._columns]
        self._judged = VALID in self._columns
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

    def decode(self, data: bytes) -> None:
        try:
            message = decode(data, self._kind)
        except ValueError:
            self.refused += 1
            return
        self.take(message)

    def take(self, message: Any) -> None:
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
