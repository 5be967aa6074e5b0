"""Inputs of the plant: brake commands of the supervisor and the driver's demand by topic."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite

import numpy as np
from friction_msgs.msg import BrakeCommand, BrakeDemand
from numpy.typing import NDArray

from friction_runtime.command_checksum import checksum
from friction_runtime.messages import to_nanoseconds
from vehicle_models.brake_actuator import Command
from vehicle_models.nanoseconds import NANOSECONDS

LONGEST_VALIDITY = 1.0
"""A command that claims to hold for longer [s] is refused: its supervisor could be dead all that time."""
_COUNTER_RANGE = 2**32
"""Values of the counter of a command: it wraps around."""


@dataclass(frozen=True)
class _Taken:
    """A command that was taken."""

    command: Command
    stamp: int
    """Stamp of the sample it answers [ns]."""
    expires: int
    """It is in force up to this stamp of the plant [ns]."""
    counter: int


class CommandInbox:
    """The newest brake_command of each wheel, as an ABS core would take it: nothing old, nothing that has expired."""

    def __init__(self, wheels: Sequence[str]) -> None:
        """Start without commands for these wheels."""
        self._wheels = tuple(wheels)
        self._newest: dict[str, _Taken] = {}
        self.lost = 0
        """Commands that the counters show to be missing."""
        self.new_senders = 0
        """How often a counter began again: the supervisor was started again, or there are two of them."""

    def take(self, wheel: str, message: BrakeCommand, now: int) -> str | None:
        """Take a message from `wheel`'s topic at the plant's stamp `now` [ns]; return why it is refused.

        A refused message changes nothing: what was in force stays so until it expires.
        """
        topic = f"{wheel}/brake_command"
        if message.wheel != wheel:
            return f"{topic}: message is for wheel '{message.wheel}', refused"
        if message.checksum != checksum(message):
            return f"{topic}: checksum is not that of its contents, refused"
        if message.command not in tuple(Command):
            return f"{topic}: unknown command {message.command}, refused"
        valid_for = message.valid_for
        if not (isfinite(valid_for) and 0.0 < valid_for <= LONGEST_VALIDITY):
            return f"{topic}: valid_for {valid_for} s must be above 0 and at most {LONGEST_VALIDITY} s, refused"
        stamp = to_nanoseconds(message.header.stamp)
        if stamp <= 0:
            return f"{topic}: stamp is zero, refused"
        if stamp > now:
            return f"{topic}: answers a sample {_seconds(stamp - now)} s ahead of the plant, refused"
        expires = stamp + round(valid_for * NANOSECONDS)
        if now > expires:
            return f"{topic}: answers a sample {_seconds(now - stamp)} s old and is valid for {valid_for} s, refused"
        newest = self._newest.get(wheel)
        if newest is not None:
            step = (message.counter - newest.counter) % _COUNTER_RANGE
            if step == 0:
                return f"{topic}: counter {message.counter} is repeated, refused"
            goes_back = step > _COUNTER_RANGE // 2
            # A supervisor that was started again counts from the beginning, but answers newer samples. An old message
            # does neither.
            if stamp < newest.stamp or (goes_back and stamp == newest.stamp):
                return f"{topic}: counter {message.counter} is older than the newest, {newest.counter}; refused"
            self.new_senders += goes_back
            self.lost += 0 if goes_back else step - 1
        self._newest[wheel] = _Taken(Command(message.command), stamp, expires, message.counter)
        return None

    def unanswered(self, now: int) -> list[str]:
        """Return the wheels whose newest command does not answer the sample at the plant's stamp `now` [ns]."""
        return [wheel for wheel in self._wheels if wheel not in self._newest or self._newest[wheel].stamp != now]

    def expired(self, now: int) -> list[str]:
        """Return the wheels that once had a command and have none in force at the plant's stamp `now` [ns]."""
        return [wheel for wheel, newest in self._newest.items() if now > newest.expires]

    def commands(self, now: int) -> NDArray[np.int64]:
        """Return the command in force for each wheel at the plant's stamp `now` [ns]; NONE where there is none."""
        return np.array([int(self._in_force(wheel, now)) for wheel in self._wheels], dtype=np.int64)

    def _in_force(self, wheel: str, now: int) -> Command:
        newest = self._newest.get(wheel)
        return Command.NONE if newest is None or now > newest.expires else newest.command


def _seconds(nanoseconds: int) -> str:
    return f"{nanoseconds / NANOSECONDS:.3f}"


class DemandInbox:
    """The driver's demand by topic: the last value holds, for all wheels or one by one."""

    def __init__(self, wheels: Sequence[str]) -> None:
        """Start without demand."""
        self._wheels = tuple(wheels)
        self.pressure: NDArray[np.float64] = np.zeros(len(self._wheels))
        """Demand for each wheel [Pa]."""

    def take(self, message: BrakeDemand) -> str | None:
        """Take a message; return why it is refused."""
        if message.wheel and message.wheel not in self._wheels:
            return f"brake_demand: unknown wheel '{message.wheel}', known are {', '.join(self._wheels)}; refused"
        if not isfinite(message.pressure) or message.pressure < 0.0:
            return f"brake_demand: pressure {message.pressure} Pa must be finite and >= 0, refused"
        pressure = self.pressure.copy()
        pressure[[not message.wheel or wheel == message.wheel for wheel in self._wheels]] = message.pressure
        self.pressure = pressure
        return None
