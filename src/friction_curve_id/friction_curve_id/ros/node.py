"""Node friction_curve_id: its processors behind ROS topics."""

from collections.abc import Sequence

from friction_curve_id.parameters import FrictionCurveParameters
from friction_curve_id.ros.processor import build
from friction_runtime.processor_node import Connect, ProcessorNode, subscribe_to_all
from friction_runtime.spin import run


def make_node(connect: Connect = subscribe_to_all) -> ProcessorNode[FrictionCurveParameters]:
    """Make the node, whose inputs come by `connect`; rclpy is initialised."""
    return ProcessorNode("friction_curve_id", FrictionCurveParameters, build, connect)


def main(args: Sequence[str] | None = None) -> int:
    """Run until a signal; return the exit code."""
    return run("friction_curve_id", FrictionCurveParameters, make_node, args)
