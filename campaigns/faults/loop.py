"""The loop without middleware: plant, fault, shipped processors, fault again, plant."""

from collections import deque
from collections.abc import Sequence
from heapq import heappop, heappush
from itertools import count
from math import inf
from typing import Any

import numpy as np
from friction_msgs.msg import BrakeCommand, SupervisorState

from abs_supervisor.parameters import SLOPE_SIGN
from campaigns.faults.case import Case
from campaigns.faults.fault import Arrival, Fault, Site, at_once
from campaigns.faults.manoeuvre import ONSET, Manoeuvre
from campaigns.faults.record import Record, Recorder
from corner_sim.plant import SAMPLE_TIME, PlantSample
from friction_bags.offline.estimators import WHEEL_ESTIMATORS, closed_loop_parameters, make_processors
from friction_runtime.processor import Level, Processor, silent

_HALF = 0.5 * SAMPLE_TIME
_WATCH_SAMPLES = round(0.01 / SAMPLE_TIME)
"""Samples between two looks of a node at the age of its inputs."""


class Loop:
    """One stop with one fault. The steady clock is the time since the first sample, whatever the stamps say.

    Messages need no time of their own, and a command acts on the sample that it answers. Those that arrive late come
    before the messages of the first sample that is not earlier.
    """

    def __init__(
        self,
        manoeuvre: Manoeuvre,
        case: Case,
        seed: int,
        law: str = SLOPE_SIGN,
        recorded: Sequence[PlantSample] = (),
    ) -> None:
        """Put the car at the start of the road.

        Args:
            manoeuvre: what is driven.
            case: the fault.
            seed: of sensor noise and fault.
            law: that of abs_supervisor.
            recorded: samples of the stop without ABS, which need not be computed again until a command changes it.
        """
        vehicle = manoeuvre.vehicle
        self._case = case
        self._simulation = manoeuvre.simulation(seed, recorded)
        self._fault = case.make(Site(vehicle, np.random.default_rng([seed, 13])))
        self._now = 0.0
        self._acting: Fault = at_once
        parameters = closed_loop_parameters(WHEEL_ESTIMATORS, law, len(vehicle.wheels))
        self._processors = make_processors(parameters, vehicle, silent)
        self._readers: dict[str, list[Processor]] = {}
        for processor in self._processors:
            for topic in (*processor.sensors, *processor.estimates):
                self._readers.setdefault(topic, []).append(processor)
        self._arrived = dict.fromkeys(self._readers, -inf)
        self._late: list[tuple[float, int, Arrival]] = []
        self._numbers = count()
        self._recorder = Recorder(manoeuvre, ONSET + case.begin, case.named)

    def run(self, longest: float) -> Record:
        """Drive to standstill, or for so long [s] after the onset of braking."""
        simulation = self._simulation
        while simulation.end is None and simulation.time < ONSET + longest:
            self._now = simulation.time
            since = self._now - ONSET + _HALF * 0.1
            self._acting = self._fault if self._case.begin <= since < self._case.end else at_once
            while self._late and self._late[0][0] <= self._now + 1e-9:
                self._deliver(heappop(self._late)[2])
            for topic, message in simulation.messages(truth=False):
                self._send(topic, message)
            if simulation.index % _WATCH_SAMPLES == 0:
                self._watch()
            self._recorder.sample(simulation.sample)
            simulation.advance()
        return self._recorder.record(simulation.end is not None)

    def _send(self, topic: str, message: Any) -> None:
        for arrival in self._acting(topic, message):
            if arrival.delay > 0.0:
                heappush(self._late, (self._now + arrival.delay, next(self._numbers), arrival))
            else:
                self._deliver(arrival)

    def _deliver(self, arrival: Arrival) -> None:
        """Pass one message to its readers, and on what they answer, in the order in which it is sent."""
        waiting: deque[Arrival] = deque([arrival])
        while waiting:
            _, topic, message = waiting.popleft()
            if isinstance(message, BrakeCommand):
                if self._simulation.take_command(message.wheel, message) is None:
                    self._recorder.command(self._now, message)
            elif isinstance(message, SupervisorState):
                self._recorder.state(self._now, message)
            if topic in self._arrived:
                self._arrived[topic] = self._now
            for processor in self._readers.get(topic, ()):
                waiting.extend(self._passed(processor.process(topic, message)))

    def _passed(self, outputs: Sequence[tuple[str, Any]]) -> list[Arrival]:
        return [arrival for topic, message in outputs for arrival in self._acting(topic, message)]

    def _watch(self) -> None:
        now = self._now
        ages = {topic: now - at for topic, at in self._arrived.items()}
        for processor in self._processors:
            for arrival in self._passed(processor.watch(ages, now)):
                self._deliver(arrival)
        for processor in self._processors:
            health = processor.health()
            if health.level is not Level.OK:
                kind = type(processor).__module__.partition(".")[0]
                self._recorder.diagnosis(now, f"{kind} {health.name}: {health.message}")
