"""Shared behaviour of all processors: refusals, jumps back, silence, levels in diagnostics, names of wheels once."""

from collections.abc import Sequence
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from builtin_interfaces.msg import Time
from friction_msgs.msg import (
    BrakeDemand,
)
from std_msgs.msg import Header

import friction_runtime
from friction_runtime.aligned_processor import Primary
from friction_runtime.aligner import AlignedInput, AlignedSample
from friction_runtime.messages import to_nanoseconds, validity
from friction_runtime.processor import Level, Output, Severity, level_of
from friction_runtime.reports import of_topic, of_wheel, without_wheel
from vehicle_models.physical_bounds import NEW_RUN
from vehicle_models.reason import Reason

if TYPE_CHECKING:
    from friction_runtime.aligned_processor import AlignedProcessor
else:
    # From its source: a class of a test cannot inherit from a compiled one.
    loader = SourceFileLoader("aligned_source", str(Path(friction_runtime.__file__).with_name("aligned_processor.py")))
    source = module_from_spec(spec_from_loader("aligned_source", loader))
    loader.exec_module(source)
    AlignedProcessor = source.AlignedProcessor


class Adder(AlignedProcessor[float]):
    """Adds an aligned input to its primary."""

    def __init__(self) -> None:
        """Start empty."""
        self.said: list[tuple[str, str]] = []
        self.sensors = {"FL/a": BrakeDemand, "FL/b": BrakeDemand}
        self.estimates = {}
        super().__init__("FL", Primary("FL/a", "FL", self._say), [AlignedInput("FL/b")], deadline=0.05)
        self.restarts: list[int] = []
        self.resets = 0

    def _say(self, severity: Severity, text: str) -> None:
        self.said.append((severity, text))

    def _payload(self, message: BrakeDemand) -> float:
        return float(message.pressure)

    def _take(self, topic: str, message: BrakeDemand) -> str | None:
        if message.pressure < 0.0:
            return f"{topic}: {message.pressure} Pa is negative"
        return self._aligner.offer(topic, to_nanoseconds(message.header.stamp), (message.pressure,))

    def _fire(self, sample: AlignedSample[float]) -> list[Output]:
        values = sample.values.get("FL/b")
        return [("FL/sum", (sample.stamp, None if values is None else sample.payload + values[0]))]

    def _forget(self) -> None:
        self.resets += 1

    def _start_again(self, stamp: int) -> None:
        self.restarts.append(stamp)

    def _state(self) -> tuple[Level, str]:
        return Level.OK, ""

    def _values(self) -> dict[str, str]:
        return {"resets": str(self.resets)}


def at(stamp: int, value: float = 1.0) -> BrakeDemand:
    return BrakeDemand(header=Header(stamp=Time(sec=0, nanosec=stamp)), pressure=value)


def outputs(found: Sequence[Output]) -> list[tuple[int, float | None]]:
    return [answer for _, answer in found]


def test_a_sample_fires_once_the_other_input_has_reached_it() -> None:
    adder = Adder()
    assert adder.process("FL/a", at(10, 2.0)) == []
    assert outputs(adder.process("FL/b", at(10, 3.0))) == [(10, 5.0)]
    assert adder.said == []


def test_refusals_are_warnings_that_name_the_topic() -> None:
    adder = Adder()
    adder.process("FL/a", at(0))
    adder.process("FL/b", at(10, -2.0))
    assert adder.said == [
        ("warning", "FL/a: stamp is zero: refused"),
        ("warning", "FL/b: -2.0 Pa is negative: refused"),
    ]


def test_a_jump_back_is_information_and_starts_the_estimator_again_before_it_fires() -> None:
    adder = Adder()
    for stamp in (10 + NEW_RUN, 10):
        adder.process("FL/b", at(stamp))
        adder.process("FL/a", at(stamp))
    assert adder.restarts == [10]
    assert adder.said == [("info", "FL/a: stamps jumped back, FL starts again")]


