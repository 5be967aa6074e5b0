"""The estimators in one process, one of them with a defect: python defective_graph.py raising|slow --ros-args ..."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module
from time import sleep
from typing import Any

from friction_bringup.__main__ import main
from friction_runtime.processor import Output

RAISES = (20, 40, 60)
"""Numbers of the samples at which the slope of the front left wheel raises."""
SLOW = 0.2
"""Time that one curve takes [s]."""


class Raising:
    """The slope's processor of one wheel, with a defect that shows at some samples."""

    def __init__(self, processor: Any) -> None:
        self._processor = processor
        self._samples = 0

    def __getattr__(self, name: str) -> Any:
        return getattr(self._processor, name)

    def process(self, topic: str, message: Any) -> Sequence[Output]:
        """Raise, or answer."""
        if topic == "wheel_states":
            self._samples += 1
            if self._samples in RAISES:
                raise ZeroDivisionError("a defect")
        outputs: Sequence[Output] = self._processor.process(topic, message)
        return outputs


class Slow:
    """The curve's processor of one wheel, on a machine that is far too slow for it."""

    def __init__(self, processor: Any) -> None:
        self._processor = processor

    def __getattr__(self, name: str) -> Any:
        return getattr(self._processor, name)

    def process(self, topic: str, message: Any) -> Sequence[Output]:
        """Answer late."""
        outputs: Sequence[Output] = self._processor.process(topic, message)
        sleep(SLOW if outputs else 0.0)
        return outputs


def _with_defect(kind: str) -> None:
    node: Any = import_module("friction_curve_id.ros.node" if kind == "slow" else "friction_slope.ros.node")
    build = node.build

    def build_defective(*arguments: Any) -> list[Any]:
        first, *others = build(*arguments)
        return [Slow(each) for each in (first, *others)] if kind == "slow" else [Raising(first), *others]

    node.build = build_defective


if __name__ == "__main__":
    _with_defect(sys.argv[1])
    sys.exit(main(["graph", *sys.argv[2:]]))
