"""Records of any source as messages of this graph."""

from array import array
from collections.abc import Callable, Mapping, Sequence
from math import isnan
from typing import Any

from friction_msgs.msg import BrakeDemand
from geometry_msgs.msg import TwistWithCovarianceStamped, Vector3
from sensor_msgs.msg import FluidPressure, Imu, JointState

from friction_adapter.adapter import Adapter, Target
from friction_adapter.signal_map import (
    BRAKE_DEMAND,
    BRAKE_PRESSURE,
    BRAKE_TORQUE_REQUEST,
    IMU,
    VEHICLE_VELOCITY,
    WHEEL_STATES,
    SignalMap,
)
from friction_adapter.sources import Sources
from friction_runtime.messages import header_at
from friction_runtime.processor import Output
from vehicle_models.vehicle import Vehicle

Maker = Callable[[int, Sequence[float]], Any]
"""Makes a message from its stamp [ns] and the values of the target."""
MESSAGE_TYPES: Mapping[str, type] = {
    WHEEL_STATES: JointState,
    IMU: Imu,
    VEHICLE_VELOCITY: TwistWithCovarianceStamped,
    BRAKE_PRESSURE: FluidPressure,
    BRAKE_DEMAND: BrakeDemand,
    BRAKE_TORQUE_REQUEST: JointState,
}
_FRAME = "base_link"
_UNKNOWN = -1.0
"""First element of a covariance of sensor_msgs/Imu whose quantity is not measured."""


def maker(target: Target, stddevs: Mapping[str, float], vehicle: Vehicle) -> Maker:
    """Return what makes the messages of a target.

    What was not measured is left at its default: covariances are zero, the orientation is marked as unknown. A rate
    that is NaN is marked likewise.

    Args:
        target: the target.
        stddevs: standard deviation by its parts, where known.
        vehicle: the car.
    """
    variances = {part: stddev**2 for part, stddev in stddevs.items()}
    if target.message == WHEEL_STATES:
        return _wheel_states_maker([vehicle.wheel(wheel).joint for wheel in target.parts])
    if target.message == IMU:
        return _imu_maker(variances.get("acceleration", 0.0), vehicle.accelerometer.axis)
    if target.message == VEHICLE_VELOCITY:
        return _velocity_maker(variances.get("speed", 0.0))
    if target.message == BRAKE_PRESSURE:
        return _pressure_maker(target.wheel, variances.get(BRAKE_PRESSURE, 0.0))
    if target.message == BRAKE_DEMAND:
        return lambda stamp, values: BrakeDemand(header=header_at(stamp, _FRAME), pressure=values[0])
    return lambda stamp, values: JointState(header=header_at(stamp, ""), name=["all_wheels"], effort=list(values))


def _wheel_states_maker(joints: list[str]) -> Maker:
    def make(stamp: int, values: Sequence[float]) -> JointState:
        message = JointState()
        message.header = header_at(stamp, "")
        message.name = joints
        message.velocity = array("d", values)
        return message

    return make


def _pressure_maker(wheel: str, variance: float) -> Maker:
    def make(stamp: int, values: Sequence[float]) -> FluidPressure:
        message = FluidPressure()
        message.header = header_at(stamp, wheel)
        message.fluid_pressure = values[0]
        message.variance = variance
        return message

    return make


def _imu_maker(variance: float, axis: str) -> Maker:
    """The accelerometer along the car is on the axis that the vehicle file names."""
    across = "x" if axis == "y" else "y"
    unknown = _covariance(0, _UNKNOWN)
    measured = _covariance("xyz".index(axis), variance)

    def make(stamp: int, values: Sequence[float]) -> Imu:
        forward, leftward, yaw_rate = values
        acceleration, rates = Vector3(), Vector3()
        setattr(acceleration, axis, forward)
        if not isnan(leftward):
            setattr(acceleration, across, leftward)
        if not isnan(yaw_rate):
            rates.z = yaw_rate
        message = Imu()
        message.header = header_at(stamp, _FRAME)
        message.orientation_covariance = unknown
        message.linear_acceleration = acceleration
        message.linear_acceleration_covariance = measured
        message.angular_velocity = rates
        if isnan(yaw_rate):
            message.angular_velocity_covariance = unknown
        return message

    return make


def _covariance(place: int, value: float) -> Any:
    """Return a covariance of sensor_msgs/Imu that is zero but for one number on its diagonal."""
    covariance = Imu().orientation_covariance
    covariance[4 * place] = value
    return covariance


def _velocity_maker(variance: float) -> Maker:
    def make(stamp: int, values: Sequence[float]) -> TwistWithCovarianceStamped:
        forward, leftward = values
        message = TwistWithCovarianceStamped()
        message.header = header_at(stamp, _FRAME)
        message.twist.twist.linear.x = forward
        message.twist.covariance[0] = variance
        if not isnan(leftward):
            message.twist.twist.linear.y = leftward
        return message

    return make


class RecordMapper:
    """Takes messages, frames or rows; returns messages."""

    def __init__(self, signal_map: SignalMap, sources: Sources) -> None:
        """Find every signal.

        Raises:
            ParameterError: one is not there; the text names file, line and what there is.
        """
        self._adapter = Adapter(signal_map, sources)
        self._topics = [target.topic for target in self._adapter.targets]
        self._makers = [
            maker(target, stddevs, signal_map.vehicle)
            for target, stddevs in zip(self._adapter.targets, self._adapter.stddevs, strict=True)
        ]
        self.sources = self._adapter.sources
        """Names of the sources that are needed."""
        self.outputs: Mapping[str, type] = {
            target.topic: MESSAGE_TYPES[target.message] for target in self._adapter.targets
        }
        """Relative topics and types of the messages."""

    def take(self, source: str, record: Any, arrival: int) -> list[Output]:
        """Take a record of a source that arrived or was recorded at a time [ns]; return the messages it completes."""
        made = self._adapter.take(source, record, arrival)
        return [(self._topics[each.target], self._makers[each.target](each.stamp, each.values)) for each in made]

    def reset(self) -> None:
        """Start again, as after construction."""
        self._adapter.reset()

    def never_read(self) -> list[str]:
        """Return a sentence for each signal of the map that has not had one value so far."""
        return [f"{title} has not one value" for title in sorted(self._adapter.silent)]

    def problems_at_end(self) -> dict[str, int]:
        """Return the problems of a log that has been read, and 0 for those signals that never had a value."""
        return self.problems() | dict.fromkeys(self.never_read(), 0)

    def problems(self) -> dict[str, int]:
        """Return how often something could not be used so far, by what it is; without what never happened."""
        units = {
            f"stamps of {source} run as if they were {unit}: 'stamp_unit: {unit}' in the map?": 1
            for source, unit in self._adapter.mistaken_units.items()
        }
        found = {
            **units,
            **{f"no value for {title}": count for title, count in self._adapter.unreadable.items()},
            "stamp that no message can hold": self._adapter.refused,
            "instant without one of its messages": self._adapter.incomplete,
        }
        return {text: count for text, count in found.items() if count}
