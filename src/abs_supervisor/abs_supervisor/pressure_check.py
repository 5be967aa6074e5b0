"""Brake pressure against demand and commands: what the hydraulics would do with them.

The pressure may be late by the delay of the hydraulics and some more, so it is compared with a band: the least and the
largest torque that the model has had of late. Where the model has settled at the demand, the mean deviation is judged
too: noise and delay do not enter it, so that a weaker braking can be judged.
"""

from collections import deque
from math import nan
from typing import Final

from friction_runtime.filters import Debounce, SlidingWindow
from vehicle_models.brake_actuator import ActuatorParameters, Command
from vehicle_models.nanoseconds import NANOSECONDS

_LATE: Final = 0.025
"""[s] by which a pressure may be later than the delay of the hydraulics."""
_SHARE: Final = 0.2
"""Of the torque that is expected, by which it may be wrong."""
_LEAST: Final = 30.0
"""[N m] by which the torque may be wrong in any case."""
_OFFSET: Final = 15.0
"""[N m] the same for the mean of a torque that has settled; with `_SHARE`, half a pressure is seen from 50 N m on."""
_JUDGED: Final = 50.0
"""[N m] a smaller torque is not judged by its mean: 'braking_torque' as shipped, below which nothing is commanded."""
_STILL: Final = 5.0
"""[N m] by which the band is wide at most where the torque has settled."""
_SETTLED: Final = 0.15
"""[s] for which it has."""
_MEMORY: Final = 30
"""Samples over which it is averaged: the noise of the mean is a fifth of that of a sample."""
_LASTS: Final = 0.025
"""[s] a deviation that lasts so long is one."""
_FORGETS: Final = 0.25
"""[s] in which the model follows a pressure that is right: a command that came late to the brake is not remembered."""
_CLEAN: Final = 1.0
"""[s] without deviation after which the pressure counts as right again."""
_GAP: Final = 0.1
"""[s] after a longer gap the model starts again from the pressure that is measured."""


class PressureCheck:
    """Follows one wheel's brake. `update` returns what is wrong with its pressure, empty where nothing is."""

    def __init__(self, actuator: ActuatorParameters) -> None:
        """Choose the hydraulics."""
        self._p = actuator
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._line: deque[tuple[int, float, Command]] = deque()
        self._order: tuple[float, Command] = (0.0, Command.NONE)
        self._band: SlidingWindow[float] = SlidingWindow(_LATE * NANOSECONDS)
        self._model = nan
        self._last: int | None = None
        self._dt = 0.0
        self._wrong = Debounce(_LASTS * NANOSECONDS)
        self._named: int | None = None
        self._at_demand = Debounce(_SETTLED * NANOSECONDS)
        self._mean, self._averaged = 0.0, 0
        self.text = ""
        """What is wrong, empty where nothing is."""

    def update(self, stamp: int, torque: float, demand: float) -> str:
        """Compare the measured torque [N m] at a stamp [ns] with the demand [N m]; both are finite."""
        self._advance(stamp, torque)
        self._band.append(stamp, self._model)
        low, high = min(each for _, each in self._band), max(each for _, each in self._band)
        allowed = _LEAST + _SHARE * max(high, 0.0)
        below, above = torque < low - allowed, torque > high + allowed
        if self._settled(stamp, torque, low, high) and abs(self._mean) > _OFFSET + _SHARE * high:
            self._named = stamp
            self.text = f"{high + self._mean:.0f} N m for {_SETTLED} s, where the demand gives {high:.0f} N m"
        if not (below or above):
            self._model += (torque - self._model) * min(self._dt / _FORGETS, 1.0)
        if self._wrong.update(stamp, below or above):
            self._named = stamp
            self.text = f"{torque:.0f} N m, where demand and commands give {low:.0f} to {high:.0f} N m"
        elif self._named is not None and stamp - self._named > _CLEAN * NANOSECONDS:
            self._named, self.text = None, ""
        return self.text

    def _settled(self, stamp: int, torque: float, low: float, high: float) -> bool:
        """Average the deviation while the model stays at the demand; return whether it did for long enough."""
        if self._order[1] in (Command.HOLD, Command.DECREASE) or low < max(high - _STILL, _JUDGED):
            self._at_demand.reset()
            return False
        if self._at_demand.since is None:
            self._averaged = 0
        self._averaged = min(self._averaged + 1, _MEMORY)
        self._mean += (torque - self._model - self._mean) / self._averaged
        return self._at_demand.update(stamp, True)

    def commanded(self, stamp: int, demand: float, command: Command) -> None:
        """Take the command that was given for a stamp [ns], and the demand [N m] it came with. Comes after `update`."""
        self._line.append((stamp + round(self._p.delay * NANOSECONDS), demand, command))

    def _advance(self, stamp: int, torque: float) -> None:
        if self._last is None or stamp - self._last > _GAP * NANOSECONDS:
            self._model = max(torque, 0.0)
            self._line.clear()
            self._band.clear()
            self._at_demand.reset()
            self._last, self._dt = stamp, 0.0
            return
        dt = self._dt = (stamp - self._last) / NANOSECONDS
        self._last = stamp
        while self._line and self._line[0][0] < stamp:
            _, demand, command = self._line.popleft()
            self._order = (demand, command)
        demand, command = self._order
        target = {Command.DECREASE: 0.0, Command.HOLD: self._model}.get(command, max(demand, 0.0))
        rise, fall = self._p.apply_rate * dt, self._p.release_rate * dt
        self._model += min(max(target - self._model, -fall), rise)
