"""A DDS domain that nobody on this machine uses, so that two runs do not hear each other."""

from __future__ import annotations

import os
import socket
from pathlib import Path

from ament_index_python.packages import get_package_share_directory

_LAST_DOMAIN = 101
"""Above it the ports of DDS lie in the range that Linux gives to any program."""


def local_discovery() -> dict[str, str]:
    """Environment variables for a graph on this machine alone, whose processes find each other at once.

    Over loopback only, so that nothing is left in /dev/shm; with the shipped Fast DDS profile, because by default one
    start in two waits 2 to 3.5 s for the last pair of processes.
    """
    profile = Path(get_package_share_directory("friction_bringup")) / "config" / "discovery.xml"
    return {
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4",
        "FASTRTPS_DEFAULT_PROFILES_FILE": str(profile),
    }


def is_free(domain: int) -> bool:
    """Say whether no participant of this machine listens in the domain (its discovery port, RTPS 9.6.1.1)."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(("", 7400 + 250 * domain))
        except OSError:
            return False
    return True


def free_domain_id() -> int:
    """Return a ROS_DOMAIN_ID from 1 to 101 that is free now; the search begins at a place given by the process id.

    Raises:
        RuntimeError: every domain is in use.
    """
    for offset in range(_LAST_DOMAIN):
        domain = 1 + (os.getpid() + offset) % _LAST_DOMAIN
        if is_free(domain):
            return domain
    raise RuntimeError(f"every ROS_DOMAIN_ID from 1 to {_LAST_DOMAIN} is in use: stop a graph that still runs")
