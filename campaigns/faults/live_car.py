"""A car whose sensors are published in real time, with a fault in between, and the commands that come back."""

from __future__ import annotations

import time
from collections.abc import Callable
from copy import deepcopy
from math import inf
from typing import Any

from friction_msgs.msg import BrakeCommand
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.publisher import Publisher

from benchmarks.protocol import ACCELERATION_STDDEV, CAR, WHEEL
from campaigns.faults.fault import Fault, at_once
from corner_sim.messages import topics
from corner_sim.parameters import SimParameters
from corner_sim.plant import SAMPLE_TIME, SAMPLE_TIME_NS
from corner_sim.simulation import Simulation
from friction_runtime import qos
from friction_runtime.processor import Output
from friction_runtime.stamps import header_at, to_nanoseconds
from vehicle_models.nanoseconds import NANOSECOND

_PARAMETERS = SimParameters(
    surfaces=("dry",),
    demand_level=0.1,
    initial_speed=60.0,
    acceleration_variance=ACCELERATION_STDDEV**2,
    end_time=25.0,
)
"""A gentle stop of one corner, so that many trials go into one; it ends far from standstill."""


class LiveCar:
    """Publishes a sample every 5 ms of the steady clock, and notes when each message and each command was sent.

    The samples are made beforehand, so that a busy machine can keep up. One that is missed all the same is left out, as
    it would be by a sensor; then stamps still go with the clock. At the end of its stop the car rolls at 60 m/s again.
    """

    def __init__(self, node: Node, executor: SingleThreadedExecutor) -> None:
        """Connect; nothing is published yet."""
        self.fault: Fault = at_once
        self.command = int(BrakeCommand.NONE)
        """The newest one."""
        self.answered = -inf
        """Stamp [s] of the sample that the newest command answers, unless it is NONE; -inf for NONE."""
        self.commanded_at = -inf
        """Wall clock [s] when the newest command was sent."""
        self.none_since = inf
        """Wall clock [s] when the newest run of NONE began to be sent; inf while another command is in force."""
        self.sent: dict[str, float] = {}
        """Wall clock [s] of the newest message of each topic that came through as it was made."""
        self._executor = executor
        self._publishers: dict[str, Publisher] = {
            topic: qos.publish(node, kind, topic)
            for topic, kind in topics([WHEEL], True, True, False).items()
            if not topic.startswith("truth/")
        }
        self._subscription = node.create_subscription(BrakeCommand, f"{WHEEL}/brake_command", self._take, qos.ESTIMATE)
        simulation = Simulation(_PARAMETERS, CAR, 1)
        self._samples: list[list[Output]] = []
        while simulation.end is None:
            self._samples.append([each for each in simulation.messages() if each[0] in self._publishers])
            simulation.advance()
        self._start = time.time_ns(), time.monotonic()
        self._count = 0

    @property
    def connected(self) -> bool:
        """Every sensor has a reader, and somebody commands."""
        readers = all(publisher.get_subscription_count() for publisher in self._publishers.values())
        return readers and self._subscription.get_publisher_count() > 0

    @property
    def left(self) -> float:
        """Time until the car rolls at 60 m/s again [s], which no wheel can do at once."""
        return (len(self._samples) - self._count % len(self._samples)) * SAMPLE_TIME

    def drive_until(self, condition: Callable[[], bool], limit: float) -> bool:
        """Drive on until a condition holds; return whether it did within a limit [s, wall clock]."""
        until = time.monotonic() + limit
        while not condition():
            if time.monotonic() > until:
                return False
            self._publish(self._count)
            self._count = max(self._count + 1, int((time.monotonic() - self._start[1]) / SAMPLE_TIME))
            due = self._start[1] + self._count * SAMPLE_TIME
            while (left := due - time.monotonic()) > 0.0:
                self._executor.spin_once(timeout_sec=left)
            self._executor.spin_once(timeout_sec=0.0)
        return True

    def _publish(self, count: int) -> None:
        stamp = self._start[0] + count * SAMPLE_TIME_NS
        for topic, made in self._samples[count % len(self._samples)]:
            made.header = header_at(stamp, made.header.frame_id)
            for arrival in self.fault(topic, made if self.fault is at_once else deepcopy(made)):
                self._publishers[topic].publish(arrival.message)
                if arrival.message is made or arrival.message == made:
                    self.sent[topic] = time.time()

    def _take(self, message: BrakeCommand, info: dict[str, Any]) -> None:
        self.command = int(message.command)
        self.commanded_at = info["source_timestamp"] * 1e-9
        if self.command != BrakeCommand.NONE:
            self.none_since = inf
            self.answered = to_nanoseconds(message.header.stamp) * NANOSECOND
        else:
            self.none_since = min(self.none_since, self.commanded_at)
            self.answered = -inf
