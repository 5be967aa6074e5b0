"""Node friction_slope: one processor per wheel."""

from collections.abc import Sequence

from friction_runtime.processor_node import ProcessorNode
from friction_runtime.spin import run
from friction_slope.parameters import FrictionSlopeParameters
from friction_slope.processor import build

_NAME = "friction_slope"


def make_node() -> ProcessorNode[FrictionSlopeParameters]:
    """Make the node; rclpy is initialised."""
    return ProcessorNode(_NAME, FrictionSlopeParameters, build)


def main(args: Sequence[str] | None = None) -> int:
    """Run until a signal; return the exit code."""
    return run(_NAME, FrictionSlopeParameters, make_node, args)
