"""One node of the graph alone.

ros2 launch friction_bringup node.launch.py node:=wheel_slip [params_file:=FILE] [namespace:=NAME]
"""

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, OpaqueFunction

from friction_bringup import graph
from friction_bringup.launching import argument, common_arguments, node_actions


def _nodes(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    return node_actions(context, [argument(context, "node")], {})


def generate_launch_description() -> LaunchDescription:
    node = DeclareLaunchArgument("node", choices=list(graph.NODES), description="which one")
    return LaunchDescription([node, *common_arguments("demo"), OpaqueFunction(function=_nodes)])
