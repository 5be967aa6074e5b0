"""One node of the graph alone; abs_supervisor watches and sends no command.

ros2 launch friction_bringup node.launch.py node:=wheel_slip vehicle_file:=FILE [params_file:=FILE] [namespace:=NAME]
    [use_sim_time:=true]
"""

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, OpaqueFunction

from friction_bringup import graph
from friction_bringup.launching import argument, common_arguments, node_actions
from friction_bringup.node_start import WATCHING


def _nodes(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    return node_actions(context, [argument(context, "node")], WATCHING)


def generate_launch_description() -> LaunchDescription:
    node = DeclareLaunchArgument("node", choices=list(graph.NODES), description="name of the node")
    return LaunchDescription([node, *common_arguments(), OpaqueFunction(function=_nodes)])
