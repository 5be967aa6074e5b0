"""Closed loop of plant and processors with a fault in between, and the record of a run."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from heapq import heappop, heappush
from itertools import count
from math import inf, nan
from typing import Any

import numpy as np
from friction_msgs.msg import BrakeCommand, SupervisorState, WheelSlip
from numpy.typing import NDArray

from abs_supervisor.parameters import SLOPE_SIGN
from campaigns.faults.case import ONSET, START, Arrival, Case, Fault, Manoeuvre, Site, at_once
from corner_sim.plant import SAMPLE_TIME, SAMPLE_TIME_NS, SLIP_MIN_SPEED, PlantSample
from friction_bags.offline.estimators import WHEEL_ESTIMATORS, closed_loop_parameters, make_processors
from friction_runtime.messages import to_nanoseconds
from friction_runtime.processor import Level, Processor, silent
from vehicle_models.reason import Reason

Array = NDArray[np.float64]

_S0 = int(SupervisorState.S0)
_QUIET = (Reason.OK, Reason.LOW_SPEED)


@dataclass(frozen=True)
class Record:
    """One run, k samples of n wheels."""

    stopped: bool
    """Came to standstill."""
    time: Array
    """Since the start of the run [s], shape (k,)."""
    speed: Array
    """Of the car [m/s], shape (k,)."""
    distance: Array
    """[m], shape (k,)."""
    slip: Array
    """True slip [-], shape (k, n); NaN at standstill."""
    slip_error: Array
    """Of the estimated slips that are valid, over their standard deviations [-], shape (k, n); NaN for others."""
    command: NDArray[np.int64]
    """In force after the sample, constants of BrakeCommand, shape (k, n)."""
    acting: NDArray[np.bool_]
    """The supervisor is in a state other than S0, and its commands are in force, shape (k, n)."""
    named: float
    """Time [s] of the first new reason or diagnostics above OK since the begin of the fault; inf: there is none."""
    said: str
    """The first of these texts."""


class Recorder:
    """Collects a Record sample by sample."""

    def __init__(self, manoeuvre: Manoeuvre, begin: float, named: str) -> None:
        """Texts from `begin` on [s since the start of the run] count, with `named` in them and not there before."""
        self._wheels = manoeuvre.vehicle.wheel_names
        self._begin, self._name = begin, named
        n = len(self._wheels)
        self._command, self._acting = [int(BrakeCommand.NONE)] * n, [False] * n
        self._expires = [-inf] * n
        self._samples: list[PlantSample] = []
        self._commands: list[list[int]] = []
        self._actings: list[list[bool]] = []
        self._slips: list[WheelSlip] = []
        self._before: set[str] = set()
        self._named, self._said = inf, ""

    def command(self, now: float, message: BrakeCommand) -> None:
        """Take a command that the plant has taken."""
        wheel = self._wheels.index(message.wheel)
        self._command[wheel], self._expires[wheel] = int(message.command), now + message.valid_for

    def state(self, now: float, message: SupervisorState) -> None:
        """Take a state of the supervisor."""
        self._acting[self._wheels.index(message.wheel)] = message.state != _S0
        if message.validity.reason not in _QUIET:
            self.diagnosis(now, f"{message.wheel}/abs_supervisor: {message.validity.text}")

    def slip(self, message: WheelSlip) -> None:
        """Take an estimated slip."""
        if message.validity.valid:
            self._slips.append(message)

    def diagnosis(self, now: float, text: str) -> None:
        """Take what diagnostics or a state say above OK."""
        if now < self._begin - 1e-9:
            self._before.add(_kind(text))
        elif self._named == inf and self._name in text and _kind(text) not in self._before:
            self._named, self._said = now, text

    def sample(self, truth: PlantSample) -> None:
        """End a sample."""
        now = truth.index * SAMPLE_TIME
        self._samples.append(truth)
        in_force = [now <= at + 1e-9 for at in self._expires]
        none = int(BrakeCommand.NONE)
        self._commands.append([each if on else none for each, on in zip(self._command, in_force, strict=True)])
        self._actings.append([each and on for each, on in zip(self._acting, in_force, strict=True)])

    def record(self, stopped: bool) -> Record:
        """Return what was collected."""
        samples = self._samples
        speed = np.array([each.speed for each in samples])
        slip = np.array([each.slip for each in samples])
        slip = np.where(speed[:, np.newaxis] > SLIP_MIN_SPEED, slip, nan)
        return Record(
            stopped,
            np.array([each.index * SAMPLE_TIME for each in samples]),
            speed,
            np.array([each.distance for each in samples]),
            slip,
            self._slip_errors(slip),
            np.array(self._commands),
            np.array(self._actings),
            self._named,
            self._said,
        )

    def _slip_errors(self, slip: Array) -> Array:
        """Return the errors of the valid slips, in the rows of their stamps."""
        errors = np.full_like(slip, nan)
        for message in self._slips:
            row = round((to_nanoseconds(message.header.stamp) - START) / SAMPLE_TIME_NS)
            if 0 <= row < len(slip):
                wheel = self._wheels.index(message.wheel)
                errors[row, wheel] = (message.slip - slip[row, wheel]) / message.slip_stddev
        return errors


def _kind(text: str) -> str:
    """Text without its numbers: they change while the cause stays."""
    return "".join(each for each in text if not each.isdigit())


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
    ) -> None:
        """Put the car at the start of the road.

        Args:
            manoeuvre: what is driven.
            case: the fault.
            seed: of sensor noise and fault.
            law: that of abs_supervisor.
        """
        vehicle = manoeuvre.vehicle
        self._case = case
        self._simulation = manoeuvre.simulation(seed)
        self._fault = case.make(Site(vehicle, np.random.default_rng([seed, 13])))
        self._now = 0.0
        self._acting: Fault = at_once
        parameters = closed_loop_parameters(WHEEL_ESTIMATORS, law)
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
        for _, message in outputs:
            if isinstance(message, WheelSlip):
                self._recorder.slip(message)
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
