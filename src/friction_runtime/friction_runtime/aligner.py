"""Alignment of several input streams to the stamps of one of them, whatever the order of arrival.

A primary sample is ready once every other input has a sample at or past its stamp; the others are then interpolated to
it. An input that has not come when the primary is a deadline further (in message time) is missing for that sample, with
the reason. An input that has been silent for longer than its `max_gap` is not waited for until it comes back: no
interpolation reaches across, and so the loss of one input does not delay the answers for ever. What comes out depends
on the stamps only, as long as no stream arrives later than the deadline; but where an input comes back from a silence,
the first sample that uses it is that at which it has arrived.

A stamp that steps back a little is that of a late sample: it is refused and counted. A jump back in time (a looped bag,
a reset plant) starts a new epoch of a stream. Samples compare by (epoch, stamp), so that nothing from before a jump is
ever mixed with what follows, in whichever order the streams jump.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Final, Generic, TypeVar

from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.physical_bounds import LATEST_STAMP, NEW_RUN

Payload = TypeVar("Payload")

_MAX_BUFFERED: Final = 20_000
"""Samples an input may run ahead of the primary before the oldest are dropped: 100 s at 200 Hz."""


@dataclass(frozen=True)
class AlignedInput:
    """An input that is interpolated to the primary's stamps."""

    topic: str
    """Topic name, used in results and in reasons."""
    max_gap: float = 0.1
    """No interpolation between samples further apart than this [s]."""
    optional: bool = False
    """Waited for only while its samples follow each other within `max_gap`: not before the second one."""


class AlignedSample(Generic[Payload]):
    """A primary sample with the other inputs at its stamp."""

    def __init__(
        self,
        stamp: int,
        time: float,
        payload: Payload,
        values: dict[str, tuple[float, ...]],
        missing: dict[str, str],
        rewound: bool,
    ) -> None:
        """Hold what is known at a stamp.

        Args:
            stamp: [ns].
            time: since the first sample of the run [s]. Since 1970 a double would be 0.2 us coarse, and whether a
                sample is as old as a window is long would depend on the date.
            payload: what was offered with the primary sample.
            values: values of the inputs that are known at the stamp, by topic.
            missing: reasons why the other inputs are not known, by topic.
            rewound: whether it is the first sample after a jump back in time, where estimators start again.
        """
        self.stamp = stamp
        self.time = time
        self.payload = payload
        self.values = values
        self.missing = missing
        self.rewound = rewound


class _Timed(Generic[Payload]):
    """A primary sample that waits, or a sample of another input."""

    __slots__ = ("epoch", "payload", "rewound", "stamp")

    def __init__(self, epoch: int, stamp: int, payload: Payload, rewound: bool = False) -> None:
        self.epoch = epoch
        self.stamp = stamp
        self.payload = payload
        self.rewound = rewound

    def is_after(self, epoch: int, stamp: int) -> bool:
        return self.epoch > epoch or (self.epoch == epoch and self.stamp > stamp)


class _Stream:
    """One aligned input: its samples from the newest one at or before the primary onwards."""

    __slots__ = (
        "apart_since",
        "awaited",
        "epoch",
        "last_stamp",
        "late",
        "max_gap_ns",
        "optional",
        "samples",
        "topic",
    )

    def __init__(self, declared: AlignedInput) -> None:
        self.topic = declared.topic
        self.max_gap_ns = round(declared.max_gap * NANOSECONDS)
        self.optional = declared.optional
        self.awaited = not declared.optional
        self.samples: deque[_Timed[tuple[float, ...]]] = deque(maxlen=_MAX_BUFFERED)
        self.epoch = 0
        self.last_stamp = 0
        self.apart_since: int | None = None
        self.late = 0

    def take(self, stamp: int, values: tuple[float, ...]) -> None:
        if self.optional:
            self.awaited = 0 < stamp - self.last_stamp <= self.max_gap_ns
        self.last_stamp = stamp
        self.samples.append(_Timed(self.epoch, stamp, values))

    def forget(self, epoch: int) -> None:
        self.samples.clear()
        self.epoch = epoch
        self.last_stamp = 0
        self.apart_since = None
        self.awaited = not self.optional

    def at(self, epoch: int, stamp: int) -> tuple[float, ...] | str:
        """Values at a stamp, or the reason why there are none. Drops what no later stamp can need."""
        samples = self.samples
        while len(samples) > 1 and not samples[1].is_after(epoch, stamp):
            samples.popleft()
        if not samples:
            return f"{self.topic}: no sample received"
        before = samples[0]
        if before.epoch == epoch and before.stamp == stamp:
            return before.payload
        if before.is_after(epoch, stamp):
            return f"{self.topic}: no sample at or before this stamp"
        if len(samples) == 1:
            return f"{self.topic}: silent, last sample {(stamp - before.stamp) / NANOSECONDS:.3f} s older"
        after = samples[1]
        if after.epoch != before.epoch or after.stamp - before.stamp > self.max_gap_ns:
            return f"{self.topic}: gap around this stamp"
        weight = (stamp - before.stamp) / (after.stamp - before.stamp)
        return tuple(a + weight * (b - a) for a, b in zip(before.payload, after.payload, strict=True))

    def settled(self, epoch: int, stamp: int) -> bool:
        """Whether there is nothing to wait for at a stamp: samples reach it, or have ended more than a gap before."""
        if not self.samples or self.epoch < epoch:
            return not self.awaited
        if self.epoch > epoch or self.last_stamp >= stamp:
            return True
        return not self.awaited or stamp - self.last_stamp > self.max_gap_ns


