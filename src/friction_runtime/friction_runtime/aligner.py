"""Alignment of several input streams to the stamps of one of them, whatever the order of arrival.

A primary sample is ready once every other input has a sample at or past its stamp; the others are then interpolated to
it. An input that has not come when the primary is a deadline further (in message time) is missing for that sample, with
the reason. What comes out depends on the stamps only, as long as no stream arrives later than the deadline.

A jump back in time (a looped bag, a reset plant) starts a new epoch of a stream. Samples compare by (epoch, stamp), so
that nothing from before a jump is ever mixed with what follows, in whichever order the streams jump.
"""

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Generic, TypeVar

from friction_runtime.stamps import NANOSECONDS

Payload = TypeVar("Payload")
Key = tuple[int, int]

_MAX_BUFFERED = 20_000
"""Samples an input may run ahead of the primary before the oldest are dropped: 100 s at 200 Hz."""


@dataclass(frozen=True)
class AlignedInput:
    """An input that is interpolated to the primary's stamps."""

    topic: str
    """Its name, in results and in reasons."""
    max_gap: float = 0.1
    """No interpolation between samples further apart than this [s]."""


@dataclass(frozen=True)
class AlignedSample(Generic[Payload]):
    """A primary sample with the other inputs at its stamp."""

    stamp: int
    """[ns]"""
    payload: Payload
    """What was offered with the primary sample."""
    values: Mapping[str, tuple[float, ...]]
    """Values of the inputs that are known at the stamp, by topic."""
    missing: Mapping[str, str]
    """Reasons of those that are not, by topic."""
    rewound: bool
    """The first sample after a jump back in time: whoever keeps state starts anew."""


class _Stream:
    """One aligned input: its samples from the newest one at or before the primary onwards."""

    def __init__(self, declared: AlignedInput) -> None:
        self.declared = declared
        self.max_gap_ns = round(declared.max_gap * NANOSECONDS)
        self.samples: deque[tuple[Key, tuple[float, ...]]] = deque(maxlen=_MAX_BUFFERED)
        self.epoch = 0
        self.last_stamp: int | None = None
        self.apart_since: int | None = None

    def has_reached(self, key: Key) -> bool:
        return bool(self.samples) and self.samples[-1][0] >= key

    def at(self, key: Key) -> tuple[float, ...] | str:
        """Values at `key`, or the reason why there are none. Drops what no later key can need."""
        while len(self.samples) > 1 and self.samples[1][0] <= key:
            self.samples.popleft()
        name = self.declared.topic
        if not self.samples:
            return f"{name}: no sample received"
        (epoch, stamp), before = self.samples[0]
        if (epoch, stamp) == key:
            return before
        if (epoch, stamp) > key:
            return f"{name}: no sample at or before this stamp"
        if len(self.samples) == 1:
            return f"{name}: silent, last sample {(key[1] - stamp) / NANOSECONDS:.3f} s older"
        (next_epoch, next_stamp), after = self.samples[1]
        if next_epoch != epoch or next_stamp - stamp > self.max_gap_ns:
            return f"{name}: gap around this stamp"
        weight = (key[1] - stamp) / (next_stamp - stamp)
        return tuple(a + weight * (b - a) for a, b in zip(before, after, strict=True))


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
        self._streams = {declared.topic: _Stream(declared) for declared in inputs}
        self._deadline_ns = round(deadline * NANOSECONDS)
        self._pending: deque[tuple[Key, Payload, bool]] = deque()
        self._epoch = 0
        self._epoch_start = 0
        self._newest: int | None = None

    def offer_primary(self, stamp: int, payload: Payload) -> str | None:
        """Take a primary sample with stamp [ns]; return the reason if it is refused."""
        refusal = _refuse_stamp(self._primary, stamp, self._newest)
        if refusal is not None:
            return refusal
        rewound = self._newest is not None and stamp < self._newest
        if rewound:
            self._epoch += 1
            self._epoch_start = stamp
            for stream in self._streams.values():
                stream.apart_since = stamp if stream.epoch != self._epoch else None
        self._newest = stamp
        for stream in self._streams.values():
            if stream.apart_since is not None and stamp - stream.apart_since > self._deadline_ns:
                self._rejoin(stream)
        self._pending.append(((self._epoch, stamp), payload, rewound))
        return None

    def offer(self, topic: str, stamp: int, values: tuple[float, ...]) -> str | None:
        """Take a sample of an input with stamp [ns]; return the reason if it is refused."""
        stream = self._streams[topic]
        refusal = _refuse_stamp(topic, stamp, stream.last_stamp)
        if refusal is not None:
            return refusal
        if not all(map(isfinite, values)):
            return f"{topic}: value is not finite"
        if stream.last_stamp is not None and stamp < stream.last_stamp:
            stream.epoch += 1
            stream.apart_since = self._newest if stream.epoch != self._epoch else None
        stream.last_stamp = stamp
        stream.samples.append(((stream.epoch, stamp), values))
        return None

    def ready(self) -> Iterator[AlignedSample[Payload]]:
        """Yield the samples that are complete, or whose deadline has passed."""
        while self._pending:
            key, payload, rewound = self._pending[0]
            if not self._overdue(key) and not all(stream.has_reached(key) for stream in self._streams.values()):
                return
            self._pending.popleft()
            values: dict[str, tuple[float, ...]] = {}
            missing: dict[str, str] = {}
            for topic, stream in self._streams.items():
                found = stream.at(key)
                if isinstance(found, str):
                    missing[topic] = found
                else:
                    values[topic] = found
            yield AlignedSample(key[1], payload, values, missing, rewound)

    def reset(self) -> None:
        """Forget every sample and every stamp."""
        self._pending.clear()
        self._newest = None
        self._epoch = 0
        for topic, stream in self._streams.items():
            self._streams[topic] = _Stream(stream.declared)

    def _overdue(self, key: Key) -> bool:
        epoch, stamp = key
        waiting_since = stamp if epoch == self._epoch else self._epoch_start
        return self._newest is not None and self._newest - waiting_since >= self._deadline_ns

    def _rejoin(self, stream: _Stream) -> None:
        """A stream that jumped alone (or did not follow a jump) belongs to the primary's present again."""
        stream.samples.clear()
        stream.epoch = self._epoch
        stream.last_stamp = None
        stream.apart_since = None


def _refuse_stamp(topic: str, stamp: int, last: int | None) -> str | None:
    if stamp <= 0:
        return f"{topic}: stamp is zero"
    if stamp == last:
        return f"{topic}: stamp repeats"
    return None
