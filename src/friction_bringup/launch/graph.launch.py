"""The estimators and the supervisor, which watches and sends no command; the estimators in one process or each in one.

ros2 launch friction_bringup graph.launch.py vehicle_file:=FILE [composed:=true] [params_file:=FILE] [namespace:=NAME]
    [use_sim_time:=true]
"""

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import OpaqueFunction

from friction_bags.offline.estimators import ESTIMATORS
from friction_bringup.launching import common_arguments, composed_argument, is_composed, node_actions
from friction_bringup.node_start import WATCHING


def _nodes(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    return node_actions(context, ESTIMATORS, WATCHING, is_composed(context))


def generate_launch_description() -> LaunchDescription:
    return LaunchDescription([composed_argument("false"), *common_arguments(), OpaqueFunction(function=_nodes)])
