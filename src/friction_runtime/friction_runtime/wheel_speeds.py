"""Speeds of the wheels of a car from wheel_states messages."""

from collections.abc import Sequence
from math import nan
from sys import maxsize
from typing import Final

from sensor_msgs.msg import JointState

from friction_runtime.processor import Report
from vehicle_models.physical_bounds import HIGHEST_WHEEL_SPEED
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
                self._report(
                    "error",
                    f"{WHEEL_STATES}: no velocity for wheel '{wheel.name}'{joint}, names are: "
                    f'"{", ".join(self._names)}"; check the vehicle file',
                )
            elif not abs(speed) <= HIGHEST_WHEEL_SPEED:
                self._report(
                    "warning", f"{WHEEL_STATES}: velocity of wheel '{wheel.name}' is not a wheel speed: {speed}"
                )
        return tuple(speed if abs(speed) <= HIGHEST_WHEEL_SPEED else nan for speed in speeds)
