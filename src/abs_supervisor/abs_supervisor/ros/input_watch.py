"""Input monitor of a commanding supervisor: progress of the stamps against the steady clock.

The supervisor listens to the sensors themselves, not only to what becomes of them in a vote: so a lost sensor is
known within 50 ms and its own period, however long the nodes between wait for each other.
"""

from collections.abc import Mapping
from math import inf
from typing import Final

from friction_runtime.stamp_progress import LAG, StampProgress
from friction_runtime.wheel_inputs import WHEEL_STATES
from vehicle_models.reason import Reason

_HEARTBEAT: Final = 0.009
"""A command is repeated when the last is older at a watch [s]: the watch comes every 10 ms, a command every 20 ms."""
Loss = tuple[Reason, str]
"""Why the supervisor may not act, and the text that names the topic."""


class InputWatch:
    """Follows wheel speed, pressure, demand and vote of one wheel: `note` good messages, `poll` with the clock."""

    def __init__(self, pressure: str, demand: str, vote: str) -> None:
        """Choose the topics of the wheel's pressure, of the demand and of the wheel's vote."""
        self._vote = vote
        # In the order in which they are named: the loss of a sensor brings that of the vote.
        self._reasons = {
            WHEEL_STATES: Reason.NO_WHEEL_SPEED,
            pressure: Reason.NO_PRESSURE,
            demand: Reason.NO_PRESSURE if demand == pressure else Reason.NO_DEMAND,
            vote: Reason.NO_SLOPE,
        }
        self._inputs = {topic: StampProgress() for topic in self._reasons}
        self.loss: Loss | None = None
        """The first input that is lost, at the last poll; None where all are there, and before the first poll."""

    def note(self, topic: str, stamp: int) -> None:
        """Take the stamp [ns] of a message whose content is good; one that is refused is no progress."""
        progress = self._inputs.get(topic)
        if progress is not None:
            progress.note(stamp)

    def poll(self, ages: Mapping[str, float], now: float) -> Loss | None:
        """Look at the clock: `ages` of the topics and time `now` of Processor.watch; return `loss`."""
        self.loss = None
        for topic, progress in self._inputs.items():
            if progress.poll(now, ages.get(topic, inf)) and self.loss is None:
                self.loss = self._reasons[topic], _text(topic, progress, ages.get(topic, inf))
        if self.loss is None:
            self.loss = self._apart()
        return self.loss

    def _apart(self) -> Loss | None:
        """Return the loss of an input whose clock is not that of the others: samples of different times are no pair.

        Each alone may be steady: one that was set takes up a new reference.
        """
        references = {topic: each.reference for topic, each in self._inputs.items() if each.reference is not None}
        ahead = min(references, key=lambda topic: references[topic])
        for topic, reference in references.items():
            behind = reference - references[ahead]
            if behind > LAG:
                return self._reasons[topic], f"{topic}: stamps are {behind:.3f} s behind those of {ahead}"
        return None

    def is_old(self, stamp: int) -> bool:
        """Whether a vote with this stamp [ns] waited in a queue for so long that no answer is of use any more."""
        return self._inputs[self._vote].is_old(stamp)

    def wants_heartbeat(self, ages: Mapping[str, float], commanded: bool) -> bool:
        """Whether the last command is to be repeated; `commanded`: there was one since the last poll."""
        return not commanded or ages.get(self._vote, inf) > _HEARTBEAT


def _text(topic: str, progress: StampProgress, age: float) -> str:
    if not progress.came:
        return f"{topic}: no message yet"
    if age > 2.0 * progress.period:
        return f"{topic}: no message for {age:.3f} s"
    if progress.lag > progress.period:
        return f"{topic}: newest good stamp is {progress.lag:.3f} s behind the clock"
    return f"{topic}: stamps do not progress with the clock yet"
