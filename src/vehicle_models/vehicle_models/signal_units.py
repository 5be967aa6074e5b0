"""Units and signs of accelerometer and brake pressures, checked against the wheels."""

from collections import deque
from math import inf, isfinite, sqrt
from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.physical_bounds import HIGHEST_PRESSURE
from vehicle_models.vehicle import Vehicle

_STEP: Final = 0.1
"""Time over which speeds and accelerations are averaged [s]."""
_LONGEST_GAP: Final = 0.1
"""[s] Where samples are further apart the comparison of steps begins again."""
_MEMORY: Final = 50
"""Steps that are compared."""
_LEAST_STEPS: Final = 6
GENTLE: Final = 4.0
"""Largest acceleration of wheels that roll [m/s^2]: beyond it their slip counts."""
_LEAST_SPREAD: Final = 0.15
"""Least standard deviation of the wheels' acceleration in these steps [m/s^2]."""
_SURE: Final = 6.0
"""Slope of the straight line over its standard deviation from which on two accelerations are those of one motion."""
_LEAST_AGREEING: Final = 0.6
_MOST_AGREEING: Final = 1.6
"""Slopes of two sensors of one motion lie between."""
_LEAST_IN_G: Final = 0.07
_MOST_IN_G: Final = 0.14
"""Slopes between which an acceleration in g lies to one in m/s^2, or one in m/s^2 to that of wheels in revolutions."""
_LASTING: Final = 8
"""Steps for which a unit must be suspected before it is named: a filter that lags by a second passes every slope."""
_DROP: Final = 1.0
"""Speed that all wheels must lose for the sign to be judged [m/s]."""
_LEAST_DROPPING: Final = 0.1
"""Time for which they must lose it [s]: a released tyre springs back, and pushes the car forward for a moment."""
_LONGEST_DROPPING: Final = 3.0
"""Time after which a drop is over, wherever wheels are that it has locked [s]."""
_HARD: Final = 2.0
"""Deceleration that is no road's [m/s^2]."""
_OPPOSITE: Final = 0.6
"""Mean reading, and rise of the reading, that is no offset [m/s^2]."""
_LONGEST_LAG: Final = 1.0
"""Time [s] for which a filter may still contain the previous acceleration."""
_SMOOTHING: Final = 0.1
"""Time constant of the reading before a drop [s]."""
_SIGN: Final = "imu/data has the wrong sign against the wheels: forward is positive"
_IN_G: Final = "imu/data is a tenth of the acceleration of the wheels: in g, or wheel_states in revolutions a minute?"


