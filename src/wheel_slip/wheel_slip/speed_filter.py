"""Vehicle speed and accelerometer offset: a Kalman filter driven by the accelerometer.

    v_dot = a_m - b + n_a,    b_dot = n_b

a_m is the measured acceleration, b its offset: sensor bias and road slope together (g sin(slope)), which a speed
measurement separates from a_m and nothing else can. An accelerometer is low-passed before it is sampled, so a sample is
taken to hold for the whole interval it ends. Without an accelerometer a_m is 0, b is minus the acceleration of
the car, and n_b is as strong as the changes of acceleration of a braking car.

While nothing observes the offset, the road may change its slope unseen. What that may have done to speed and offset is
kept apart, in a second covariance (the unseen part); the sum of both is the uncertainty. `believe` corrects as if the
road had kept its slope and leaves the unseen part alone. Every other correction takes both together.

A measurement z of the speed at an earlier time t_m is used as it is: v(t_m) = v - A + b (t - t_m), where A is the
integral of a_m from t_m to t. So a late sensor delays nothing and blurs nothing.
"""

from collections import deque
from dataclasses import dataclass
from math import isfinite, sqrt
from typing import Final

from friction_parameters.parameter import parameter
from vehicle_models.nanoseconds import NANOSECONDS

_HISTORY: Final = 1 * NANOSECONDS
"""How far back [ns] a measurement can be used."""
_FIRST_SPEED_VARIANCE: Final = 1e6
"""Variance of an unknown speed [m^2/s^2]."""
_ACCELERATION_WALK: Final = 30.0**2
"""Density of the change of acceleration without an accelerometer [m^2/s^5]: 10 m/s^2 in 0.1 s."""
_UNKNOWN_ACCELERATION_VARIANCE: Final = 25.0
"""Variance of the acceleration when the accelerometer has just gone, or over a gap [m^2/s^4]."""
_GAP: Final = 0.1
"""Longer steps between samples are gaps [s]."""
_NOTHING = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class SpeedFilterParameters:
    """Noise of the accelerometer and of its offset."""

    acceleration_stddev: float = parameter(
        0.1, "noise of an accelerometer sample", unit="m/s^2", minimum=1e-3, maximum=10.0
    )
    offset_stddev: float = parameter(
        0.4, "offset (bias and road slope) to expect before it is learned", unit="m/s^2", minimum=1e-3, maximum=10.0
    )
    offset_walk: float = parameter(
        0.001,
        "change of the offset in the square root of a second while the wheels roll and the offset is learned",
        unit="m/s^2",
        minimum=1e-4,
        maximum=10.0,
    )
    blind_offset_walk: float = parameter(
        0.06,
        "the same while the wheels slide and the offset is not observed: change of road slope",
        unit="m/s^2",
        minimum=1e-4,
        maximum=10.0,
    )


