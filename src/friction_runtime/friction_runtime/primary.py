"""The stream a processor fires on, and its reports, the same for every processor: refusals, jumps back, silence."""

from collections.abc import Mapping
from math import inf
from typing import Final

from friction_runtime.processor import Report

SILENT_AFTER: Final = 0.25
"""Age of the last message from which a topic counts as silent [s]."""


def silence(topic: str, age: float) -> str:
    """Return the report of a topic whose last message is `age` old [s], inf before the first."""
    return f"{topic}: no message yet" if age == inf else f"{topic}: no message for {age:.2f} s"


class Primary:
    """The topic whose samples trigger the estimates of a processor."""

    def __init__(
        self,
        topic: str,
        name: str,
        report: Report,
        silent_after: float = SILENT_AFTER,
        optional: bool = False,
    ) -> None:
        """Choose the topic.

        Args:
            topic: relative name.
            name: name of the processor: a wheel, or whatever else is estimated.
            report: log function.
            silent_after: age [s] of the last message from which the topic counts as silent.
            optional: whether it is no fault if no message ever comes.
        """
        self.topic = topic
        self.silence = ""
        """Why there is no message, empty as long as messages come."""
        self._name = name
        self._report = report
        self._silent_after = silent_after
        self._optional = optional

    def watch(self, ages: Mapping[str, float]) -> None:
        """Note silence for diagnostics; `ages` of the topics [s], inf before the first message."""
        age = ages.get(self.topic, 0.0)
        heard_of = age < inf or not self._optional
        self.silence = silence(self.topic, age) if heard_of and age > self._silent_after else ""

    def refuse(self, reason: str) -> None:
        """Report a refused message of this topic or of another input; `reason` names the topic."""
        self._report("warning", f"{reason}: refused")

    def jumped_back(self) -> None:
        """Report that the estimator starts again because the stamps went back: a looped bag or a reset plant."""
        self._report("info", f"{self.topic}: stamps jumped back, {self._name} starts again")
