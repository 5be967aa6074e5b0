"""Whether the accelerometer may be used: it is left out where it is stuck, comes too late, or is outvoted."""

from collections.abc import Sequence

from wheel_slip.accelerometer_age import AccelerometerAge
from wheel_slip.mode import SlideParameters
from wheel_slip.outvoted import Outvoted
from wheel_slip.stuck_sensor import StuckSensor


class AccelerometerWatch:
    """The accelerometer of one car."""

    def __init__(self, parameters: SlideParameters) -> None:
        """Start without samples; the parameters say when wheels turn alike."""
        self._repetition = StuckSensor()
        self._age = AccelerometerAge(parameters)
        self.votes = Outvoted()
        """What a speed sensor and the wheels say against it."""
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._repetition.reset()
        self._age.reset()
        self.votes.reset()
        self._is_stuck = self._is_outvoted = False

    @property
    def text(self) -> str:
        """Why it is left out, empty where it is used."""
        if self._is_stuck:
            return "repeats one value that the wheels contradict"
        if self._age.late:
            return f"follows the wheels {self._age.late:.1f} s late"
        return "contradicts both the speed sensor and the wheels" if self._is_outvoted else ""

    def leaves_out(
        self, stamp: int, acceleration: float | None, rim_speeds: Sequence[float], a_wheel_rolls: bool
    ) -> bool:
        """Take one sample; return whether it must not be used.

        Args:
            stamp: [ns], later than the last.
            acceleration: reading [m/s^2], None if there is none.
            rim_speeds: filtered r omega of the wheels [m/s], NaN where unknown.
            a_wheel_rolls: whether a wheel rolled at the last sample, by what the accelerometer read.
        """
        self._is_stuck = self._repetition.repeats(stamp, acceleration) and (self._is_stuck or not a_wheel_rolls)
        if acceleration is not None and not self._is_stuck:
            self._age.update(stamp, rim_speeds, acceleration)
        self._is_outvoted = self.votes.holds(stamp)
        return self._is_stuck or self._is_outvoted or self._age.late > 0.0
