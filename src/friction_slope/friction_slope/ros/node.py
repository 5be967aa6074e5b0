"""Node friction_slope: one processor per wheel."""

from collections.abc import Sequence

from friction_runtime.processor_node import Connect, ProcessorNode, subscribe_to_all
from friction_runtime.spin import run
from friction_slope.parameters import FrictionSlopeParameters
from friction_slope.ros.processor import build

_NAME = "friction_slope"


def make_node(connect: Connect = subscribe_to_all) -> ProcessorNode[FrictionSlopeParameters]:
    """Make the node, whose inputs come by `connect`; rclpy is initialised."""
    return ProcessorNode(_NAME, FrictionSlopeParameters, build, connect)


def main(args: Sequence[str] | None = None) -> int:
    """Run until a signal; return the exit code."""
    return run(_NAME, FrictionSlopeParameters, make_node, args)
