"""Record of a run: truth, commands in force and outputs of the graph."""

from dataclasses import dataclass
from math import inf, nan

import numpy as np
from friction_msgs.msg import BrakeCommand, SupervisorState
from numpy.typing import NDArray

from campaigns.faults.manoeuvre import Manoeuvre
from corner_sim.plant import SAMPLE_TIME, SLIP_MIN_SPEED, PlantSample

Array = NDArray[np.float64]

_S0 = int(SupervisorState.S0)
_QUIET = (SupervisorState.OK, SupervisorState.LOW_SPEED)


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
        self._before: set[str] = set()
        self._named, self._said = inf, ""

    def command(self, now: float, message: BrakeCommand) -> None:
        """Take a command that the plant has taken."""
        wheel = self._wheels.index(message.wheel)
        self._command[wheel], self._expires[wheel] = int(message.command), now + message.valid_for

    def state(self, now: float, message: SupervisorState) -> None:
        """Take a state of the supervisor."""
        self._acting[self._wheels.index(message.wheel)] = message.state != _S0
        if message.reason not in _QUIET:
            self.diagnosis(now, f"{message.wheel}/abs_supervisor: {message.reason_text}")

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
        return Record(
            stopped,
            np.array([each.index * SAMPLE_TIME for each in samples]),
            speed,
            np.array([each.distance for each in samples]),
            np.where(speed[:, np.newaxis] > SLIP_MIN_SPEED, slip, nan),
            np.array(self._commands),
            np.array(self._actings),
            self._named,
            self._said,
        )


def _kind(text: str) -> str:
    """Text without its numbers: they change while the cause stays."""
    return "".join(each for each in text if not each.isdigit())
