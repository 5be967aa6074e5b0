"""The estimators beside a vehicle stack, without plant; the supervisor watches and sends no command.

ros2 launch friction_bringup alongside.launch.py vehicle_file:=FILE [map_file:=FILE] [params_file:=FILE]
    [namespace:=NAME] [use_sim_time:=true]
"""

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import OpaqueFunction

from friction_bags.offline.estimators import ESTIMATORS
from friction_bringup.launching import argument, common_arguments, map_argument, node_actions
from friction_bringup.node_start import WATCHING, with_adapter


def _nodes(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    nodes, decided = with_adapter(ESTIMATORS, WATCHING, argument(context, "map_file"))
    return node_actions(context, nodes, decided)


def generate_launch_description() -> LaunchDescription:
    return LaunchDescription([map_argument(), *common_arguments(), OpaqueFunction(function=_nodes)])
