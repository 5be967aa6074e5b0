"""Node friction_grip: one processor for the vehicle."""

from collections.abc import Sequence

from friction_grip.parameters import FrictionGripParameters
from friction_grip.ros.processor import build
from friction_runtime.processor_node import Connect, ProcessorNode, subscribe_to_all
from friction_runtime.spin import run

_NAME = "friction_grip"


def make_node(connect: Connect = subscribe_to_all) -> ProcessorNode[FrictionGripParameters]:
    """Make the node, whose inputs come by `connect`; rclpy is initialised."""
    return ProcessorNode(_NAME, FrictionGripParameters, build, connect)


def main(args: Sequence[str] | None = None) -> int:
    """Run until a signal; return the exit code."""
    return run(_NAME, FrictionGripParameters, make_node, args)
