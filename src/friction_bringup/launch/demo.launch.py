"""The whole graph with the plant in the loop. The supervisor commands: the brake is simulated.

ros2 launch friction_bringup demo.launch.py surface:=snow [law:=slope_sign] [vehicle_file:=FILE] [params_file:=FILE]
    [namespace:=NAME] [use_sim_time:=true] [composed:=false]

Time comes from message stamps; use_sim_time makes the plant publish /clock for other nodes.
"""

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, OpaqueFunction

from friction_bags.offline.estimators import SMART_TYRE
from friction_bringup import graph
from friction_bringup.demo_drive import CALIBRATION, CARS, ROAD_TEXT, WAITED_FOR, plant_of_demo
from friction_bringup.launching import (
    argument,
    common_arguments,
    composed_argument,
    full_namespace,
    is_composed,
    node_actions,
    uses_sim_time,
)
from friction_bringup.node_start import commanding, left_to_file
from friction_runtime.installed import shipped_file


def _nodes(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    of_demo = plant_of_demo(argument(context, "surface"), argument(context, "vehicle_file"))
    composed = is_composed(context)
    plant = {
        **of_demo[graph.PLANT],
        "publish_clock": uses_sim_time(context),
        "use_sim_time": False,
        WAITED_FOR: graph.wheel_states_subscriptions(composed),
    }
    decided = {**commanding(argument(context, "law")), **of_demo, graph.PLANT: plant}
    files = argument(context, "params_file"), full_namespace(context)
    decided = left_to_file(decided, graph.PLANT, WAITED_FOR, *files)
    return node_actions(context, graph.NODES, left_to_file(decided, SMART_TYRE, CALIBRATION, *files), composed)


def generate_launch_description() -> LaunchDescription:
    surface = DeclareLaunchArgument("surface", default_value="dry", description=ROAD_TEXT)
    law = DeclareLaunchArgument(
        "law", default_value=graph.LAWS[0], choices=list(graph.LAWS), description="what commands the brake"
    )
    shared = common_arguments(str(shipped_file("friction_bringup", "demo")), CARS["car"])
    return LaunchDescription([surface, law, composed_argument("true"), *shared, OpaqueFunction(function=_nodes)])
