"""Client node in the process of the test, with the nodes under test as child processes on a ROS domain of their own."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from typing import Any

import rclpy
from rcl_interfaces.srv import ListParameters
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

PATIENCE = 120.0
"""Wall time [s] after which a test gives up: far more than a busy machine needs, so that timing decides nothing."""
_DOMAINS = 101
"""Number of domains whose DDS ports are below those that Linux assigns to any program."""
_reservations: list[socket.socket] = []


class DdsClient:
    """A node of the test, and the processes it started."""

    def __init__(self, node: Node) -> None:
        """Wrap a node; made by dds_client()."""
        self.node = node
        self.executor = SingleThreadedExecutor(context=node.context)
        self.executor.add_node(node)
        self._processes: list[subprocess.Popen[str]] = []

    def start(self, *arguments: str) -> subprocess.Popen[str]:
        """Start `python ARGUMENTS` (e.g. "-m", "corner_sim") on the domain of this client, output captured."""
        process = subprocess.Popen(
            [sys.executable, *arguments],
            env=os.environ | {"ROS_DOMAIN_ID": str(own_domain())},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self._processes.append(process)
        return process

    def until(self, condition: Callable[[], bool]) -> None:
        """Spin until the condition holds.

        Raises:
            TimeoutError: the condition does not hold in time.
        """
        limit = time.monotonic() + PATIENCE
        while not condition():
            if time.monotonic() > limit:
                raise TimeoutError(f"not within {PATIENCE} s")
            self.executor.spin_once(timeout_sec=0.05)

    def until_known_to(self, node: str) -> None:
        """Wait until a node has discovered every publisher and subscription made here so far.

        A publisher counts its reader before the reader counts it; messages in between are lost. Endpoints are announced
        in the order in which they are made: a node that answers a call has discovered those made before the call.
        """
        self.call(ListParameters, f"/{node}/list_parameters", ListParameters.Request())

    def call(self, kind: type, name: str, request: Any) -> Any:
        """Call a service and return its response."""
        client = self.node.create_client(kind, name)
        self.until(client.service_is_ready)
        future = client.call_async(request)
        self.until(future.done)
        return future.result()

    def close(self) -> None:
        """End the processes and the node."""
        for process in self._processes:
            process.kill()
            process.wait()


def stop(process: subprocess.Popen[str], how: signal.Signals = signal.SIGINT) -> str:
    """Send a signal; return the output of the process once it has ended."""
    process.send_signal(how)
    return output_of(process)


def output_of(process: subprocess.Popen[str]) -> str:
    """Return the output of a process once it has ended."""
    output, _ = process.communicate(timeout=PATIENCE)
    return output


@cache
def own_domain() -> int:
    """Return a ROS_DOMAIN_ID from 1 to 101, reserved on this machine until the test process ends.

    It is reserved under the names that free_domain_id() of friction_runtime uses, so that a demo takes another one.

    Raises:
        RuntimeError: every domain is reserved.
    """
    for offset in range(_DOMAINS):
        domain = 1 + (os.getpid() + offset) % _DOMAINS
        reservation = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        try:
            reservation.bind(f"\0friction_ros_domain_{domain}")
        except OSError:
            reservation.close()
        else:
            _reservations.append(reservation)
            return domain
    raise RuntimeError(f"every ROS_DOMAIN_ID from 1 to {_DOMAINS} is reserved")


@contextmanager
def dds_client(arguments: Sequence[str] = ()) -> Iterator[DdsClient]:
    """Make a client on the domain of this test process and end it and its processes afterwards."""
    context = rclpy.Context()
    rclpy.init(context=context, args=list(arguments), domain_id=own_domain())
    client = DdsClient(rclpy.create_node("test_client", context=context))
    try:
        yield client
    finally:
        client.close()
        client.node.destroy_node()
        rclpy.try_shutdown(context=context)
