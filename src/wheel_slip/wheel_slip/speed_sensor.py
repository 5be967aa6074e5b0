"""Correction by a speed sensor, weighed by the probability that it is wrong.

A sensor that is right differs from the filter's speed by what both are uncertain; one that is wrong differs by anything
up to some `_WRONG`. It seldom changes from one to the other. A sample counts with the probability that it is right. One
that repeats the last to the last bit may be as old as the first of them: what the speed has changed since is in its
variance. So is what it changes by within the age that a sample may have, as the accelerometer tells (signal_age.py); a
sensor that is too late for that is left out. While nothing has shown that the radii of the wheels are as the vehicle
file says, they may be what is wrong: the difference is then in the variance of the speed.
"""

from math import exp, log, nan
from typing import Final

from sensor_monitor.signal_age import SignalAge
from vehicle_models.nanoseconds import NANOSECONDS
from wheel_slip.car_motion import CarMotion
from wheel_slip.estimate import SpeedSample

_WRONG: Final = 10.0
"""Deviation of a sensor that is wrong [m/s]."""
_FAILS: Final = 1e-4
"""Rate at which a sensor that is right becomes wrong [1/s]: once in three hours."""
_RECOVERS: Final = 0.01
"""Rate at which one that is wrong becomes right [1/s]."""
_AGE: Final = 0.07
"""Deviation of the age of a sample, until a change of the acceleration has shown it [s]."""
_ALIKE: Final = 0.2
"""Time for which the errors of a sample are one [s]: those of age and filter of the sensor."""
_BRAKING: Final = 3.0
"""Time for which what the age of a sample does is one error [s]."""
_PROVEN: Final = 1.0
"""Time of agreement after which the radii are taken to be right [s]."""
_NAMED: Final = 1.0
"""Change of the speed under a value that stays, from which on that is named [m/s]."""
_TIMEOUT: Final = NANOSECONDS // 2
"""Silence after which the sensor is taken to be gone [ns]."""


class SpeedSensor:
    """Speed sensor of one car."""

    def __init__(self) -> None:
        """Start without samples."""
        self._age = SignalAge(_AGE, accelerometer=False)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._age.reset()
        self._wrong = _FAILS / _RECOVERS
        self._radii_unproven = 1.0
        self._difference = self._stale = 0.0
        self._first: SpeedSample | None = None
        self._last: int | None = None

    def follow(self, stamp: int, car: CarMotion) -> None:
        """Take what the accelerometer has told of the motion of a car up to a stamp [ns]."""
        self._age.follow(stamp, car.travelled)

    def update(self, sample: SpeedSample, car: CarMotion) -> None:
        """Correct the speed of a car by a sample."""
        since = (sample.stamp - self._last) / NANOSECONDS if self._last is not None else 0.0
        self._last = sample.stamp
        if self._first is None or sample.speed != self._first.speed:
            self._first = sample
        self._age.compare(sample.stamp, sample.speed, car.acceleration, sample.variance)
        self._stale = self._moved(sample, car)
        since_then, by_age = self._age.moved(sample.stamp)
        speed, by_age = sample.speed + since_then, by_age + self._stale
        difference = car.compare(sample.stamp, speed) if car.started else None
        if difference is not None:
            self._judge(*difference, sample.variance + by_age, min(max(since, 0.0), 1.0))
        if not self._age.text:
            # What its age does is one error for as long as a braking lasts, not another one in each sample.
            variance = sample.variance + by_age * max(_BRAKING / max(since, 1e-3), 1.0)
            car.take_speed(sample.stamp, speed, variance / max(1.0 - self._wrong, 1e-9))

    def wrong(self, stamp: int) -> float:
        """Return the probability that it is wrong at a stamp [ns], NaN where there is no sensor."""
        return max(self._wrong, self._age.wrong) if self.speaks(stamp) else nan

    def speaks(self, stamp: int) -> bool:
        """Whether there are samples at a stamp [ns]."""
        return self._last is not None and stamp - self._last <= _TIMEOUT

    @property
    def undecided(self) -> float:
        """Variance of the speed by what nothing decides: sensor or radii [m^2/s^2]."""
        return self._wrong * self._radii_unproven * self._difference**2

    @property
    def text(self) -> str:
        """Names what is wrong, empty where nothing is."""
        if self._age.text:
            return f"{self._age.text}, by the accelerometer; left out: speed_sensor.latency may take its age"
        if self._stale > _NAMED**2:
            return "repeats one value that wheels and accelerometer contradict; left out"
        if self._wrong < 0.5:
            return ""
        radii = ", or the radii are wrong" if self._radii_unproven > 0.5 else ""
        return f"{abs(self._difference):.1f} m/s from wheels and accelerometer; left out{radii}"

    def _moved(self, sample: SpeedSample, car: CarMotion) -> float:
        """Square of what the speed has changed by since this value first came [m^2/s^2]."""
        if self._first is None or sample is self._first or not car.started:
            return 0.0
        now, then = car.compare(sample.stamp, sample.speed), car.compare(self._first.stamp, sample.speed)
        return car.speed**2 if now is None or then is None else (now[0] - then[0]) ** 2

    def _judge(self, difference: float, expected: float, variance: float, since: float) -> None:
        right, off = expected + variance, expected + _WRONG**2
        told = 0.5 * (difference**2 / right - difference**2 / off + log(right / off))
        wrong = self._wrong + since * (_FAILS * (1.0 - self._wrong) - _RECOVERS * self._wrong)
        share = min(since / _ALIKE, 1.0) if since else 1.0
        odds = wrong / (1.0 - wrong) * exp(max(min(share * told, 50.0), -50.0))
        self._wrong = min(max(odds / (1.0 + odds), 1e-9), 1.0 - 1e-9)
        self._difference = difference
        self._radii_unproven *= exp(-since * (1.0 - self._wrong) / _PROVEN)
