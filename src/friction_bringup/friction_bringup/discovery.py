"""Discovery settings for a graph on a single machine."""

from __future__ import annotations

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from rclpy.utilities import get_rmw_implementation_identifier

_FAST_DDS = "rmw_fastrtps_cpp"


def local_discovery() -> dict[str, str]:
    """Return environment variables for a graph on this machine alone, whose processes find each other at once.

    Over loopback and, with Fast DDS, without shared memory: the reason is in its shipped profile.
    """
    if get_rmw_implementation_identifier() != _FAST_DDS:
        return {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    profile = Path(get_package_share_directory("friction_bringup")) / "config" / "discovery.xml"
    return {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT", "FASTRTPS_DEFAULT_PROFILES_FILE": str(profile)}
