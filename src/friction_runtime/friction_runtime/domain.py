"""An unused DDS domain, so that two runs on this machine do not receive each other's messages."""

from __future__ import annotations

import os
import socket
from pathlib import Path

_LAST_DOMAIN = 101
"""Above it the ports of DDS lie in the range that Linux gives to any program."""
_FIRST_PORT = 7400
"""First port of domain 0 (RTPS 9.6.1.1)."""
_PORTS_OF_A_DOMAIN = 250

_reservations: list[socket.socket] = []


def is_free(domain: int) -> bool:
    """Whether no participant on this machine listens in the domain.

    All ports of the domain are checked, without binding any: a participant that discovers over loopback alone does not
    listen at the first port of its domain.
    """
    first = _FIRST_PORT + _PORTS_OF_A_DOMAIN * domain
    return _udp_ports().isdisjoint(range(first, first + _PORTS_OF_A_DOMAIN))


def free_domain_id() -> int:
    """Return a ROS_DOMAIN_ID from 1 to 101 that is free, and reserve it for this process until it ends.

    Another call, here or in another process, returns another domain, even before a participant listens in this one.
    The search begins at a place given by the process id.

    Raises:
        RuntimeError: every domain is in use.
    """
    for offset in range(_LAST_DOMAIN):
        domain = 1 + (os.getpid() + offset) % _LAST_DOMAIN
        reservation = _reserve(domain)
        if reservation is None:
            continue
        if is_free(domain):
            _reservations.append(reservation)
            return domain
        reservation.close()
    raise RuntimeError(f"every ROS_DOMAIN_ID from 1 to {_LAST_DOMAIN} is in use: stop a graph that still runs")


def _reserve(domain: int) -> socket.socket | None:
    """Take the domain's name among the abstract sockets, which the system gives back however the process ends."""
    reservation = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    try:
        reservation.bind(f"\0friction_ros_domain_{domain}")
    except OSError:
        reservation.close()
        return None
    return reservation


def _udp_ports() -> set[int]:
    """Local UDP ports in use on this machine."""
    ports = set()
    for table in ("udp", "udp6"):
        path = Path("/proc/net", table)
        for line in path.read_text().splitlines()[1:] if path.exists() else ():
            ports.add(int(line.split()[1].rsplit(":", 1)[1], 16))
    return ports
