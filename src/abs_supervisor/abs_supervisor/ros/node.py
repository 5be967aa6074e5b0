"""Node abs_supervisor: one processor per wheel."""

from collections.abc import Sequence

from abs_supervisor.parameters import SupervisorParameters
from abs_supervisor.ros.processor import build
from friction_runtime.processor_node import ProcessorNode
from friction_runtime.spin import run

_NAME = "abs_supervisor"


def make_node() -> ProcessorNode[SupervisorParameters]:
    """Make the node; rclpy is initialised."""
    return ProcessorNode(_NAME, SupervisorParameters, build)


def main(args: Sequence[str] | None = None) -> int:
    """Run until a signal; return the exit code."""
    return run(_NAME, SupervisorParameters, make_node, args)
