"""The estimators beside a vehicle stack, without plant; the supervisor watches and sends no command.

ros2 launch friction_bringup alongside.launch.py vehicle_file:=FILE [params_file:=FILE] [namespace:=NAME]
    [use_sim_time:=true]
"""

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import OpaqueFunction

from friction_bags.offline.estimators import ESTIMATORS
from friction_bringup.launching import common_arguments, node_actions
from friction_bringup.node_start import WATCHING


def _nodes(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    return node_actions(context, ESTIMATORS, WATCHING)


def generate_launch_description() -> LaunchDescription:
    return LaunchDescription([*common_arguments(), OpaqueFunction(function=_nodes)])