class AccelerationUnit:
    """Compares one accelerometer with the wheels. `text` names the suspected unit, empty where there is none."""

    def __init__(self, largest: float = GENTLE, lasting: int = _LASTING) -> None:
        """Start without samples.

        Args:
            largest: accelerations up to this are compared [m/s^2]; inf where the speed does not come from wheels that
                may slip.
            lasting: steps for which the fit must agree before a unit is named.
        """
        self._largest = largest
        self._lasting = lasting
        self.reset()

    def reset(self) -> None:
        """Know nothing."""
        self.known = False
        """Whether both have agreed: a unit does not change on the way, so nothing is suspected from then on."""
        self.text = ""
        """What is suspected."""
        self._steps: deque[tuple[float, float]] = deque(maxlen=_MEMORY)
        self._last = 0
        self._suspicion, self._suspected = "", 0
        self._reading = 0.0
        self._begin_again(0.0)

    def update(self, stamp: int, speed: float, acceleration: float, *, rolling: bool = True) -> None:
        """Take one sample.

        Args:
            stamp: stamp of the sample [ns].
            speed: speed at the rim of a wheel, or another one that changes as that of the car [m/s], finite.
            acceleration: reading, forward positive [m/s^2], finite.
            rolling: whether the speed may be that of rolling wheels; if not, only the sign is judged, in hard braking.
        """
        if self.known:
            return
        step = (stamp - self._last) / NANOSECONDS
        self._last = stamp
        if not 0.0 < step <= _LONGEST_GAP:
            self._begin_again(speed)
            return
        self._watch_drop(step, speed, acceleration)
        if not rolling:
            self._begin_steps()
            return
        self._integral += step * acceleration
        self._time += step
        self._count += 1
        self._speed_sum += speed
        self._integral_sum += self._integral
        if self._time >= _STEP:
            self._end_step()

    def _begin_again(self, speed: float) -> None:
        self._begin_steps()
        self._begin_drop(speed)

    def _begin_steps(self) -> None:
        self._integral = 0.0
        """Of the reading [m/s]."""
        self._begin_step()
        self._before: tuple[float, float] | None = None
        self._waiting: tuple[float, float] | None = None
        self._steps.clear()

    def _begin_step(self) -> None:
        self._time = self._speed_sum = self._integral_sum = 0.0
        self._count = 0

    def _end_step(self) -> None:
        """Take the changes of the mean speed and of the mean integral, which are averages with the same weights."""
        now, time = (self._speed_sum / self._count, self._integral_sum / self._count), self._time
        self._begin_step()
        before, self._before = self._before, now
        if before is None:
            return
        step = ((now[0] - before[0]) / time, (now[1] - before[1]) / time)
        if not max(abs(step[0]), abs(step[1])) < self._largest:
            # Wheels that slip; between two dives they slow down gently, too, while the car does not.
            self._waiting = None
            self._steps.clear()
            return
        # A wheel that begins to dive slows down gently at first: a step counts once the next one is gentle.
        waiting, self._waiting = self._waiting, step
        if waiting is not None:
            self._steps.append(waiting)
            self._judge_changes()

    def _judge_changes(self) -> None:
        """Put a straight line through the readings over the accelerations of the wheels."""
        count = len(self._steps)
        if count < _LEAST_STEPS:
            return
        mean_x = sum(x for x, _ in self._steps) / count
        mean_y = sum(y for _, y in self._steps) / count
        xx = sum((x - mean_x) ** 2 for x, _ in self._steps)
        yy = sum((y - mean_y) ** 2 for _, y in self._steps)
        xy = sum((x - mean_x) * (y - mean_y) for x, y in self._steps)
        if xx < count * _LEAST_SPREAD**2:
            return
        slope = xy / xx
        if abs(slope) < _SURE * sqrt(max(yy - slope * xy, 0.0) / ((count - 2) * xx)):
            return
        if _LEAST_AGREEING < slope < _MOST_AGREEING:
            self.known, self.text = True, ""
        elif _LEAST_AGREEING < -slope < _MOST_AGREEING:
            self._suspect(_SIGN)
        elif _LEAST_IN_G < slope < _MOST_IN_G:
            self._suspect(_IN_G)
        else:
            self._suspected = 0

    def _suspect(self, text: str) -> None:
        self._suspected = self._suspected + 1 if text == self._suspicion else 1
        self._suspicion = text
        if self._suspected >= self._lasting:
            self.text = text

    def _begin_drop(self, speed: float) -> None:
        self._from, self._dropping, self._gained = speed, 0.0, 0.0
        self._read_before = self._reading

    def _watch_drop(self, step: float, speed: float, acceleration: float) -> None:
        """Follow wheels that slow down hard; the reading must not show that the car gains speed meanwhile."""
        self._reading += step / (step + _SMOOTHING) * (acceleration - self._reading)
        self._dropping += step
        self._gained += step * acceleration
        lost = self._from - speed
        if lost <= 0.0 or lost < _HARD * self._dropping - _DROP or self._dropping > _LONGEST_DROPPING:
            self._begin_drop(speed)
        elif lost >= _DROP and lost >= _HARD * self._dropping and self._dropping >= _LEAST_DROPPING:
            lagging = max(self._read_before, 0.0) * min(self._dropping, _LONGEST_LAG)
            if self._gained > _OPPOSITE * self._dropping + lagging:
                self.text = _SIGN


