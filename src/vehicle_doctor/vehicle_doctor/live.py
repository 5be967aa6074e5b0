"""The topics of a running graph as a drive."""

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from time import monotonic, time_ns
from typing import Any

import rclpy
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node

from friction_parameters.parameter import ParameterError
from friction_runtime import qos
from friction_runtime.spin import made, start_middleware, stop_on_signals, take_down
from vehicle_doctor.drive import Drive, collect, kinds
from vehicle_models.vehicle import Vehicle

_PERIOD = 0.2
"""Time between two looks at whether a signal has come [s]."""


@contextmanager
def listening(vehicle: Vehicle, seconds: float, of_ros: Sequence[str]) -> Iterator[Drive]:
    """Yield what is heard within a time, or until SIGINT or SIGTERM.

    The middleware is taken down after what is done with the drive: that can end the process.

    Args:
        vehicle: the car.
        seconds: time [s].
        of_ros: arguments of ROS, such as a namespace.

    Raises:
        ParameterError: the time is not above zero, or the middleware does not accept the arguments.
    """
    if not seconds > 0.0:
        raise ParameterError(f"--live = {seconds:g} must be a time in seconds")
    stop = stop_on_signals()
    start_middleware(of_ros)
    node: Node | None = None
    executor = EventsExecutor()
    heard: list[tuple[str, int, Any]] = []

    def hear(topic: str, message: Any) -> None:
        heard.append((topic, time_ns(), message))

    try:
        node = made(partial(rclpy.create_node, "doctor"))
        executor.add_node(node)
        for topic, kind in kinds(vehicle).items():
            qos.subscribe(node, kind, topic, partial(hear, topic), qos.SENSOR)
        print(f"listening for {seconds:g} s; Ctrl-C ends it earlier", file=sys.stderr, flush=True)
        until = monotonic() + seconds
        while (remaining := until - monotonic()) > 0.0 and not stop.is_set():
            executor.spin_once(timeout_sec=min(remaining, _PERIOD))
        namespace = node.get_namespace().rstrip("/") + "/"
        there = {
            name.removeprefix(namespace) for name, _ in node.get_topic_names_and_types() if node.count_publishers(name)
        }
        yield collect(vehicle, heard, there - set(kinds(vehicle)))
    finally:
        take_down(node, executor)
