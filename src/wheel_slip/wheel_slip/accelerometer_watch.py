"""Accelerometer monitor: rejects readings that are frozen, late, outvoted, or
feels no dive of the wheels.
"""

from collections.abc import Sequence

from wheel_slip.accelerometer_age import AccelerometerAge
from wheel_slip.outvoted import Outvoted
from wheel_slip.stuck_sensor import StuckSensor
from wheel_slip.tuning import SlideTuning
from wheel_slip.unfelt_dive import UnfeltDive


class AccelerometerWatch:
    """The accelerometer of one car."""

    def __init__(self, parameters: SlideTuning, delay: float) -> None:
        """Start without samples.

        Args:
            parameters: when wheels turn alike.
            delay: by how much it may be late as far as is known [s].
        """
        self._repetition = StuckSensor()
        self._age = AccelerometerAge(parameters)
        self._dive = UnfeltDive(delay)
        self.votes = Outvoted()
        """What a speed sensor and the wheels say against it."""
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._repetition.reset()
        self._age.reset()
        self._dive.reset()
        self.votes.reset()
        self._is_stuck = self._is_outvoted = self._is_unfelt = False

    @property
    def text(self) -> str:
        """Why it is left out, empty where it is used."""
        if self._is_stuck:
            return "repeats one value that the wheels contradict"
        if self._age.late:
            return f"follows the wheels {self._age.late:.1f} s late"
        if self._is_unfelt:
            return "read no force while all wheels dived: it is late, or they were wrong"
        return "contradicts both the speed sensor and the wheels" if self._is_outvoted else ""

    def leaves_out(
        self,
        stamp: int,
        acceleration: float | None,
        rim_speeds: Sequence[float],
        rolling: Sequence[bool],
        offset: float,
    ) -> bool:
        """Take one sample; return whether it must not be used.

        Args:
            stamp: [ns], later than the last.
            acceleration: reading [m/s^2], None if there is none.
            rim_speeds: filtered r omega of the wheels [m/s], NaN where unknown.
            rolling: which wheels rolled at the last sample, by what the accelerometer read.
            offset: of the accelerometer, as far as it is known [m/s^2].
        """
        self._is_stuck = self._repetition.repeats(stamp, acceleration) and (self._is_stuck or not any(rolling))
        if acceleration is not None and not self._is_stuck:
            self._age.update(stamp, rim_speeds, acceleration)
        self._is_outvoted = self.votes.holds(stamp)
        left_out = self._is_stuck or self._is_outvoted or self._age.late > 0.0 or self._dive.holds(stamp)
        if acceleration is not None and not left_out:
            self._dive.update(stamp, rim_speeds, acceleration - offset, all(rolling))
        self._is_unfelt = self._dive.holds(stamp)
        return left_out or self._is_unfelt
