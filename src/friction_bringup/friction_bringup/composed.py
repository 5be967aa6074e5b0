"""The estimators in one process, each under the name of its own node; abs_supervisor stays a process of its own."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from importlib import import_module

from friction_bringup import graph
from friction_runtime.connected_nodes import ConnectedNodes
from friction_runtime.spin import run_nodes


def add_arguments(_: ArgumentParser) -> None:
    """There are none."""


def run(_: Namespace, arguments: Sequence[str]) -> int:
    """Run the estimators until a signal.

    Args:
        arguments: of ROS; a rule for one of the nodes begins with its name, as in wheel_slip:__node:=my_slip.

    Returns:
        Exit code: 0, or 2 when an argument, a parameter or a file is bad (which is printed in one line).
    """
    classes = {name: graph.parameter_class(name) for name in graph.COMPOSED}
    return run_nodes(classes, _connected_nodes, arguments)


def _connected_nodes() -> ConnectedNodes:
    return ConnectedNodes([import_module(f"{name}.ros.node").make_node for name in graph.COMPOSED])
