"""One lap of the car as the topics show it: stamps and times of publication, what is missing, how late answers are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


@dataclass
class Seen:
    """Publications [ns, wall clock] of each stamp [ns] of one topic: a command is repeated as a heartbeat."""

    published: dict[int, list[int]] = field(default_factory=dict)

    def note(self, stamp: int, at: int) -> None:
        """Take one message."""
        self.published.setdefault(stamp, []).append(at)

    def answer(self, stamp: int, asked: int) -> int | None:
        """Return the first publication [ns] of a stamp since it was asked for [ns], None where there is none.

        What was published before answers the same stamp of the lap before.
        """
        return min((at for at in self.published.get(stamp, ()) if at >= asked), default=None)


@dataclass(frozen=True)
class Answers:
    """What one topic had to say to the samples of a lap."""

    samples: int
    """Samples that were to be answered."""
    lost: int
    """Those that were not."""
    delays: NDArray[np.float64]
    """From the publication of a sample to that of its answer [ms], shape (answers,)."""


def answers(sent: Seen, topic: Seen, begin: int) -> Answers:
    """Compare a topic with wheel_states.

    Args:
        sent: wheel_states.
        topic: what answers it.
        begin: first stamp that is to be answered [ns].
    """
    asked = {stamp: at[0] for stamp, at in sent.published.items() if stamp >= begin}
    first = {stamp: topic.answer(stamp, at) for stamp, at in asked.items()}
    delays = [at - asked[stamp] for stamp, at in first.items() if at is not None]
    return Answers(len(asked), len(asked) - len(delays), np.array(delays, dtype=float) * 1e-6)


def together(parts: Sequence[Answers]) -> Answers:
    """Return the answers in several laps, at least one, as those of one."""
    delays = np.concatenate([part.delays for part in parts])
    return Answers(sum(part.samples for part in parts), sum(part.lost for part in parts), delays)
