"""An example to copy: the estimators beside a vehicle stack whose topics have other names.

ros2 launch friction_bringup other_names.launch.py vehicle_file:=FILE [namespace:=NAME] [...]

Takes every argument of alongside.launch.py. On the left stand the names of this graph, in its namespace; on the right
those of your stack. Change them to yours, and leave out what you have not. Estimates can be renamed in the same way.
"""

from launch import LaunchDescription
from launch.actions import GroupAction, IncludeLaunchDescription
from launch.substitutions import PathJoinSubstitution
from launch_ros.actions import SetRemap
from launch_ros.substitutions import FindPackageShare

NAMES = {
    "wheel_states": "/chassis/joint_states",
    "imu/data": "/chassis/imu",
    "vehicle_velocity": "/localization/twist",
    "brake_demand": "/brakes/demand",
    "front_left/brake_pressure": "/brakes/pressure_fl",
    "front_right/brake_pressure": "/brakes/pressure_fr",
    "rear_left/brake_pressure": "/brakes/pressure_rl",
    "rear_right/brake_pressure": "/brakes/pressure_rr",
}


def generate_launch_description() -> LaunchDescription:
    file = PathJoinSubstitution([FindPackageShare("friction_bringup"), "launch", "alongside.launch.py"])
    alongside = IncludeLaunchDescription(file)
    return LaunchDescription([GroupAction([*(SetRemap(ours, yours) for ours, yours in NAMES.items()), alongside])])