class Aligner(Generic[Payload]):
    """Aligns inputs to the stamps of a primary stream.

    `offer_primary` and `offer` take a sample, or refuse it with a reason and stay as they were; `ready` then yields
    what has become complete, in the order of the primary.
    """

    def __init__(self, primary: str, inputs: Sequence[AlignedInput], deadline: float = 0.05) -> None:
        """Start empty.

        Args:
            primary: topic of the primary stream, for reasons.
            inputs: the others.
            deadline: message time [s] a primary sample waits for the others, > 0.
        """
        self._primary = primary
        self._primary_late = 0
        self._streams = {declared.topic: _Stream(declared) for declared in inputs}
        self._all_streams = tuple(self._streams.values())
        self._deadline_ns = round(deadline * NANOSECONDS)
        self._pending: deque[_Timed[Payload]] = deque()
        self._epoch = 0
        self._epoch_start = 0
        self._begin = 0
        self._newest = 0

    def offer_primary(self, stamp: int, payload: Payload) -> str | None:
        """Take a primary sample with stamp [ns]; return the reason if it is refused."""
        newest = self._newest
        if not 0 < stamp <= LATEST_STAMP or stamp == newest:
            return _refusal(self._primary, stamp)
        rewound = stamp < newest
        if rewound and newest - stamp < NEW_RUN:
            self._primary_late += 1
            return _late(self._primary, newest - stamp)
        if rewound:
            self._epoch += 1
            self._epoch_start = stamp
            for stream in self._all_streams:
                stream.apart_since = stamp if stream.epoch != self._epoch else None
        self._newest = stamp
        for stream in self._all_streams:
            if stream.apart_since is not None and stamp - stream.apart_since > self._deadline_ns:
                # It jumped alone, or did not follow a jump: it belongs to the primary's present again.
                stream.forget(self._epoch)
        self._pending.append(_Timed(self._epoch, stamp, payload, rewound))
        return None

    def offer(self, topic: str, stamp: int, values: tuple[float, ...]) -> str | None:
        """Take a sample of an input with stamp [ns]; return the reason if it is refused."""
        stream = self._streams[topic]
        if not 0 < stamp <= LATEST_STAMP or stamp == stream.last_stamp:
            return _refusal(topic, stamp)
        for value in values:
            if not -inf < value < inf:  # NaN too; quicker than isfinite
                return f"{topic}: value is not finite"
        if stamp < stream.last_stamp:
            if stream.last_stamp - stamp < NEW_RUN:
                stream.late += 1
                return _late(topic, stream.last_stamp - stamp)
            stream.epoch += 1
            stream.apart_since = (self._newest or None) if stream.epoch != self._epoch else None
        stream.take(stamp, values)
        return None

    def ready(self) -> Sequence[AlignedSample[Payload]]:
        """Take out the samples that are complete, or whose deadline has passed."""
        pending = self._pending
        if not pending:
            return ()
        complete: list[AlignedSample[Payload]] = []
        while pending:
            primary = pending[0]
            if not self._reached(primary.epoch, primary.stamp) and not self._overdue(primary.epoch, primary.stamp):
                break
            pending.popleft()
            values: dict[str, tuple[float, ...]] = {}
            missing: dict[str, str] = {}
            for stream in self._all_streams:
                found = stream.at(primary.epoch, primary.stamp)
                if isinstance(found, str):
                    missing[stream.topic] = found
                else:
                    values[stream.topic] = found
            if primary.rewound or self._begin == 0:
                self._begin = primary.stamp
            time = (primary.stamp - self._begin) / NANOSECONDS
            complete.append(AlignedSample(primary.stamp, time, primary.payload, values, missing, primary.rewound))
        return complete

    def late(self) -> dict[str, int]:
        """Return the number of late samples since start or reset, by topic, where there were any."""
        counts = {self._primary: self._primary_late, **{stream.topic: stream.late for stream in self._all_streams}}
        return {topic: count for topic, count in counts.items() if count}

    def reset(self) -> None:
        """Forget every sample and every stamp."""
        self._begin = 0
        self._primary_late = 0
        self._pending.clear()
        self._newest = 0
        self._epoch = 0
        for stream in self._all_streams:
            stream.forget(0)
            stream.late = 0

    def _reached(self, epoch: int, stamp: int) -> bool:
        return all(stream.settled(epoch, stamp) for stream in self._all_streams)

    def _overdue(self, epoch: int, stamp: int) -> bool:
        waiting_since = stamp if epoch == self._epoch else self._epoch_start
        return self._newest - waiting_since >= self._deadline_ns


def _late(topic: str, by: int) -> str:
    return f"{topic}: late sample, {by / NANOSECONDS:.4f} s before the newest"


def _refusal(topic: str, stamp: int) -> str:
    if stamp <= 0:
        return f"{topic}: stamp is zero"
    return f"{topic}: stamp is out of range" if stamp > LATEST_STAMP else f"{topic}: stamp repeats"
