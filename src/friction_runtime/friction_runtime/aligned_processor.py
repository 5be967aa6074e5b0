"""Shared behaviour of processors with several inputs: align, refuse, start again, notice silence."""

from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping, Sequence
from math import inf
from typing import Any, Final, Generic, TypeVar

from friction_runtime.aligner import AlignedInput, AlignedSample, Aligner
from friction_runtime.messages import to_nanoseconds
from friction_runtime.processor import Health, Level, Output, Report
from vehicle_models.nanoseconds import NANOSECONDS

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


Payload = TypeVar("Payload")


class AlignedProcessor(ABC, Generic[Payload]):
    """A processor that fires for each sample of its primary, once the other inputs have reached its stamp.

    A subclass defines how messages are read (`_payload`, `_take`), what is estimated for a sample (`_fire`), what is
    forgotten (`_forget`, `_start_again`), and what diagnostics show (`_state`, `_values`).
    """

    sensors: Mapping[str, type]
    """Relative topics and types of the inputs with sensor QoS; set by the subclass, as are the estimates."""
    estimates: Mapping[str, type]
    """Relative topics and types of the inputs with reliable QoS."""

    def __init__(
        self,
        name: str,
        primary: Primary,
        aligned: Sequence[AlignedInput],
        deadline: float,
        optional: Collection[str] = (),
    ) -> None:
        """Connect the inputs.

        Args:
            name: the wheel, or whatever else is estimated.
            primary: the stream whose samples trigger an estimate.
            aligned: inputs that are interpolated to the primary.
            deadline: message time [s] a primary sample waits for the others, > 0.
            optional: inputs that may never come, and are no fault then.
        """
        self.optional = optional
        self._name = name
        self._primary = primary
        self._aligner: Aligner[Payload] = Aligner(primary.topic, aligned, deadline)
        self._fired = False
        self._silent: dict[str, float] = {}
        self._stamp_fired = 0
        self._missing_since: dict[str, tuple[int, str]] = {}
        """Inputs that were missing at the last sample: since when [ns], and why."""

    def process(self, topic: str, message: Any) -> Sequence[Output]:
        """Take one message; return the resulting outputs."""
        if topic == self._primary.topic:
            refusal = self._aligner.offer_primary(to_nanoseconds(message.header.stamp), self._payload(message))
        else:
            refusal = self._take(topic, message)
        if refusal is not None:
            self._primary.refuse(refusal)
        outputs: list[Output] = []
        for sample in self._aligner.ready():
            if sample.rewound:
                self._primary.jumped_back()
                self._start_again(sample.stamp)
            self._fired = True
            self._stamp_fired = sample.stamp
            if sample.missing or self._missing_since:
                self._note_missing(sample)
            outputs += self._fire(sample)
        return outputs

    def watch(self, ages: Mapping[str, float], now: float) -> Sequence[Output]:
        """Note silence of the inputs for diagnostics. Nothing is published: without a sample there is no stamp."""
        self._primary.watch(ages)
        self._silent = {
            topic: ages[topic]
            for inputs in (self.sensors, self.estimates)
            for topic in inputs
            if ages.get(topic, 0.0) > SILENT_AFTER and topic not in self.optional
        }
        return []

    def reset(self) -> None:
        """Start again, as after construction."""
        self._aligner.reset()
        self._fired = False
        self._missing_since = {}
        self._forget()

    def health(self) -> Health:
        """State for diagnostics."""
        values = self._values()
        for topic, count in self._aligner.late().items():
            values[f"{topic} late samples"] = str(count)
        if self._primary.silence or not self._fired:
            text = self._primary.silence or f"{self._primary.topic}: no sample yet"
            return Health(self._name, Level.ERROR, text, values)
        level, text = self._state()
        # What the estimator can do without is degraded all the same; a state that names the topic has said so.
        lost = {topic: silence(topic, age) for topic, age in self._silent.items()}
        for topic, (since, why) in self._missing_since.items():
            if abs(self._stamp_fired - since) >= SILENT_AFTER * NANOSECONDS and topic not in self.optional:
                lost[topic] = why
        unnamed = [why for topic, why in lost.items() if topic not in text]
        if unnamed:
            level, text = max(level, Level.WARN), "; ".join([text, *unnamed] if text else unnamed)
        return Health(self._name, level, text or "ok", values)

    def _note_missing(self, sample: AlignedSample[Payload]) -> None:
        before = self._missing_since
        self._missing_since = {
            topic: (before[topic][0] if topic in before else sample.stamp, why) for topic, why in sample.missing.items()
        }

    @abstractmethod
    def _payload(self, message: Any) -> Payload:
        """Return the payload of a message of the primary."""

    @abstractmethod
    def _take(self, topic: str, message: Any) -> str | None:
        """Take a message of another input, mostly to the aligner; return why it is refused."""

    @abstractmethod
    def _fire(self, sample: AlignedSample[Payload]) -> list[Output]:
        """Estimate at the stamp of a sample."""

    @abstractmethod
    def _forget(self) -> None:
        """Forget everything: a reset was requested."""

    @abstractmethod
    def _start_again(self, stamp: int) -> None:
        """Forget what lies before a jump back in time, to `stamp` [ns]. The aligner keeps the inputs."""

    @abstractmethod
    def _state(self) -> tuple[Level, str]:
        """Level and text for diagnostics, after at least one sample; the text is empty where all is well."""

    @abstractmethod
    def _values(self) -> dict[str, str]:
        """Values for diagnostics."""