_IN_PASCAL: Final = 1e4
"""Pressure that no brake has in bar, psi or MPa, nor any effect in Pa."""
_SURE_AFTER: Final = 5
"""Samples of such a pressure after which its unit is known: one may be a flipped bit."""
_BAR: Final = 1e5
"""[Pa]"""
_LEAST_SPEED_LOSS: Final = 1.0
"""Speed at the rim that a wheel must lose before it is compared [m/s]."""
_LONGEST: Final = 4.0
"""Time in which it must lose it [s]: what slows down less may be rolling out."""
_LONGEST_STEP: Final = 0.1
"""Time between samples from which on they are not compared [s]."""
_LEAST_SHARE: Final = 0.12
_MOST_SHARE: Final = 5.0
"""The pressure of one wheel, taken for that of all, explains a share between these of how fast the wheel slows down:
the least where it dives into lock or brakes less than the others, the most on a road that falls."""
_OTHERS: Final = 20.0
"""In MPa or psi a pressure explains a share that is beyond those by a factor up to this."""


class PressureUnit:
    """Follows one wheel. `text` names the suspected unit of its pressure, empty where there is none."""

    def __init__(self, vehicle: Vehicle, wheel: str) -> None:
        """Choose a wheel of the car."""
        self._radius = vehicle.wheel(wheel).radius
        self._effect = sum(each.brake_gain / each.radius for each in vehicle.wheels) / vehicle.mass
        """Deceleration of the car for the same pressure in all its brakes [m/s^2 / Pa]."""
        self.reset()

    def reset(self) -> None:
        """Know nothing."""
        self.text = ""
        """What is suspected."""
        self._in_pascal = 0
        self._last = 0
        self._least = inf
        self._begin(0.0)

    @property
    def known(self) -> bool:
        """Whether pressures have shown to be in Pa: a unit does not change on the way."""
        return self._in_pascal >= _SURE_AFTER

    def update(self, stamp: int, wheel_speed: float, pressure: float) -> None:
        """Take one sample.

        Args:
            stamp: stamp of the sample [ns].
            wheel_speed: speed of the wheel [rad/s]; not finite where it is missing.
            pressure: pressure of its brake [Pa], also one that no brake has; not finite where it is missing.
        """
        if not self.known:
            self._count(abs(pressure))
        if self.known:
            self.text = ""
            return
        speed = abs(wheel_speed) * self._radius
        if not (isfinite(speed) and isfinite(pressure)):
            return
        self._least = min(self._least, pressure)
        step = (stamp - self._last) / NANOSECONDS
        self._last = stamp
        if not 0.0 < step <= _LONGEST_STEP or speed >= self._from or self._time > _LONGEST:
            self._begin(speed)
            return
        self._time += step
        self._impulse += step * (pressure - self._least)
        lost = self._from - speed
        if lost >= _LEAST_SPEED_LOSS:
            self._judge(lost / self._time, self._effect * self._impulse / lost)
            self._begin(speed)

    def _count(self, pressure: float) -> None:
        if _IN_PASCAL < pressure <= HIGHEST_PRESSURE:
            self._in_pascal += 1
        elif pressure > HIGHEST_PRESSURE:
            self._in_pascal = max(self._in_pascal - 1, 0)

    def _begin(self, speed: float) -> None:
        """Compare from this speed at the rim on [m/s]."""
        self._from = speed
        self._time = self._impulse = 0.0

    def _judge(self, deceleration: float, share: float) -> None:
        said = f"brakes {share:.1g} times as much as its wheel slows down, by {deceleration:.1f} m/s^2"
        if _LEAST_SHARE < share * _BAR < _MOST_SHARE:
            self.text = f"{said}: in bar?"
        elif _LEAST_SHARE < share / _BAR < _MOST_SHARE:
            self.text = f"{said}: in Pa, and converted from bar once more?"
        elif not self.text and _LEAST_SHARE / _OTHERS < share * _BAR < _MOST_SHARE * _OTHERS:
            self.text = f"{said}: in MPa or psi?"
