"""Messages between readers of the same topics: who gets what, in which order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from friction_runtime.processor import Output, ProcessorGraph


class Told:
    """Notes what it is told, and answers one topic on others."""

    def __init__(
        self, name: str, log: list[tuple[str, str]], sensors: Sequence[str], answers: Mapping[str, Any]
    ) -> None:
        self.sensors: Mapping[str, type] = dict.fromkeys(sensors, int)
        self.estimates: Mapping[str, type] = {}
        self._name, self._log, self._answers = name, log, answers

    def process(self, topic: str, message: Any) -> Sequence[Output]:
        """Answer."""
        self._log.append((self._name, topic))
        return [(answer, message) for answer in self._answers.get(topic, ())]


def test_all_take_a_message_in_their_order_before_any_output_is_handed_on() -> None:
    log: list[tuple[str, str]] = []
    slip = Told("slip", log, ["wheel"], {"wheel": ("left", "right")})
    slope = Told("slope", log, ["left", "wheel", "right"], {"left": ("sign",)})
    curve = Told("curve", log, ["right", "wheel"], {})
    given = ProcessorGraph([slip, slope, curve]).feed("wheel", 1)
    assert log == [
        *(("slip", "wheel"), ("slope", "wheel"), ("curve", "wheel")),
        *(("slope", "left"), ("slope", "right"), ("curve", "right")),
    ]
    assert given == [("left", 1), ("right", 1), ("sign", 1)]


def test_what_nobody_takes_is_left_aside() -> None:
    log: list[tuple[str, str]] = []
    assert ProcessorGraph([Told("slip", log, ["wheel"], {})]).feed("imu", 1) == []
    assert log == []
