"""<wheel>/brake_pressure of every wheel as brake torques, held back so that the order of arrival does not matter."""

from collections.abc import Mapping
from math import nan

from sensor_msgs.msg import FluidPressure

from friction_runtime.wheel_inputs import BrakeTorque
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import Vehicle
from wheel_slip.speed_queue import WAIT, SpeedQueue


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
        self._queues: dict[str, SpeedQueue[float]] = {topic: SpeedQueue(WAIT) for topic in self._brakes}
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
