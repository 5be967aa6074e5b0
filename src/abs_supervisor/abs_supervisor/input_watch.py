"""Whether the inputs of a supervisor that commands can be relied upon now: progress of their stamps against the clock.

The supervisor listens to the sensors themselves, not only to what friction_slope makes of them: so a lost sensor is
known within 50 ms and its own period, however long the nodes between wait for each other.
"""

from collections.abc import Mapping
from math import inf, isfinite
from typing import Any

from sensor_msgs.msg import FluidPressure, JointState

from abs_supervisor.supervisor import Reason
from friction_runtime.brake_torque import BrakeTorque
from friction_runtime.processor import silent
from friction_runtime.stamp_progress import StampProgress
from friction_runtime.stamps import to_nanoseconds
from friction_runtime.wheel_speeds import WHEEL_STATES, WheelSpeeds
from vehicle_models.vehicle import Vehicle

_HEARTBEAT = 0.009
"""A command is repeated when the last is older at a watch [s]: the watch comes every 10 ms, a command every 20 ms."""
Loss = tuple[Reason, str]
"""Why the supervisor may not act, and the text that names the topic."""


class InputWatch:
    """Follows wheel speed, pressure, demand and slope of one wheel: `note` each message, `poll` with the clock."""

    def __init__(self, vehicle: Vehicle, wheel: str, demand: str, slope: str) -> None:
        """Choose a wheel of the car, and the topics of the demand and of its slope."""
        self._wheel = wheel
        self._brake_torque = BrakeTorque(vehicle, wheel)
        self._wheel_speeds = WheelSpeeds(vehicle, (wheel,), silent)
        self._pressure, self._demand, self._slope = self._brake_torque.topic, demand, slope
        self.sensors: Mapping[str, type] = {WHEEL_STATES: JointState, self._pressure: FluidPressure}
        """Topics of the sensors and their types."""
        # In the order in which they are named: the loss of a sensor brings that of the slope.
        self._reasons = {
            WHEEL_STATES: Reason.NO_WHEEL_SPEED,
            self._pressure: Reason.NO_PRESSURE,
            demand: Reason.NO_PRESSURE if demand == self._pressure else Reason.NO_DEMAND,
            slope: Reason.NO_SLOPE,
        }
        self._inputs = {topic: StampProgress() for topic in self._reasons}
        self.loss: Loss | None = None
        """The first input that is lost, at the last poll; None where all are there, and before the first poll."""

    def note(self, topic: str, message: Any) -> None:
        """Take any message of the processor; content that is refused is no progress."""
        progress = self._inputs.get(topic)
        if progress is not None and self._is_good(topic, message):
            progress.note(to_nanoseconds(message.header.stamp))

    def poll(self, ages: Mapping[str, float], now: float) -> Loss | None:
        """Look at the clock: `ages` of the topics and time `now` of Processor.watch; return `loss`."""
        self.loss = None
        for topic, progress in self._inputs.items():
            if progress.poll(now, ages.get(topic, inf)) and self.loss is None:
                self.loss = self._reasons[topic], _text(topic, progress, ages.get(topic, inf))
        return self.loss

    def is_old(self, stamp: int) -> bool:
        """Whether a slope with this stamp [ns] waited in a queue for so long that no answer is of use any more."""
        return self._inputs[self._slope].is_old(stamp)

    def wants_heartbeat(self, ages: Mapping[str, float], commanded: bool) -> bool:
        """Whether the last command is to be repeated; `commanded` tells if there was one since the last poll."""
        return not commanded or ages.get(self._slope, inf) > _HEARTBEAT

    def _is_good(self, topic: str, message: Any) -> bool:
        if topic == WHEEL_STATES:
            (speed,) = self._wheel_speeds.read(message)
            return isfinite(speed)
        if topic == self._pressure:
            return not isinstance(self._brake_torque.torque(topic, message.fluid_pressure), str)
        if topic == self._demand:
            ours = message.wheel in ("", self._wheel)
            return ours and not isinstance(self._brake_torque.torque(topic, message.pressure), str)
        return True


def _text(topic: str, progress: StampProgress, age: float) -> str:
    if not progress.came:
        return f"{topic}: no message yet"
    if age > 2.0 * progress.period:
        return f"{topic}: no message for {age:.3f} s"
    if progress.lag > progress.period:
        return f"{topic}: newest good stamp is {progress.lag:.3f} s behind the clock"
    return f"{topic}: stamps do not progress with the clock yet"
