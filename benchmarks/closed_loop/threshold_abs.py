"""A classical ABS for comparison: thresholds of the wheel's acceleration and of its slip, the same for every road.

The cycle is the textbook's (Bosch, Automotive Handbook, antilock braking systems): pressure is held when the wheel
decelerates hard, released when it slips as well, held until it has come back, and then applied again in steps. It has
the slip of wheel_slip, as the other laws. Tuned on seed 1000 of the noise, with the true slip, by a random search over
its thresholds for the largest mean utilisation of the four roads without a lock.
"""

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from math import isfinite
from typing import Any

from friction_msgs.msg import BrakeCommand, BrakeDemand, WheelSlip

from benchmarks.protocol import DT
from friction_runtime.processor import Health, Output
from vehicle_models.brake_actuator import Command

THRESHOLDS = "threshold"
"""Name of this law."""
_WINDOW = 5
"""Samples over which the acceleration is taken."""


@dataclass(frozen=True)
class Thresholds:
    """Of the wheel's circumference and of its slip."""

    deceleration: float = 54.0
    """[m/s^2] from which on the pressure is not raised."""
    slip: float = 0.29
    """With which it is lowered."""
    comes_back: float = -2.5
    """[m/s^2] of acceleration with which a release ends."""
    accelerates: float = 58.0
    """[m/s^2] of acceleration with which the pressure is held while a wheel comes back."""
    step: int = 4
    """Samples from step to step when the pressure is applied again."""
    least_speed: float = 1.5
    """[m/s] below which the driver has the brake."""


class _Phase(Enum):
    FIRST = 0
    RELEASE = 1
    RETURN = 2
    STEPS = 3


class ThresholdAbs:
    """Commands one wheel; a processor of the graph that fires on <wheel>/slip."""

    def __init__(self, wheel: str, radius: float, thresholds: Thresholds = Thresholds()) -> None:
        """Choose a wheel of an effective radius [m]."""
        self._wheel, self._radius, self._t = wheel, radius, thresholds
        self.sensors: Mapping[str, type] = {"brake_demand": BrakeDemand}
        self.estimates: Mapping[str, type] = {f"{wheel}/slip": WheelSlip}
        self.outputs: Mapping[str, type] = {f"{wheel}/brake_command": BrakeCommand}
        self.optional: Sequence[str] = ()
        self.reset()

    def reset(self) -> None:
        """Start again."""
        self._braking = False
        self._speeds: deque[float] = deque(maxlen=_WINDOW)
        self._phase, self._count = _Phase.FIRST, 0

    def watch(self, ages: Mapping[str, float], now: float) -> Sequence[Output]:
        """Do nothing: it runs offline."""
        return []

    def health(self) -> Health:
        """Return the phase."""
        return Health(self._wheel, message=self._phase.name)

    def process(self, topic: str, message: Any) -> Sequence[Output]:
        """Take a message; return the command for a slip."""
        if topic == "brake_demand":
            self._braking = message.pressure > 0.0
            return []
        command = BrakeCommand(header=message.header, wheel=self._wheel, valid_for=1.0)
        command.command = int(self._command(message))
        return [(f"{self._wheel}/brake_command", command)]

    def _command(self, message: WheelSlip) -> Command:
        self._speeds.append(message.wheel_speed)
        if not self._braking or not message.vehicle_speed > self._t.least_speed:
            self._phase = _Phase.FIRST
            return Command.NONE
        t, speeds = self._t, self._speeds
        acceleration = self._radius * (speeds[-1] - speeds[0]) / (DT * max(len(speeds) - 1, 1))
        slips = isfinite(message.slip) and message.slip > t.slip
        dives = acceleration < -t.deceleration
        if self._phase in (_Phase.FIRST, _Phase.STEPS):
            if slips and acceleration < t.comes_back:
                self._phase = _Phase.RELEASE
        elif self._phase is _Phase.RELEASE and acceleration > t.comes_back:
            self._phase = _Phase.RETURN
        elif self._phase is _Phase.RETURN and not slips and acceleration < t.accelerates:
            self._phase, self._count = _Phase.STEPS, 0
        elif self._phase is _Phase.RETURN and slips and acceleration < t.comes_back:
            self._phase = _Phase.RELEASE
        if self._phase is _Phase.RELEASE:
            return Command.DECREASE
        if self._phase is _Phase.RETURN or dives:
            return Command.HOLD
        if self._phase is _Phase.STEPS:
            self._count += 1
            return Command.INCREASE if self._count % t.step == 0 else Command.HOLD
        return Command.INCREASE
