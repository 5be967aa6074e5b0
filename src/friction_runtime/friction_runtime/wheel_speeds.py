"""Speeds of chosen wheels from wheel_states messages."""

from collections.abc import Sequence
from math import nan
from sys import maxsize

from sensor_msgs.msg import JointState

from friction_runtime.processor import Report

WHEEL_STATES = "wheel_states"
_FASTEST = 1000.0
"""[rad/s]; what is beyond is garbage, not a measurement."""


class WheelSpeeds:
    """Reads the wheels of one car, or one of them; other joints are ignored.

    Names seldom change from one message to the next: places are looked up when they do. Of a name that stands twice
    the first counts.
    """

    def __init__(self, wheels: Sequence[str], report: Report) -> None:
        """Name the wheels; `report` is told of those that a message lacks."""
        self._wheels = tuple(wheels)
        self._report = report
        self._names: list[str] = []
        self._places = [maxsize] * len(self._wheels)

    def read(self, message: JointState) -> tuple[float, ...]:
        """Speeds [rad/s] in the order of the wheels, NaN where one is missing or garbage."""
        if message.name != self._names:
            self._names = list(message.name)
            place_of = {name: place for place, name in reversed(list(enumerate(self._names)))}
            self._places = [place_of.get(wheel, maxsize) for wheel in self._wheels]
        velocities = message.velocity.tolist()
        count = len(velocities)
        speeds = tuple([velocities[place] if place < count else nan for place in self._places])
        for speed in speeds:
            if not abs(speed) <= _FASTEST:
                return self._without_garbage(speeds, count)
        return speeds

    def _without_garbage(self, speeds: tuple[float, ...], count: int) -> tuple[float, ...]:
        for wheel, place, speed in zip(self._wheels, self._places, speeds, strict=True):
            if place >= count:
                self._report(
                    "error",
                    f"{WHEEL_STATES}: no velocity for wheel '{wheel}', names are: {', '.join(self._names)}; "
                    "check the parameter 'wheels'",
                )
            elif not abs(speed) <= _FASTEST:
                self._report("warning", f"{WHEEL_STATES}: velocity of wheel '{wheel}' is no wheel speed: {speed}")
        return tuple(speed if abs(speed) <= _FASTEST else nan for speed in speeds)
