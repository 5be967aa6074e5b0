"""Launch actions of the graph, shared by the launch files. Needs launch_ros, so nothing else imports it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from launch import LaunchContext, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, LogInfo, Shutdown
from launch.events.process import ProcessExited
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.utilities.namespace_utils import prefix_namespace

from friction_adapter.map_file import map_choices
from friction_bringup import graph
from friction_bringup.node_start import Decided, composed_arguments, node_starts
from vehicle_models.vehicle_file import vehicle_choices


def common_arguments(params_file: str = "", vehicle_file: str = "") -> list[LaunchDescriptionEntity]:
    """Declare the common arguments of the launch files, with their defaults."""
    return [
        DeclareLaunchArgument(
            "vehicle_file",
            default_value=vehicle_file,
            description=f"the car: {vehicle_choices()}",
        ),
        DeclareLaunchArgument(
            "params_file",
            default_value=params_file,
            description="parameter file that overrides those of the packages",
        ),
        DeclareLaunchArgument("namespace", default_value="", description="namespace of all nodes and topics"),
        DeclareLaunchArgument(
            "use_sim_time",
            default_value="false",
            choices=["true", "false", "True", "False"],
            description="take the time from /clock",
        ),
        DeclareLaunchArgument(
            "respawn",
            default_value="false",
            choices=["true", "false", "True", "False"],
            description="start a process again that has ended",
        ),
        DeclareLaunchArgument(
            "log_level",
            default_value="info",
            choices=["debug", "info", "warn", "error", "fatal"],
            description="of every node",
        ),
    ]


def argument(context: LaunchContext, name: str) -> str:
    """Return the value of a launch argument."""
    return str(LaunchConfiguration(name).perform(context))


def uses_sim_time(context: LaunchContext) -> bool:
    """Return the launch argument use_sim_time."""
    return _is_true(context, "use_sim_time")


def full_namespace(context: LaunchContext) -> str:
    """Return the namespace of the nodes, that of the group they are launched in included."""
    return prefix_namespace(context.launch_configurations.get("ros_namespace"), argument(context, "namespace")) or ""


def _is_true(context: LaunchContext, name: str) -> bool:
    return argument(context, name).lower() == "true"


def composed_argument(default: str) -> LaunchDescriptionEntity:
    """Declare whether the estimators share a process."""
    return DeclareLaunchArgument(
        "composed",
        default_value=default,
        choices=["true", "false", "True", "False"],
        description=f"run {', '.join(graph.COMPOSED)} in one process",
    )


def map_argument() -> LaunchDescriptionEntity:
    """Declare the signal map of a car with other topics."""
    return DeclareLaunchArgument(
        "map_file", default_value="", description=f"signal map of a car with other topics: {map_choices()}"
    )


def is_composed(context: LaunchContext) -> bool:
    """Return the launch argument composed."""
    return _is_true(context, "composed")


def node_actions(
    context: LaunchContext, nodes: Sequence[str], decided: Decided, composed: bool = False
) -> list[LaunchDescriptionEntity]:
    """Start nodes with the common arguments, after checking their parameters.

    Args:
        context: context of the launch.
        nodes: names of the nodes.
        decided: parameters that override every file, by node.
        composed: whether those of graph.COMPOSED share a process.

    Raises:
        ParameterError: a file is bad; nothing has been started.
    """
    namespace, full = argument(context, "namespace"), full_namespace(context)
    starts = node_starts(nodes, decided, argument(context, "params_file"), argument(context, "vehicle_file"), full)
    alone = [start for start in starts if not (composed and start.node in graph.COMPOSED)]
    sim_time = ["-p", f"use_sim_time:={str(uses_sim_time(context)).lower()}"]
    log_level = ["--log-level", argument(context, "log_level")]
    respawn = _is_true(context, "respawn")
    ends: dict[str, Any] = {"respawn": respawn, "on_exit": None if respawn else end_launch, "output": "screen"}
    return [
        *(LogInfo(msg=note) for start in starts for note in start.notes),
        *(
            Node(
                package="friction_bringup",
                executable="graph",
                namespace=namespace,
                ros_arguments=[*composed_arguments(starts), *sim_time, *log_level],
                **ends,
            )
            for _ in range(composed)
        ),
        *(
            Node(
                package=start.node,
                executable=graph.executable(start.node),
                namespace=namespace,
                parameters=[*start.files, {"use_sim_time": uses_sim_time(context), **start.decided}],
                ros_arguments=log_level,
                **ends,
            )
            for start in alone
        ),
    ]


def end_launch(event: ProcessExited, context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """End the launch when one of its processes has ended by itself.

    Raises:
        RuntimeError: it is not a plant whose run is over; the launch prints the text and ends with exit code 1.
    """
    if context.is_shutdown:
        return []
    if event.returncode != 0 or not event.process_name.startswith(graph.PLANT):
        raise RuntimeError(f"{event.process_name} ended with exit code {event.returncode}")
    return [Shutdown(reason=f"{event.process_name} has ended")]
