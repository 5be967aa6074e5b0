"""The whole graph with the plant in the loop.

ros2 launch friction_bringup demo.launch.py surface:=snow [params_file:=FILE] [namespace:=NAME] [use_sim_time:=true]

Time comes from message stamps; use_sim_time makes the plant publish /clock for other nodes.
"""

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, OpaqueFunction

from friction_bringup import graph
from friction_bringup.launching import argument, common_arguments, node_actions


def _nodes(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    plant: dict[str, graph.ParameterValue] = {
        "surfaces": [argument(context, "surface")],
        "publish_clock": argument(context, "use_sim_time") == "true",
        "use_sim_time": False,
    }
    return node_actions(context, graph.NODES, {graph.PLANT: plant})


def generate_launch_description() -> LaunchDescription:
    surface = DeclareLaunchArgument(
        "surface", default_value="dry", choices=list(graph.SURFACES), description="road of the plant"
    )
    return LaunchDescription([surface, *common_arguments("demo"), OpaqueFunction(function=_nodes)])
