"""Launch actions of the graph, shared by the launch files. Needs launch_ros, so nothing else imports it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from launch import LaunchContext, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from friction_bringup import graph
from friction_runtime.parameters import shipped_file


def common_arguments(params_file: str) -> list[LaunchDescriptionEntity]:
    """Declare the arguments every launch file takes.

    Args:
        params_file: name of the parameter file of this package that is the default.
    """
    return [
        DeclareLaunchArgument(
            "params_file",
            default_value=str(shipped_file("friction_bringup", params_file)),
            description="parameter file that decides over those of the packages",
        ),
        DeclareLaunchArgument("namespace", default_value="", description="namespace of all nodes and topics"),
        DeclareLaunchArgument(
            "use_sim_time", default_value="false", choices=["true", "false"], description="take the time from /clock"
        ),
    ]


def argument(context: LaunchContext, name: str) -> str:
    """Return the value of a launch argument."""
    return str(LaunchConfiguration(name).perform(context))


def node_actions(
    context: LaunchContext, nodes: Sequence[str], overrides: Mapping[str, Mapping[str, graph.ParameterValue]]
) -> list[LaunchDescriptionEntity]:
    """Start nodes with the common arguments.

    Args:
        context: of the launch.
        nodes: names of the nodes.
        overrides: by node, the parameters that decide over the files.
    """
    params_file = Path(argument(context, "params_file"))
    use_sim_time = argument(context, "use_sim_time") == "true"
    return [
        Node(
            package=name,
            executable=graph.executable(name),
            namespace=argument(context, "namespace"),
            parameters=[
                *map(str, graph.parameter_files(name, params_file)),
                {"use_sim_time": use_sim_time, **overrides.get(name, {})},
            ],
            output="screen",
        )
        for name in nodes
    ]