class SpeedFilter:
    """State (v, b) and its covariance."""

    def __init__(self, parameters: SpeedFilterParameters) -> None:
        """Start with nothing known."""
        self._parameters = parameters
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.speed = 0.0
        """Vehicle speed [m/s], forward positive."""
        self.offset = 0.0
        """Offset b [m/s^2]; minus the acceleration while there is no accelerometer."""
        self.surprise = 0.0
        """Last innovation over its standard deviation [-]."""
        self._pv, self._pc, self._pb = _FIRST_SPEED_VARIANCE, 0.0, self._parameters.offset_stddev**2
        self._unseen = _NOTHING
        self._measured: float | None = 0.0
        self._travelled = 0.0
        self._history: deque[tuple[int, float]] = deque()
        self._kept = (0.0, self._pb)

    @property
    def speed_variance(self) -> float:
        """[m^2/s^2]"""
        return self._pv + self._unseen[0]

    @property
    def offset_variance(self) -> float:
        """[m^2/s^4]"""
        return self._pb + self._unseen[2]

    @property
    def steady_road_variance(self) -> float:
        """Variance of the speed, if the road has kept its slope [m^2/s^2]."""
        return self._pv

    @property
    def acceleration(self) -> float:
        """Acceleration of the car [m/s^2], forward positive."""
        return (self._measured or 0.0) - self.offset

    @property
    def acceleration_variance(self) -> float:
        """[m^2/s^4]"""
        noise = self._parameters.acceleration_stddev**2 if self._measured is not None else 0.0
        return self.offset_variance + noise

    def start(self, speed: float, variance: float) -> None:
        """Start at the last stamp with a speed [m/s] and its variance [m^2/s^2]; what is known of the offset stays."""
        self._see()
        self.speed, self._pv, self._pc = speed, variance, 0.0

    def predict(self, stamp: int, measured: float | None, *, observed: bool = True) -> None:
        """Go to `stamp` [ns], later than the last.

        Args:
            stamp: new stamp [ns].
            measured: acceleration measured at the stamp [m/s^2], None if there is none.
            observed: whether speed measurements observe the offset at present.
        """
        if (self._measured is None) != (measured is None):
            self._change_of_input(measured)
        if self._history:
            dt = (stamp - self._history[-1][0]) / NANOSECONDS
            p = self._parameters
            walk, noise = p.offset_walk**2, p.acceleration_stddev**2
            if measured is None:
                walk, noise = _ACCELERATION_WALK, 0.0
            change = dt * (measured or 0.0)
            self.speed += change - dt * self.offset
            pv, pc, pb = _predicted((self._pv, self._pc, self._pb), dt, walk)
            self._pv, self._pc, self._pb = pv + dt * dt * noise, pc, pb
            if observed:
                self._see()
            elif measured is not None:
                self._unseen = _predicted(self._unseen, dt, p.blind_offset_walk**2)
            self._travelled += change
            if dt > _GAP:
                self._pv += _UNKNOWN_ACCELERATION_VARIANCE * dt**2
        self._measured = measured
        self._history.append((stamp, self._travelled))
        while self._history[0][0] < stamp - _HISTORY:
            self._history.popleft()

    def correct(self, speed: float, variance: float, stamp: int | None = None) -> bool:
        """Use a measured speed [m/s] with its variance [m^2/s^2], taken at `stamp` [ns] (None: now).

        Returns:
            False if the filter was not running at that time, or it is too long ago: nothing is changed.
        """
        age, travelled = 0.0, 0.0
        if stamp is not None:
            then = self._travelled_at(stamp)
            if then is None:
                return False
            age = (self._history[-1][0] - stamp) / NANOSECONDS
            travelled = self._travelled - then
        self._see()
        return self._update(speed, variance, age, travelled)

    def believe(self, speed: float, variance: float) -> None:
        """Use a speed [m/s] with its variance [m^2/s^2] as if the road had kept its slope."""
        self._update(speed, variance, 0.0, 0.0)

    def limit(self, variance: float) -> None:
        """Limit the variance of the speed to `variance` [m^2/s^2] without moving it: as a measurement that agrees."""
        uv, uc, ub = self._unseen
        total = self._pv + uv
        if total <= variance:
            return
        if self._pv < variance:
            share = (total - variance) / uv
            self._unseen = (variance - self._pv, uc - share * uc, ub - share * uc * uc / uv)
        else:
            self._see()
            self._update(self.speed, total * variance / (total - variance), 0.0, 0.0)

    def _update(self, speed: float, variance: float, age: float, travelled: float) -> bool:
        pv, pc, pb = self._pv, self._pc, self._pb
        hv, hb = pv + age * pc, pc + age * pb
        total = hv + age * hb + variance
        if not isfinite(total):
            return False
        gain_v, gain_b = hv / total, hb / total
        innovation = speed - (self.speed - travelled + age * self.offset)
        self.surprise = innovation / sqrt(total)
        self.speed += gain_v * innovation
        self.offset += gain_b * innovation
        self._pv = pv - gain_v * hv
        self._pc = pc - gain_v * hb
        self._pb = pb - gain_b * hb
        return True

    def _see(self) -> None:
        """Merge the unseen part into the covariance: it is observed from now on."""
        if self._unseen is not _NOTHING:
            uv, uc, ub = self._unseen
            self._pv, self._pc, self._pb = self._pv + uv, self._pc + uc, self._pb + ub
            self._unseen = _NOTHING

    def doubt_offset(self, variance: float) -> None:
        """Widen the variance of the offset to at least `variance` [m^2/s^4]: it has changed."""
        self._see()
        self._pb = max(self._pb, variance)

    def _travelled_at(self, stamp: int) -> float | None:
        """Return the integral of the measured acceleration up to `stamp` [m/s]."""
        later: tuple[int, float] | None = None
        for known in reversed(self._history):
            if known[0] == stamp:
                return known[1]
            if known[0] < stamp:
                if later is None:
                    return None
                weight = (stamp - known[0]) / (later[0] - known[0])
                return known[1] + weight * (later[1] - known[1])
            later = known
        return None

    def _change_of_input(self, measured: float | None) -> None:
        """Convert the offset when the accelerometer came or went; the acceleration of the car stays."""
        self._see()
        if measured is None:
            self._kept = (self.offset, self._pb)
            self.offset -= self._measured or 0.0
            self._pb = _UNKNOWN_ACCELERATION_VARIANCE
        else:
            self.offset, self._pb = self._kept
        self._pc = 0.0
        self._measured = measured


def _predicted(covariance: tuple[float, float, float], dt: float, walk: float) -> tuple[float, float, float]:
    """Return the covariance (speed, both, offset) after `dt` [s]; the offset walks with density `walk` [m^2/s^5]."""
    pv, pc, pb = covariance
    return pv + dt * (dt * (pb + walk * dt / 3.0) - 2.0 * pc), pc - dt * (pb + 0.5 * walk * dt), pb + walk * dt
