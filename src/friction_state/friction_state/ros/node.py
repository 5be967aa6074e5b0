"""Node friction_state: one processor for the vehicle."""

from collections.abc import Sequence

from friction_runtime.processor_node import Connect, ProcessorNode, subscribe_to_all
from friction_runtime.spin import run
from friction_state.parameters import FrictionStateParameters
from friction_state.ros.processor import build

_NAME = "friction_state"


def make_node(connect: Connect = subscribe_to_all) -> ProcessorNode[FrictionStateParameters]:
    """Make the node, whose inputs come by `connect`; rclpy is initialised."""
    return ProcessorNode(_NAME, FrictionStateParameters, build, connect)


def main(args: Sequence[str] | None = None) -> int:
    """Run until a signal; return the exit code."""
    return run(_NAME, FrictionStateParameters, make_node, args)
