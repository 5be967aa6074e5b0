"""A minimal node on friction_runtime, for the tests of its behaviour: the demand, multiplied, as a wheel's slip."""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from friction_msgs.msg import BrakeDemand, WheelSlip

from friction_parameters.parameter import group, parameter
from friction_runtime.processor import Health, Output, Report
from friction_runtime.processor_node import ProcessorNode
from friction_runtime.spin import run
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import vehicle_file_parameter

MUCH = 1e6
"""Demand [Pa] that is answered, with a warning."""
DEFECT = 1e300
"""Demand [Pa] at which the processor raises."""


@dataclass(frozen=True)
class FilterParameters:
    """Nested parameters."""

    offset: float = parameter(0.0, "added", minimum=-100.0, maximum=100.0)
    weights: tuple[float, ...] = parameter((1.0, 0.5), "of nothing", minimum=0.0)


@dataclass(frozen=True)
class MirrorParameters:
    """Parameters of one method."""

    factor: float = parameter(-1.0, "factor of the mirrored demand")


@dataclass(frozen=True)
class EchoParameters:
    """Parameters of the echo."""

    vehicle_file: str = vehicle_file_parameter("chapter_corner")
    gain: float = parameter(2.0, "factor", minimum=0.0, maximum=10.0)
    method: str = parameter("plain", "what is echoed", choices=("plain", "mirror"))
    filter: FilterParameters = group(FilterParameters())
    mirror: MirrorParameters = group(MirrorParameters(), selector="method", methods=("mirror",))


class Echo:
    """A processor with one input and one output, and two of each with method mirror."""

    def __init__(self, parameters: EchoParameters, vehicle: Vehicle, report: Report) -> None:
        """Take the first wheel."""
        if parameters.gain > 9.0 and parameters.method == "mirror":
            raise ValueError("parameter 'gain' is too much for a mirror")
        wheel = vehicle.wheel_names[0]
        factors = {"": parameters.gain}
        if parameters.method == "mirror":
            factors["mirrored_"] = parameters.gain * parameters.mirror.factor
        self._answers = {f"{name}brake_demand": (f"{wheel}/{name}slip", factor) for name, factor in factors.items()}
        self._offset = parameters.filter.offset
        self.sensors: Mapping[str, type] = dict.fromkeys(self._answers, BrakeDemand)
        self.estimates: Mapping[str, type] = {}
        self.optional = ("mirrored_brake_demand",)
        self.outputs: Mapping[str, type] = {topic: WheelSlip for topic, _ in self._answers.values()}
        self._count = 0
        self._report = report

    def process(self, topic: str, message: Any) -> list[Output]:
        """Multiply."""
        self._count += 1
        if message.pressure < 0.0:
            self._report("warning", f"{topic}: {message.pressure} Pa is negative: refused")
            return []
        if message.pressure >= DEFECT:
            raise OverflowError("too much")
        if message.pressure > MUCH:
            self._report("warning", f"{topic}: {message.pressure} Pa is much")
        output, factor = self._answers[topic]
        return [(output, WheelSlip(header=message.header, slip=factor * message.pressure + self._offset))]

    def watch(self, ages: Mapping[str, float], now: float) -> list[Output]:
        """Do nothing."""
        return []

    def reset(self) -> None:
        """Start to count again."""
        self._count = 0

    def health(self) -> Health:
        """Report the count."""
        return Health("echo", values={"count": str(self._count)})


def build(parameters: EchoParameters, vehicle: Vehicle, report: Report) -> Sequence[Echo]:
    """Make the processor."""
    return [Echo(parameters, vehicle, report)]


def main() -> int:
    """Run until a signal."""
    return run("echo", EchoParameters, lambda: ProcessorNode("echo", EchoParameters, build))


if __name__ == "__main__":
    sys.exit(main())
