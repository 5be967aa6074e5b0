"""Brake torque of a wheel from <wheel>/brake_pressure messages, T_b = k p (1.1)."""

from sensor_msgs.msg import FluidPressure

from friction_runtime.pressure_watch import PressureWatch
from friction_runtime.stamps import to_nanoseconds
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.physical_bounds import HIGHEST_PRESSURE, HIGHEST_TORQUE
from vehicle_models.vehicle import Vehicle


class BrakeTorque:
    """Reads the pressure of one wheel."""

    def __init__(self, vehicle: Vehicle, wheel: str) -> None:
        """Choose a wheel of the car."""
        self.topic = f"{wheel}/brake_pressure"
        self._gain = vehicle.wheel(wheel).brake_gain
        self._delay = round(vehicle.brake_pressure_delay * NANOSECONDS)
        self._watch = PressureWatch(vehicle, wheel)

    def read(self, message: FluidPressure) -> tuple[int, float] | str:
        """Return the time at which the pressure acted [ns] and its torque [N m], or why the message is refused."""
        acted = to_nanoseconds(message.header.stamp) - self._delay
        torque = self.torque(self.topic, message.fluid_pressure)
        if isinstance(torque, str):
            self._watch.refuse(acted, message.fluid_pressure)
            return torque
        return acted, torque

    def torque(self, topic: str, pressure: float) -> float | str:
        """Return the torque [N m] of a pressure [Pa], or why the message on `topic` is refused."""
        torque = self._gain * pressure
        if not (abs(pressure) <= HIGHEST_PRESSURE and abs(torque) <= HIGHEST_TORQUE):
            return f"{topic}: {pressure} Pa is not a brake pressure"
        return torque

    def wrong_unit(self, stamp: int, wheel_speed: float, torque: float) -> str:
        """Return which unit the pressure seems to have in place of Pa, with its topic; empty where none.

        Args:
            stamp: stamp of the sample [ns].
            wheel_speed: speed of the wheel [rad/s]; not finite where it is missing.
            torque: torque at the stamp [N m], NaN where it is missing.
        """
        return self._watch.judge(stamp, wheel_speed, torque / self._gain)

    def reset(self) -> None:
        """Know nothing of the unit."""
        self._watch.reset()
