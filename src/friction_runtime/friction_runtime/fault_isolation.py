"""Fault isolation of a processor: an exception in one wheel's estimate affects neither node nor other wheels."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from traceback import extract_tb
from typing import Any

from friction_runtime.messages import to_nanoseconds
from friction_runtime.processor import CommandingProcessor, Health, Level, Output, Processor, Report


class FaultIsolatedProcessor:
    """Hands messages to one processor. Where it raises, its brake goes back to the driver and it starts again."""

    def __init__(self, processor: Processor, report: Report) -> None:
        """Wrap a processor; `report` takes one line for each exception."""
        self.processor = processor
        self._report = report
        self._defects = 0
        self._last = ""

    def process(self, topic: str, message: Any) -> Sequence[Output]:
        """Take one message; return the resulting outputs."""
        try:
            return self.processor.process(topic, message)
        except Exception as defect:
            return self._start_again(f"{topic} at stamp {_stamp(message)} ns", defect)

    def watch(self, ages: Mapping[str, float], now: float) -> Sequence[Output]:
        """Act on silence."""
        try:
            return self.processor.watch(ages, now)
        except Exception as defect:
            return self._start_again("watch of the inputs", defect)

    def reset(self) -> None:
        """Start again, and count defects from zero."""
        self._defects = 0
        self._last = ""
        self.processor.reset()

    def health(self) -> Health:
        """State for diagnostics: ERROR from the first exception until a reset."""
        health = self.processor.health()
        if not self._defects:
            return health
        return Health(health.name, Level.ERROR, self._last, {**health.values, "exceptions": str(self._defects)})

    def _start_again(self, where: str, defect: Exception) -> Sequence[Output]:
        self._defects += 1
        frame = extract_tb(defect.__traceback__)[-1]
        place = f"{Path(frame.filename).name}:{frame.lineno}"
        self._last = f"defect: {where}: {type(defect).__name__}: {defect} ({place}); starts again"
        self._report("error", self._last)
        outputs = self.processor.hand_over() if isinstance(self.processor, CommandingProcessor) else []
        self.processor.reset()
        return outputs


def _stamp(message: Any) -> int:
    return to_nanoseconds(message.header.stamp) if hasattr(message, "header") else 0
