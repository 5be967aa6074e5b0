"""Inputs of the wheels from messages: speeds by the names of joints, brake torque T_b = k p (1.1) from pressure."""

from collections.abc import Sequence
from math import nan
from sys import maxsize
from typing import Final

from sensor_msgs.msg import FluidPressure, JointState

from friction_runtime.messages import to_nanoseconds
from friction_runtime.processor import Report
from sensor_monitor.pressure_unit import PressureUnit
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.physical_bounds import HIGHEST_PRESSURE, HIGHEST_TORQUE, HIGHEST_WHEEL_SPEED
from vehicle_models.vehicle import Vehicle

WHEEL_STATES: Final = "wheel_states"


class WheelSpeeds:
    """Reads the wheels of a car, or some of them, by the names of their joints.

    Names seldom change from one message to the next, so indices are looked up only when they do. If a name occurs
    twice, the first one counts.
    """

    def __init__(self, vehicle: Vehicle, wheels: Sequence[str], report: Report) -> None:
        """Choose wheels of the car; missing wheels, and joints that are not wheels, go to `report`.

        Only the reader of the first wheel reports other joints, so that they are reported once.
        """
        self._wheels = tuple(vehicle.wheel(name) for name in wheels)
        self._joints = set(vehicle.joints)
        self._report = report
        self._notes_others = vehicle.wheel_names[0] in wheels
        self._names: list[str] = []
        self._seen: set[str] = set()
        """Names of all messages so far."""
        self._places = [maxsize] * len(self._wheels)

    def read(self, message: JointState) -> tuple[float, ...]:
        """Return the speeds [rad/s] in the order of the wheels, NaN where one is missing or garbage."""
        if message.name != self._names:
            self._look_up(list(message.name))
        velocities: list[float] = message.velocity.tolist()
        count = len(velocities)
        speeds = tuple([velocities[place] if place < count else nan for place in self._places])
        for speed in speeds:
            if not abs(speed) <= HIGHEST_WHEEL_SPEED:
                return self._without_garbage(speeds, count)
        return speeds

    def _look_up(self, names: list[str]) -> None:
        self._names = names
        self._seen.update(names)
        place_of = {name: place for place, name in reversed(list(enumerate(names)))}
        self._places = [place_of.get(wheel.joint, maxsize) for wheel in self._wheels]
        others = [name for name in names if name not in self._joints]
        if others and self._notes_others and len(others) < len(names):
            self._notes_others = False
            self._report("info", f"{WHEEL_STATES}: not wheels of the car, ignored: {', '.join(others)}")

    def _without_garbage(self, speeds: tuple[float, ...], count: int) -> tuple[float, ...]:
        for wheel, place, speed in zip(self._wheels, self._places, speeds, strict=True):
            if place >= count:
                joint = "" if wheel.joint == wheel.name else f" (joint '{wheel.joint}')"
                advice = (
                    "it is in other messages: two senders? Merge them with friction_adapter"
                    if wheel.joint in self._seen.difference(self._names)
                    else "check the vehicle file"
                )
                self._report(
                    "error",
                    f"{WHEEL_STATES}: no velocity for wheel '{wheel.name}'{joint}, names are: "
                    f'"{", ".join(self._names)}"; {advice}',
                )
            elif not abs(speed) <= HIGHEST_WHEEL_SPEED:
                self._report(
                    "warning", f"{WHEEL_STATES}: velocity of wheel '{wheel.name}' is not a wheel speed: {speed}"
                )
        return tuple(speed if abs(speed) <= HIGHEST_WHEEL_SPEED else nan for speed in speeds)


class BrakeTorque:
    """Reads the pressure of one wheel."""

    def __init__(self, vehicle: Vehicle, wheel: str) -> None:
        """Choose a wheel of the car."""
        self.topic = f"{wheel}/brake_pressure"
        self._gain = vehicle.wheel(wheel).brake_gain
        self._delay = round(vehicle.brake_pressure_delay * NANOSECONDS)
        self._unit = PressureUnit(vehicle, wheel)

    def read(self, message: FluidPressure) -> tuple[int, float] | str:
        """Return the time at which the pressure acted [ns] and its torque [N m], or why the message is refused."""
        acted = to_nanoseconds(message.header.stamp) - self._delay
        torque = self.torque(self.topic, message.fluid_pressure)
        if isinstance(torque, str):
            self._unit.refuse(acted, message.fluid_pressure)
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
        self._unit.update(stamp, wheel_speed, torque / self._gain)
        return f"{self.topic}: {self._unit.text}" if self._unit.text else ""

    def reset(self) -> None:
        """Know nothing of the unit."""
        self._unit.reset()
