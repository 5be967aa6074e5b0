from collections.abc import Mapping, Sequence
from typing import Any

from friction_msgs.msg import BrakeDemand
from std_msgs.msg import Header

from friction_runtime.fault_isolation import FaultIsolatedProcessor
from friction_runtime.messages import from_nanoseconds
from friction_runtime.processor import CommandingProcessor, Health, Level, Output

TOPIC = "brake_demand"


class Estimator:
    """Counts what it takes, and raises at a negative pressure."""

    sensors: Mapping[str, type] = {TOPIC: BrakeDemand}
    estimates: Mapping[str, type] = {}
    optional = ()
    outputs: Mapping[str, type] = {"count": int}

    def __init__(self) -> None:
        self.count = 0

    def process(self, topic: str, message: Any) -> Sequence[Output]:
        self.count += 1
        if message.pressure < 0.0:
            raise ZeroDivisionError("pressure")
        return [("count", self.count)]

    def watch(self, ages: Mapping[str, float], now: float) -> Sequence[Output]:
        if now < 0.0:
            raise KeyError("ages")
        return []

    def reset(self) -> None:
        self.count = 0

    def health(self) -> Health:
        return Health("front_left", values={"count": str(self.count)})


class Supervisor(Estimator):
    """Has a brake to give back, and needs what it knows to say of which sample."""

    commands: Mapping[str, float] = {"brake_command": 0.1}

    acts = False

    def hand_over(self) -> Sequence[Output]:
        return [("brake_command", f"none after {self.count}")]


def demand(pressure: float) -> BrakeDemand:
    return BrakeDemand(header=Header(stamp=from_nanoseconds(7_000_000_001)), pressure=pressure)


def _never(severity: str, text: str) -> None:
    raise AssertionError(text)


def test_a_processor_that_never_raises_is_as_without_a_guard() -> None:
    isolated = FaultIsolatedProcessor(Estimator(), _never)
    assert [isolated.process(TOPIC, demand(1.0)) for _ in range(3)] == [[("count", n)] for n in (1, 2, 3)]
    assert isolated.watch({}, 0.0) == []
    assert isolated.health() == Health("front_left", values={"count": "3"})


def test_one_that_raises_starts_again_is_named_with_topic_and_stamp_and_counted() -> None:
    said: list[tuple[str, str]] = []
    isolated = FaultIsolatedProcessor(Estimator(), lambda severity, text: said.append((severity, text)))
    isolated.process(TOPIC, demand(1.0))
    assert isolated.process(TOPIC, demand(-1.0)) == []
    assert isolated.process(TOPIC, demand(1.0)) == [("count", 1)]
    assert isolated.watch({}, -1.0) == []
    ((severity, text), (_, watch)) = said
    assert severity == "error"
    assert all(part in text for part in (TOPIC, "7000000001", "ZeroDivisionError", "pressure", "fault_isolation.py:"))
    assert "KeyError" in watch
    health = isolated.health()
    assert (health.level, health.values["exceptions"]) == (Level.ERROR, "2")
    isolated.reset()
    assert isolated.health() == Health("front_left", values={"count": "0"})


def test_one_that_commands_gives_the_brake_back_before_it_forgets_what_it_commanded() -> None:
    supervisor = Supervisor()
    assert isinstance(supervisor, CommandingProcessor)
    isolated = FaultIsolatedProcessor(supervisor, lambda severity, text: None)
    isolated.process(TOPIC, demand(1.0))
    assert isolated.process(TOPIC, demand(-1.0)) == [("brake_command", "none after 2")]
    assert supervisor.count == 0
