"""The estimators beside a vehicle stack, without plant; the supervisor in shadow mode sends no command.

ros2 launch friction_bringup alongside.launch.py [params_file:=FILE] [namespace:=NAME] [use_sim_time:=true]
"""

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import OpaqueFunction

from friction_bringup import graph
from friction_bringup.launching import common_arguments, node_actions


def _nodes(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    return node_actions(context, graph.ESTIMATORS, {})


def generate_launch_description() -> LaunchDescription:
    return LaunchDescription([*common_arguments("alongside"), OpaqueFunction(function=_nodes)])
