"""Samples of speed sensor and brakes, held back in message time so that the order of arrival does not matter.

The output never waits for them: it comes with the wheel speeds (and the accelerometer), and a sample is used, at its
own time, in the first output whose stamp is WAIT past its own. What arrives within WAIT of message time is thus used in
the same output whether it overtook other topics or was overtaken.
"""

from collections import deque
from collections.abc import Iterator, Mapping
from math import nan
from typing import Final, Generic, TypeVar

from sensor_msgs.msg import FluidPressure

from friction_runtime.wheel_inputs import BrakeTorque
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.physical_bounds import LATEST_STAMP, NEW_RUN
from vehicle_models.vehicle import Vehicle

WAIT: Final = 0.02
"""Message time after which a sample of vehicle_velocity or of a brake pressure is used [s]."""
_WAIT_NS: Final = round(WAIT * NANOSECONDS)
Payload = TypeVar("Payload")


class HeldSamples(Generic[Payload]):
    """Queue between the stream of a sensor and the stamps of the outputs.

    A jump back in time starts a new epoch of either stream; samples meet outputs of the same epoch only. A stream that
    jumps alone meets the other again after WAIT.
    """

    def __init__(self) -> None:
        """Start empty."""
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._held: deque[tuple[int, int, Payload]] = deque()
        self._newest: int | None = None
        self._epoch = 0
        self._output_epoch = 0
        self._apart_since: int | None = None
        self._output: int | None = None
        self.late = 0
        """Samples that came after the output they were due in, or after a newer one."""

    def offer(self, stamp: int, payload: Payload) -> str | None:
        """Take a sample with its stamp [ns]; return the reason if it is refused."""
        if stamp <= 0:
            return "stamp is zero"
        if stamp > LATEST_STAMP:
            return "stamp is out of range"
        if stamp == self._newest:
            return "stamp repeats"
        if self._newest is not None and stamp < self._newest:
            if self._newest - stamp < NEW_RUN:
                self.late += 1
                return "late sample"
            self._epoch += 1
            self._apart_since = None
        self._newest = stamp
        if self._epoch == self._output_epoch and self._output is not None and stamp + _WAIT_NS <= self._output:
            self.late += 1
        self._held.append((self._epoch, stamp, payload))
        return None

    def due(self, stamp: int, rewound: bool) -> Iterator[tuple[int, Payload]]:
        """Yield the samples (stamp [ns], payload) to be used in the output at `stamp` [ns].

        Args:
            stamp: stamp of the output [ns].
            rewound: whether this is the first output after a jump back in time.
        """
        if rewound:
            self._output_epoch += 1
            self._apart_since = None
        self._output = stamp
        if self._epoch != self._output_epoch:
            self._meet(stamp)
        while self._held and self._held[0][0] < self._output_epoch:
            self._held.popleft()
        while self._held and self._held[0][0] == self._output_epoch and self._held[0][1] + _WAIT_NS <= stamp:
            _, when, payload = self._held.popleft()
            yield when, payload

    def _meet(self, stamp: int) -> None:
        """Handle a jump of one stream only: after a while without a jump of the other, they belong together again."""
        if self._apart_since is None:
            self._apart_since = stamp
        if stamp - self._apart_since >= _WAIT_NS:
            self._output_epoch = self._epoch
            self._held = deque(entry for entry in self._held if entry[0] == self._epoch and entry[1] <= stamp)
            self._apart_since = None


class BrakePressures:
    """Reads the brakes of one car; any of them may never come."""

    def __init__(self, vehicle: Vehicle, oldest: float) -> None:
        """Choose a car and the age [s] beyond which a pressure says nothing."""
        self._brakes = {brake.topic: brake for brake in (BrakeTorque(vehicle, wheel) for wheel in vehicle.wheel_names)}
        self.sensors: Mapping[str, type] = dict.fromkeys(self._brakes, FluidPressure)
        self._oldest = round((oldest + WAIT) * NANOSECONDS)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._queues: dict[str, HeldSamples[float]] = {topic: HeldSamples() for topic in self._brakes}
        self._newest: dict[str, tuple[int, float]] = {}

    def offer(self, topic: str, message: FluidPressure) -> str | None:
        """Take a pressure; return why it is refused."""
        read = self._brakes[topic].read(message)
        if isinstance(read, str):
            return read
        refusal = self._queues[topic].offer(*read)
        return None if refusal is None else f"{topic}: {refusal}"

    def torques(self, stamp: int, rewound: bool) -> list[float]:
        """Return the torque of every brake WAIT before a stamp [ns], in N m: NaN where unknown, empty if all are.

        `rewound`: whether it is the first stamp after a jump back in time.
        """
        if rewound:
            self._newest.clear()
        for topic, queue in self._queues.items():
            for when, torque in queue.due(stamp, rewound):
                self._newest[topic] = (when, torque)
        if not self._newest:
            return []
        never = (0, nan)
        known = [self._newest.get(topic, never) for topic in self._brakes]
        return [torque if stamp - when <= self._oldest else nan for when, torque in known]
