"""Speed sensor monitor: consistency with wheels that roll according to the accelerometer.

Such wheels and the accelerometer agree with each other. A sensor that differs from them for a while contradicts both
and is left out. Had it agreed with them before, it is the one that has changed. Had it never, the radii of the vehicle
file may be wrong as well: nothing decides, and what they differ by is in the variance of the speed.

A sample that does not fit is not used at once: it may be a glitch, and would move the speed by which the next one is
judged. A sample that repeats the one before to the last bit, while the accelerometer says that the speed has changed,
is an old one and says nothing.
"""

from math import hypot
from typing import Final

from friction_runtime.filters import Debounce
from vehicle_models.nanoseconds import NANOSECONDS
from wheel_slip.sensor_age import SensorAge
from wheel_slip.sensor_skew import SensorSkew
from wheel_slip.speed_sample import SpeedSample
from wheel_slip.tuning import SensorWatchTuning

_AGREE: Final = 2.0
"""Standard deviations within which it agrees with the wheels."""


class SensorWatch:
    """The speed sensor of one car."""

    def __init__(self, parameters: SensorWatchTuning) -> None:
        """Start without samples."""
        self._p = parameters
        self.age = SensorAge()
        """How old its samples are, by wheels that the road makes faster."""
        self.skew = SensorSkew(parameters.latency_stddev)
        """The same by the accelerometer."""
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.age.reset()
        self.skew.reset()
        self.contradicted = False
        """Whether wheels and accelerometer contradict it."""
        self.undecided = 0.0
        """What it differs by from wheels with which it never agreed [m/s], else 0."""
        self._difference = 0.0
        self._agreed = False
        self._same: bool | None = None
        self._since = 0
        self._last = 0
        self._value: float | None = None
        self._travelled = 0.0
        self._first = 0
        self._is_old = False
        self._off = Debounce(self._p.time * NANOSECONDS)

    @property
    def left_out(self) -> bool:
        """Whether it may not be used at all."""
        return self.contradicted or self.late > 0.0

    @property
    def late(self) -> float:
        """Age with which it is left out [s], 0 where it is not."""
        return max(self.age.late, self.skew.late)

    @property
    def text(self) -> str:
        """Names what is wrong, empty where nothing is."""
        if self.late and not self._is_old:
            beside = "wheels" if self.age.late else "accelerometer"
            return (
                f"some {self.late:.1f} s behind the {beside}; left out: the doctor tells its age, speed_sensor.latency"
            )
        if self.contradicted:
            told = "" if self._agreed else ", or the radii are wrong"
            return f"{self._difference:.1f} m/s from wheels and accelerometer; left out{told}"
        return "repeats one value that the accelerometer contradicts; left out" if self._is_old else ""

    def is_old(self, sample: SpeedSample, travelled: float | None, offset: float) -> bool:
        """Whether a sample repeats the last one though the speed has changed.

        Args:
            sample: the sample.
            travelled: integral of the accelerometer's readings up to it [m/s]; None where there is none.
            offset: of the accelerometer [m/s^2].
        """
        if travelled is None or sample.speed != self._value:
            self._value = sample.speed if travelled is not None else None
            self._first, self._travelled = sample.stamp, travelled or 0.0
            self._is_old = False
            return False
        change = travelled - self._travelled - offset * (sample.stamp - self._first) / NANOSECONDS
        self._is_old = abs(change) > self._p.frozen + 3.0 * sample.variance**0.5
        return self._is_old

    def compare(self, stamp: int, difference: float, deviation: float, of_slip: float) -> bool:
        """Compare a sample with wheels that roll.

        Args:
            stamp: of the sample [ns].
            difference: sensor minus wheels [m/s].
            deviation: that is known of it, but for the slip of the wheels [m/s].
            of_slip: that of their slip [m/s].

        Returns:
            Whether the sample may be used.
        """
        self._difference = abs(difference)
        known = None
        if self._difference > self._p.sure * hypot(deviation, of_slip):
            known = False
        elif self._difference < _AGREE * deviation:
            known = True
        lasting = self._p.time * NANOSECONDS
        if known is not self._same or stamp - self._last > lasting:
            self._same, self._since = known, stamp
        self._last = stamp
        if known is not None and stamp - self._since >= lasting:
            self.contradicted = not known
            self._agreed = self._agreed or known
        settled = self._agreed or (known and not self.contradicted)
        self.undecided = 0.0 if settled else self._difference
        return known is not False and not self.contradicted

    def fits(self, stamp: int, innovation: float, deviation: float) -> bool:
        """Whether a sample may be used where no wheel tells: it fits the speed, or none has for a while.

        Args:
            stamp: of the sample [ns].
            innovation: what it differs by from the speed that is known [m/s].
            deviation: of that difference [m/s].
        """
        if self.contradicted:
            return False
        off = not abs(innovation) <= self._p.sure * deviation
        return self._off.update(stamp, off) or not off
