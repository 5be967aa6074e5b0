"""One lap of the car as the topics show it: stamps and times of publication, what is missing, how late answers are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


@dataclass
class Seen:
    """First publication [ns, wall clock] of each stamp [ns] of one topic: a command is repeated as a heartbeat."""

    since: int
    """What was published before [ns, wall clock] belongs to the lap before, whose stamps were the same."""
    published: dict[int, int] = field(default_factory=dict)

    def note(self, stamp: int, at: int) -> None:
        """Take one message."""
        if at >= self.since:
            self.published.setdefault(stamp, at)


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
    asked = {stamp: at for stamp, at in sent.published.items() if stamp >= begin}
    delays = [topic.published[stamp] - at for stamp, at in asked.items() if topic.published.get(stamp, 0) >= at]
    return Answers(len(asked), len(asked) - len(delays), np.array(delays, dtype=float) * 1e-6)


def together(parts: Sequence[Answers]) -> Answers:
    """Return the answers in several laps, at least one, as those of one."""
    delays = np.concatenate([part.delays for part in parts])
    return Answers(sum(part.samples for part in parts), sum(part.lost for part in parts), delays)
