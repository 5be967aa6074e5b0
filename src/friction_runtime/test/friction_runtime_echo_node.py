"""The smallest node of the shared kind, for the tests of its behaviour: doubles a wheel's speed."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from friction_msgs.msg import BrakeDemand, WheelSlip

from friction_runtime.parameters import parameter
from friction_runtime.processor import Health, Output
from friction_runtime.processor_node import ProcessorNode
from friction_runtime.spin import run


@dataclass(frozen=True)
class EchoParameters:
    """Parameters of the echo."""

    gain: float = parameter(2.0, "factor", minimum=0.0, maximum=10.0)
    wheel: str = parameter("front_left", "name", read_only=True)


class Echo:
    """A processor with one input and one output."""

    def __init__(self, parameters: EchoParameters) -> None:
        self._gain = parameters.gain
        self.sensors: Mapping[str, type] = {"brake_demand": BrakeDemand}
        self.estimates: Mapping[str, type] = {}
        self.outputs: Mapping[str, type] = {f"{parameters.wheel}/slip": WheelSlip}
        self._topic = f"{parameters.wheel}/slip"
        self._count = 0

    def process(self, topic: str, message: Any) -> list[Output]:
        """Multiply."""
        self._count += 1
        return [(self._topic, WheelSlip(header=message.header, slip=self._gain * message.pressure))]

    def watch(self, ages: Mapping[str, float]) -> list[Output]:
        """Stay calm."""
        return []

    def reset(self) -> None:
        """Count anew."""
        self._count = 0

    def health(self) -> Health:
        """Tell the count."""
        return Health("echo", values={"count": str(self._count)})


if __name__ == "__main__":
    raise SystemExit(run(lambda: ProcessorNode("echo", EchoParameters, lambda p, _report: [Echo(p)])))
