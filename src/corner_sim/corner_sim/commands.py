"""Inputs of the plant: brake commands of the supervisor and the driver's demand by topic."""

from collections.abc import Sequence
from math import isfinite

import numpy as np
from friction_msgs.msg import BrakeCommand, BrakeDemand
from numpy.typing import NDArray

from friction_runtime.stamps import to_nanoseconds
from vehicle_models.brake_actuator import Command
from vehicle_models.nanoseconds import NANOSECONDS


class CommandInbox:
    """The last brake_command of each wheel."""

    def __init__(self, wheels: Sequence[str], timeout: float) -> None:
        """Start without commands.

        Args:
            wheels: names of the wheels.
            timeout: a command older than this [s of message time] counts as NONE, > 0.
        """
        self._wheels = tuple(wheels)
        self._timeout_ns = round(timeout * NANOSECONDS)
        self._last: dict[str, tuple[int, Command]] = {}

    def take(self, wheel: str, message: BrakeCommand) -> str | None:
        """Take a message from `wheel`'s topic; return why it is refused."""
        topic = f"{wheel}/brake_command"
        if message.wheel != wheel:
            return f"{topic}: message is for wheel '{message.wheel}', refused"
        if message.command not in tuple(Command):
            return f"{topic}: unknown command {message.command}, refused"
        stamp = to_nanoseconds(message.header.stamp)
        if stamp <= 0:
            return f"{topic}: stamp is zero, refused"
        self._last[wheel] = (stamp, Command(message.command))
        return None

    def unanswered(self, stamp_ns: int) -> list[str]:
        """Return the wheels whose last command is not stamped `stamp_ns`."""
        return [wheel for wheel in self._wheels if self._last.get(wheel, (0,))[0] != stamp_ns]

    def stale(self, stamp_ns: int) -> list[str]:
        """Return the wheels that once had a command and now have none younger than the time-out."""
        return [wheel for wheel, (stamp, _) in self._last.items() if stamp_ns - stamp > self._timeout_ns]

    def commands(self, stamp_ns: int) -> NDArray[np.int64]:
        """Return the command in force for each wheel at `stamp_ns`; NONE where there is none or it is stale."""
        stale = self.stale(stamp_ns)
        return np.array(
            [
                int(Command.NONE) if wheel not in self._last or wheel in stale else int(self._last[wheel][1])
                for wheel in self._wheels
            ],
            dtype=np.int64,
        )


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
