"""The stream a processor fires on, and what every processor says of it alike: refusals, jumps back, silence."""

from collections.abc import Mapping
from math import inf

from friction_runtime.processor import Report

_SILENT_AFTER = 0.25
"""[s]"""


class Primary:
    """Topic without which a processor gives nothing."""

    def __init__(
        self,
        topic: str,
        name: str,
        report: Report,
        silent_after: float = _SILENT_AFTER,
        optional: bool = False,
    ) -> None:
        """Choose the topic.

        Args:
            topic: relative name.
            name: of the processor: a wheel, or what it estimates for.
            report: takes what a person should know.
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
        """Note silence for diagnostics; `ages` [s] of the topics, inf before the first message."""
        age = ages.get(self.topic, 0.0)
        if age == inf:
            self.silence = "" if self._optional else f"{self.topic}: no message yet"
        else:
            self.silence = f"{self.topic}: no message for {age:.2f} s" if age > self._silent_after else ""

    def refuse(self, reason: str) -> None:
        """Say that a message is refused, of this topic or of another input: `reason` names it."""
        self._report("warning", f"{reason}: refused")

    def jumped_back(self) -> None:
        """Say that the estimator starts again because the stamps went back: a looped bag or a reset plant."""
        self._report("info", f"{self.topic}: stamps jumped back, {self._name} starts again")
