"""The estimators in one process, each under the name of its own node; abs_supervisor stays a process of its own."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module

from rclpy.executors import Executor

from friction_bringup import graph
from friction_runtime.connected_nodes import ConnectedNodes
from friction_runtime.processor_node import ProcessorNode
from friction_runtime.spin import run_nodes


def run_composed(arguments: Sequence[str]) -> int:
    """Run the estimators until a signal.

    Args:
        arguments: of ROS; a rule for one of the nodes begins with its name, as in wheel_slip:__node:=my_slip.

    Returns:
        Exit code: 0, or 2 when an argument, a parameter or a file is bad (which is printed in one line).
    """
    classes = {name: graph.parameter_class(name) for name in graph.COMPOSED}
    return run_nodes(classes, _make_nodes, arguments)


def _make_nodes(executor: Executor) -> list[ProcessorNode]:
    return ConnectedNodes(executor, [import_module(f"{name}.node").make_node for name in graph.COMPOSED]).nodes
