"""Node wheel_slip: one processor for the car."""

from collections.abc import Sequence

from friction_runtime.processor_node import Connect, ProcessorNode, subscribe_to_all
from friction_runtime.spin import run
from wheel_slip.parameters import WheelSlipParameters
from wheel_slip.ros.processor import build


def make_node(connect: Connect = subscribe_to_all) -> ProcessorNode[WheelSlipParameters]:
    """Make the node, whose inputs come by `connect`; rclpy is initialised."""
    return ProcessorNode("wheel_slip", WheelSlipParameters, build, connect)


def main(args: Sequence[str] | None = None) -> int:
    """Run until a signal; return the exit code."""
    return run("wheel_slip", WheelSlipParameters, make_node, args)