def test_health_tells_silence_a_first_sample_that_is_missing_and_the_state() -> None:
    adder = Adder()
    assert (adder.health().level, adder.health().message) == (Level.ERROR, "FL/a: no sample yet")
    adder.watch({"FL/a": inf}, 0.0)
    assert (adder.health().level, adder.health().message) == (Level.ERROR, "FL/a: no message yet")
    adder.watch({"FL/a": 0.0}, 0.0)
    adder.process("FL/a", at(10))
    adder.process("FL/b", at(10))
    assert (adder.health().level, adder.health().message) == (Level.OK, "ok")
    adder.watch({"FL/a": 0.26}, 0.0)
    assert (adder.health().level, adder.health().message) == (Level.ERROR, "FL/a: no message for 0.26 s")
    assert adder.health().values == {"resets": "0"}
    adder.watch({"FL/a": 0.0}, 0.0)
    adder.reset()
    assert adder.health().message == "FL/a: no sample yet"
    assert adder.health().values == {"resets": "1"}


def test_late_samples_are_refused_and_counted_in_diagnostics() -> None:
    adder = Adder()
    for stamp in (10_000_000, 3_000_000):
        adder.process("FL/b", at(stamp))
        adder.process("FL/a", at(stamp))
    assert adder.restarts == []
    assert adder.said == [
        ("warning", "FL/b: late sample, 0.0070 s before the newest: refused"),
        ("warning", "FL/a: late sample, 0.0070 s before the newest: refused"),
    ]
    assert adder.health().values == {"resets": "0", "FL/a late samples": "1", "FL/b late samples": "1"}


def test_health_names_another_input_that_is_silent_though_the_estimator_goes_on() -> None:
    adder = Adder()
    for topic in ("FL/a", "FL/b"):
        adder.process(topic, at(10))
    adder.watch({"FL/a": 0.0, "FL/b": 0.2}, 0.0)
    assert adder.health().level is Level.OK
    adder.watch({"FL/a": 0.0, "FL/b": 0.3}, 0.0)
    assert (adder.health().level, adder.health().message) == (Level.WARN, "FL/b: no message for 0.30 s")
    adder.watch({"FL/a": 0.0, "FL/b": inf}, 0.0)
    assert (adder.health().level, adder.health().message) == (Level.WARN, "FL/b: no message yet")
    adder.optional = ("FL/b",)
    adder.watch({"FL/a": 0.0, "FL/b": inf}, 0.0)
    assert adder.health().level is Level.OK


def test_an_optional_primary_that_never_came_is_not_silent() -> None:
    primary = Primary("FL/tyre_signals", "FL", lambda _severity, _text: None, optional=True)
    primary.watch({"FL/tyre_signals": inf})
    assert primary.silence == ""
    primary.watch({"FL/tyre_signals": 0.3})
    assert primary.silence == "FL/tyre_signals: no message for 0.30 s"


def test_levels_follow_from_reasons_that_are_ordinary_or_cannot_be_cured() -> None:
    assert [level_of(reason, (0, 1), (2,)) for reason in range(4)] == [Level.OK, Level.OK, Level.ERROR, Level.WARN]


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("", ""),
        ("gap", "FL: gap"),
        ("FL: gap", "FL: gap"),
        ("FL/slip: gap", "FL/slip: gap"),
        ("FLX/slip: gap", "FL: FLX/slip: gap"),
        ("imu/data: silent", "FL: imu/data: silent"),
    ],
)
def test_a_reason_names_its_wheel_once(text: str, named: str) -> None:
    assert of_wheel("FL", text) == named


def test_a_reason_passed_on_names_topic_and_wheel_once() -> None:
    slope = of_wheel("FL", of_topic("FL/slip", "FL: no vehicle speed"))
    assert slope == "FL/slip: no vehicle speed"
    assert of_wheel("FL", of_topic("FL/friction_slope", "FL: gap")) == "FL/friction_slope: gap"
    assert without_wheel("FL", "FL: gap") == "gap"


def test_validity_follows_from_the_reason_and_names_the_wheel() -> None:
    made = validity("FL", Reason.OK, "")
    assert (made.valid, made.reason, made.text) == (True, 0, "")
    made = validity("FL", Reason.BAD_INPUT, "why")
    assert (made.valid, made.reason, made.text) == (False, Reason.BAD_INPUT, "FL: why")
