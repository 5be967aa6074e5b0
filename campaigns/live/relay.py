"""Nodes of the graph, each replaced by one that only answers: what remains is the cost of the transport.

One that is named, in a process of its own; none: the estimators in one process.

python3 -m campaigns.live.relay [NODE] --ros-args -p vehicle_file:=compact_car
"""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Any

from friction_bringup import graph
from friction_bringup.composed import run
from friction_runtime.processor import Health, Output, Processor

_CHAIN = ("wheel_states", "slip", "slope_vote")
"""From the sensors to the supervisor, each after the one before."""
_BLOCKS_OF_A_REVOLUTION = 15
"""Tyre blocks of 5 ms in a revolution at 27 m/s."""


class Relay:
    """Has the topics of a processor, and answers the messages that this one fires on with the same message again."""

    def __init__(self, processor: Processor) -> None:
        """Take the place of a processor."""
        self.sensors: Mapping[str, type] = processor.sensors
        self.estimates: Mapping[str, type] = processor.estimates
        self.optional = processor.optional
        self.outputs: Mapping[str, type] = processor.outputs
        self._answers = {topic: kind() for topic, kind in processor.outputs.items()}
        self._blocks = 0

    def process(self, topic: str, message: Any) -> Sequence[Output]:
        """Answer for the wheel of the topic, or for all wheels where the topic is of the car."""
        wheel, _, what = topic.rpartition("/")
        if what not in _CHAIN and what != "tyre_signals":
            return ()
        later = {name for topic in self.estimates for name in _CHAIN if topic.endswith(f"/{name}")}
        if what in _CHAIN and later.intersection(_CHAIN[_CHAIN.index(what) + 1 :]):
            return ()  # what it waits for comes later
        if what == "tyre_signals":
            self._blocks += 1
            if self._blocks % _BLOCKS_OF_A_REVOLUTION:
                return ()
        answers = [(name, each) for name, each in self._answers.items() if name.startswith(f"{wheel}/") or not wheel]
        for _, answer in answers:
            answer.header.stamp = message.header.stamp
        return answers

    def watch(self, ages: Mapping[str, float], now: float) -> Sequence[Output]:
        """Do nothing."""
        return ()

    def reset(self) -> None:
        """Do nothing."""

    def health(self) -> Health:
        """Report nothing."""
        return Health("relay")


def _relays(build: Callable[..., Sequence[Processor]]) -> Callable[..., list[Relay]]:
    return lambda *arguments: [Relay(each) for each in build(*arguments)]


def main() -> int:
    """Run until a signal; return the exit code."""
    named = sys.argv[1:2] if sys.argv[1:2] != ["--ros-args"] else []
    for name in named or graph.COMPOSED:
        module: Any = import_module(f"{name}.ros.node")
        module.build = _relays(module.build)
    if not named:
        return run(Namespace(), sys.argv[1:])
    code: int = module.main(sys.argv[2:])
    return code


if __name__ == "__main__":
    sys.exit(main())
