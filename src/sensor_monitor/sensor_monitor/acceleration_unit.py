"""Unit and sign of an accelerometer, checked against the speed of wheels or another one that changes as the car's."""

from collections import deque
from math import sqrt
from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS

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
