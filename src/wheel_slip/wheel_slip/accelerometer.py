"""Judges the accelerometer of a car by its wheels: frozen, late, turned or stuck."""

from collections.abc import Sequence
from math import exp, inf, isfinite, isinf, nan
from statistics import median
from typing import Final

from sensor_monitor.frozen_signal import FrozenSignal
from sensor_monitor.signal_age import FAULTY, SignalAge
from sensor_monitor.signal_noise import MORE, SignalNoise
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.physical_bounds import HARDEST_BRAKING
from vehicle_models.vehicle import Vehicle, absolute_deviation
from wheel_slip.motion_noise import MotionNoise
from wheel_slip.tyre_forces import LOCKED, free_wheels

_AGE: Final = 0.01
"""Least deviation of the age that is expected [s]: nothing in a car is nearer to its stamp for sure."""
_FORCELESS: Final = 0.6
"""Deceleration at which wheels slip by `_SLIP` on soft snow [m/s^2]; at twice as much they may lock."""
_SLIP: Final = 0.02
"""See `_FORCELESS` [-]."""
_LARGEST: Final = 0.5
"""Deviation of the slip in the hardest braking [-]: wheels may lock, and say nothing."""
_SLIDES: Final = 3.0
"""Time for which wheels that were braked so hard may go on sliding [s]: beyond its peak a tyre gives less."""
_FROZEN: Final = 0.5
"""Probability that a reading which repeats itself to the last bit says nothing: simulated ones do so, too."""
_FELT: Final = 0.8
"""Share of the reading by which a car with locked wheels slows down at least: the rest may be a hill or its offset."""
_MOVES: Final = 2.0
"""Speed from which on wheels that stand are locked [m/s]."""
_FREE: Final = 0.005
"""Share by which free wheels may differ from the speed: curves."""


class Accelerometer:
    """Of one car."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Take what the vehicle file states of its age."""
        mounting = vehicle.accelerometer
        self._delay = round(mounting.delay * NANOSECONDS)
        self._frozen = FrozenSignal()
        self._free = free_wheels(vehicle)
        self._expected_noise = MotionNoise().acceleration ** 2
        self._noise = SignalNoise(self._expected_noise, self._expected_noise)
        self.against_wheels = SignalAge(max(absolute_deviation(mounting.deviations, "delay"), _AGE), True)
        """What the wheels say of it."""
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._frozen.reset()
        self._noise.reset()
        self.against_wheels.reset()
        self._is_frozen = False
        self._last: int | None = None
        self._reference, self._has_wheels = inf, False  # wheels that stand from the start may be locked
        self._slip = 0.0
        self.travelled = 0.0
        """Integral of the readings [m/s]."""

    def usable(self, stamp: int, reading: float | None, rims: Sequence[float]) -> float | None:
        """Take a reading [m/s^2] and the rim speeds [m/s], NaN where missing; return the reading if it is of use."""
        since = NANOSECONDS if self._last is None else stamp - self._last
        self._slip *= exp(-since / (_SLIDES * NANOSECONDS))
        self._last = stamp
        if reading is None or not isfinite(reading):
            return None
        self._noise.update(stamp, reading)
        known = [rims[index] for index in self._free if isfinite(rims[index])]
        self._is_frozen = self._frozen.repeats(stamp, reading)
        self.against_wheels.expect_stuck(_FROZEN if self._is_frozen else FAULTY)
        if since >= NANOSECONDS // 10:
            self.against_wheels.start_again()
        else:
            self.travelled += since / NANOSECONDS * reading
        # Locked wheels do not say how fast the car is, nor do those that spin up faster than any car: it goes on from
        # where they were, as it is felt.
        by_wheels = max([abs(rim) for rim in known], default=0.0)
        dt = min(since / NANOSECONDS, 1.0)
        before = by_wheels if isinf(self._reference) and by_wheels > LOCKED else self._reference
        fastest = before + dt * HARDEST_BRAKING if self._has_wheels else by_wheels
        self._reference = max(min(by_wheels, fastest), before - dt * _FELT * abs(reading))
        self._has_wheels = bool(known)
        spin = by_wheels > self._reference + LOCKED
        if known and not spin and (by_wheels > LOCKED or self._reference < _MOVES):
            self._compare(stamp, reading, median(known))
        return None if self.text else reading

    @property
    def drift(self) -> float:
        """Variance that noise beyond the expected brings to its integral in a second [m^2/s^3]."""
        return self._noise.drift if self._noise.variance > MORE * self._expected_noise else 0.0

    @property
    def wrong(self) -> float:
        """Probability that it is of no use, NaN where it is not there."""
        return nan if self._last is None else self.against_wheels.wrong

    @property
    def text(self) -> str:
        """Why it is left out, empty where it is used."""
        text = self.against_wheels.text
        return "repeats one value that the wheels contradict" if text and self._is_frozen else text

    def _compare(self, stamp: int, reading: float, speed: float) -> None:
        """Compare with the speed of wheels without an engine [m/s], which slip where they are braked."""
        braked = max(-reading if speed >= 0.0 else reading, 0.0)
        self._slip = max(self._slip, min(_SLIP * (braked / _FORCELESS) ** 4, _LARGEST))
        self.against_wheels.follow(stamp, speed)
        variance = (self._slip * self._reference) ** 2 + (_FREE * speed) ** 2
        self.against_wheels.compare(stamp - self._delay, self.travelled, reading, variance, self.drift)
