"""Reference speed: the least speed that a car has by its wheels, and how a wheel turns beside the others.

The fastest plausible wheel is carried on at the hardest braking of any car, so that wheels that lock together are no
standstill.
"""

from collections import deque
from math import isfinite, nan
from typing import Final

from abs_supervisor.measurements import Measurements
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.physical_bounds import SlowestCar

WITNESSES: Final = 2
"""Other wheels that must agree, as the sensor of one may be wrong."""
MOVES: Final = 1.5
"""[m/s] speed of a car that moves."""
SLIDES: Final = 0.5
"""[-] slip of a wheel whose own speed is no more that of the car."""
ALIKE, ALIKE_STANDING = 0.1, 0.2
"""[-] and [m/s] by which wheels that turn alike differ."""
TREND: Final = 0.2
"""[s] over which the deceleration of the car is taken."""


class ReferenceSpeed:
    """Follows the car as one of its wheels sees it: `update` at every sample."""

    def __init__(self, radius: float) -> None:
        """Choose a wheel of an effective radius [m]."""
        self._radius = radius
        self._slowest = SlowestCar()
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._slowest.reset()
        self._samples: deque[tuple[int, float]] = deque()
        self.speed = nan
        """[m/s] of the car: as estimated where the wheels allow that, else the least that they allow."""
        self.deceleration = nan
        """[m/s^2] of the car over the last 0.2 s, braking positive; NaN where unknown."""
        self.behind = nan
        """[-] by which the wheel turns slower than two others where its slip is unknown; NaN where they stand."""
        self.alike = False
        """Whether two other wheels or more turn like this one, and no sensor measures the speed of the car."""
        self.may_be_locked = False
        """Whether a lock of this wheel would look like a standstill of the car."""

    @property
    def slides(self) -> bool:
        """Whether a wheel of unknown slip turns so much slower than others that its own speed is not the car's."""
        return self.behind > SLIDES

    def update(self, stamp: int, measured: Measurements) -> None:
        """Take a sample at a stamp [ns], later than the last; its wheel speed is finite."""
        others, car, rim = measured.others, measured.car_speed, self._radius * measured.wheel_speed
        fastest = sorted([rim, *others])
        least = self._slowest.update(stamp, fastest[-WITNESSES if len(others) >= WITNESSES else -1])
        self.speed = car if measured.car_speed_measured or car > least else least
        self._decelerate(stamp, self.speed if others or isfinite(car) else nan)
        self.may_be_locked = not others and not isfinite(car)
        self.behind, several = nan, len(others) >= WITNESSES
        apart = ALIKE * abs(rim) + ALIKE_STANDING
        self.alike = several and not measured.car_speed_measured and all(abs(each - rim) < apart for each in others)
        if several and not isfinite(measured.slip):
            second = sorted(others)[-WITNESSES]
            self.behind = 1.0 - rim / second if second > MOVES else nan

    def _decelerate(self, stamp: int, speed: float) -> None:
        samples = self._samples
        if not isfinite(speed):
            samples.clear()
            self.deceleration = nan
            return
        samples.append((stamp, speed))
        while len(samples) > 2 and samples[1][0] <= stamp - TREND * NANOSECONDS:
            samples.popleft()
        begin, first = samples[0]
        seconds = (stamp - begin) / NANOSECONDS
        self.deceleration = (first - speed) / seconds if seconds >= 0.5 * TREND else nan
