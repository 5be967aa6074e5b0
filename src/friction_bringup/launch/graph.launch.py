"""The estimators and the supervisor, which watches and sends no command; the estimators in one process or each in one.

ros2 launch friction_bringup graph.launch.py vehicle_file:=FILE [composed:=true] [map_file:=FILE] [params_file:=FILE]
    [namespace:=NAME] [use_sim_time:=true]
"""

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import OpaqueFunction

from friction_bags.offline.estimators import ESTIMATORS
from friction_bringup.launching import (
    argument,
    common_arguments,
    composed_argument,
    is_composed,
    map_argument,
    node_actions,
)
from friction_bringup.node_start import WATCHING, with_adapter


def _nodes(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    nodes, decided = with_adapter(ESTIMATORS, WATCHING, argument(context, "map_file"))
    return node_actions(context, nodes, decided, is_composed(context))


def generate_launch_description() -> LaunchDescription:
    return LaunchDescription(
        [composed_argument("false"), map_argument(), *common_arguments(), OpaqueFunction(function=_nodes)]
    )
