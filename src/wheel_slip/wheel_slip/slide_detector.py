"""Whether the wheels roll, or the accelerometer has to bridge a slide.

Over a short window each wheel's change of rim speed r omega is compared with the integrated corrected acceleration:

    D_i = [r_i omega_i](t) - [r_i omega_i](t - T) - integral of a over T

A wheel rolls while |D_i| is small (for what is known of the offset) and its rim speed is that of the others. This sees
a slide on snow, where the car hardly decelerates, and does not use the integrated speed. The car slides when more than
one wheel does not roll, or if it accelerates so strongly that every wheel must have slip. It rolls again when the
wheels have rolled for a while and either agree with the integrated speed, or the car hardly accelerates: then they are
right, whatever that speed is. Wheels that turn alike and hardly change for 2 s are right, whatever the accelerometer
reads: its offset is then learned again.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from math import exp, isfinite, nan
from typing import Final

from friction_parameters.parameter import parameter
from vehicle_models.nanoseconds import NANOSECONDS
from wheel_slip.slope_watch import STEEPEST, SlopeWatch

_LAG: Final = 0.015
"""Time constant [s] that gives the acceleration the lag of the wheel filter."""
_SPREAD: Final = 0.03
_SPREAD_AT_REST: Final = 0.3
"""Rim speeds may differ by this share, and this speed [m/s]: radii, curves, quantisation."""
_CALM: Final = 1.0
"""Below this acceleration [m/s^2] wheels that agree are trusted over the integrated speed, after `_PATIENCE`."""
_PATIENCE: Final = 1.0
"""Time for which wheels must agree before they are trusted over the integrated speed [s]."""
_STEADY: Final = 0.5
"""Change of rim speed below which a wheel counts as steady [m/s^2]."""
_STEADY_TIME: Final = 2.0
"""Wheels that are steady and turn alike for this long [s] are right, whatever the accelerometer reads."""
_BLIND: Final = 0.6
"""Rim speed [m/s] below which a wheel may as well be locked."""
_FORCELESS: Final = 0.6
"""Force of all tyres over the mass of the car [m/s^2] below which they have no slip to speak of."""
_STRONGEST: Final = 14.0
"""Without an accelerometer a wheel that changes faster [m/s^2] does not roll."""
_SETTLE: Final = 0.3
"""Time [s] the wheels have to roll before they are trusted again."""


@dataclass(frozen=True)
class SlideParameters:
    """When a wheel, and the car, count as rolling."""

    window: float = parameter(
        0.2, "window T over which wheels are compared with the accelerometer", unit="s", minimum=0.02, maximum=1.0
    )
    threshold: float = parameter(
        0.15, "difference |D| over that window above which a wheel slides", unit="m/s", minimum=0.01, maximum=5.0
    )
    slide_above: float = parameter(
        3.0, "acceleration above which wheels are not trusted", unit="m/s^2", minimum=0.1, maximum=20.0
    )
    roll_below: float = parameter(
        2.5, "acceleration below which they may be trusted again", unit="m/s^2", minimum=0.1, maximum=20.0
    )

    def __post_init__(self) -> None:
        """Refuse thresholds in the wrong order."""
        if self.roll_below > self.slide_above:
            raise ValueError(f"parameter 'roll_below' = {self.roll_below} must not exceed 'slide_above'")


class SlideDetector:
    """Mode of the car, and the wheels that roll."""

    def __init__(self, parameters: SlideParameters, driven: Sequence[bool]) -> None:
        """Start in the sliding mode: no wheel is trusted before it has been seen to roll.

        Args:
            parameters: parameters of the detector.
            driven: which wheels the engine drives. All and none come to the same: no wheel is freer than another.
        """
        self._p = parameters
        self._free = [index for index, by_engine in enumerate(driven) if not by_engine]
        self._all = list(range(len(driven)))
        self.slope = SlopeWatch()
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.slope.reset()
        self.sliding = True
        """Whether the car slides, so that the wheels are not trusted."""
        self.rolling = [False] * len(self._all)
        """Which wheels roll."""
        self.since: int | None = None
        """Stamp [ns] of the last change of mode."""
        self.acceleration: float | None = None
        """Acceleration [m/s^2] with the lag of the wheel filters."""
        self.spread = nan
        """Largest difference between rim speeds [m/s]."""
        self._history: deque[tuple[int, float, Sequence[float]]] = deque()
        self.contradicted = False
        """Whether the wheels were trusted again because they turned alike, against the accelerometer."""
        self.agreed = False
        """Whether the wheels were trusted again because they agreed with the integrated speed."""
        self._rolled_since: int | None = None
        self._steady_from: tuple[int, float] | None = None
        self._travelled = 0.0
        self._allowed = self._p.threshold

    def update(
        self,
        stamp: int,
        rim_speeds: Sequence[float],
        rim_accelerations: Sequence[float],
        acceleration: float | None,
        specific_force: float | None,
        offset_stddev: float,
        integrated: tuple[float, float] | None,
    ) -> None:
        """Judge one sample.

        Args:
            stamp: stamp of the sample [ns].
            rim_speeds: r omega of each wheel [m/s], NaN where unknown.
            rim_accelerations: rates of the rim speeds [m/s^2].
            acceleration: acceleration of the car, corrected for offset [m/s^2]; None without an accelerometer.
            specific_force: reading of the accelerometer [m/s^2]: force of the tyres over the mass of the car.
            offset_stddev: standard deviation of that correction [m/s^2].
            integrated: integrated speed [m/s] and its standard deviation [m/s]; None if there is none.
        """
        self._integrate(stamp, acceleration)
        known = sorted([speed for speed in rim_speeds if isfinite(speed)])
        self.spread = known[-1] - known[0] if known else nan
        history, begin = self._history, stamp - self._p.window * NANOSECONDS
        history.append((stamp, self._travelled, rim_speeds))
        while len(history) > 2 and history[1][0] <= begin:
            history.popleft()
        self._allowed = self._p.threshold + 2.0 * offset_stddev * self._p.window
        if specific_force is not None and abs(specific_force) < _FORCELESS:
            self._allowed += STEEPEST * self._p.window
        middle = 0.5 * (known[(len(known) - 1) // 2] + known[len(known) // 2]) if known else nan
        self._watch_slope(stamp, rim_speeds, middle)
        self.rolling = self._roll(rim_speeds, rim_accelerations, middle)
        self._change_mode(stamp, rim_speeds, middle, integrated)

    def believed(self) -> list[int]:
        """Return the wheels to take the speed from: those that roll, without the driven ones if a free one is left."""
        free = [index for index in self._free if self.rolling[index]]
        return free or [index for index in self._all if self.rolling[index]]

    def free_believed(self) -> bool:
        """Whether the wheels that are believed are not driven, and some are."""
        return len(self._free) < len(self._all) and any(self.rolling[index] for index in self._free)

    def _integrate(self, stamp: int, acceleration: float | None) -> None:
        if acceleration is None:
            self.acceleration = None
            return
        before = self.acceleration
        if before is None or not self._history:
            self.acceleration = acceleration
            return
        dt = (stamp - self._history[-1][0]) / NANOSECONDS
        self.acceleration = before + (1.0 - exp(-dt / _LAG)) * (acceleration - before)
        self._travelled += 0.5 * dt * (before + self.acceleration)

    def _watch_slope(self, stamp: int, rim_speeds: Sequence[float], middle: float) -> None:
        known = self.acceleration is not None and abs(middle) > _BLIND
        alike = known and self.spread <= _SPREAD_AT_REST + _SPREAD * abs(middle)
        begin, travelled, before = self._history[0]
        time = (stamp - begin) / NANOSECONDS
        differences: list[float] = []
        if time >= 0.5 * self._p.window:
            change = self._travelled - travelled
            changes = [now - earlier for now, earlier in zip(rim_speeds, before, strict=True)]
            differences = [(each - change) / time for each in changes if isfinite(each)]
        self.slope.update(stamp, alike, differences, self.acceleration or 0.0)

    def _roll(self, rim_speeds: Sequence[float], rim_accelerations: Sequence[float], middle: float) -> list[bool]:
        """Return which wheels roll; `middle`: the median of the rim speeds [m/s]."""
        alike = _SPREAD_AT_REST + _SPREAD * abs(middle)
        if self.acceleration is None:
            return [
                abs(speed - middle) <= alike and abs(rate) < _STRONGEST
                for speed, rate in zip(rim_speeds, rim_accelerations, strict=True)
            ]
        _, travelled, before = self._history[0]
        travelled, allowed = self._travelled - travelled, self._allowed
        return [
            abs(speed - middle) <= alike and abs(speed - earlier - travelled) <= allowed
            for speed, earlier in zip(rim_speeds, before, strict=True)
        ]

    def _change_mode(
        self, stamp: int, rim_speeds: Sequence[float], middle: float, integrated: tuple[float, float] | None
    ) -> None:
        a = self.acceleration or 0.0
        # Free wheels roll while the engine pulls, however strongly.
        pulled = len(self._free) < len(self._all) and bool(self._free) and a > -0.5
        judged = [index for index in (self._free if pulled else self._all) if isfinite(rim_speeds[index])]
        allowed = 1 if len(judged) >= 3 else 0
        wheels_roll = bool(judged) and len([index for index in judged if not self.rolling[index]]) <= allowed
        strength = 0.0 if pulled else abs(a)
        if not self.sliding:
            if strength > self._p.slide_above or not wheels_roll:
                self.sliding, self.since = True, stamp
                self._rolled_since = self._steady_from = None
            return
        self._watch_steadiness(stamp, judged, rim_speeds, middle)
        if self._steady_from is not None and stamp - self._steady_from[0] >= _STEADY_TIME * NANOSECONDS:
            self.sliding, self.since, self.contradicted, self.agreed = False, stamp, not wheels_roll, False
            return
        if strength > self._p.roll_below or not wheels_roll:
            self._rolled_since = None
            return
        if self._rolled_since is None:
            self._rolled_since = stamp
        rolled = (stamp - self._rolled_since) / NANOSECONDS
        agree = integrated is None or abs(middle - integrated[0]) <= integrated[1] + 0.02 * abs(middle) + 0.1
        calm = abs(a) < _CALM and rolled >= _PATIENCE
        if rolled >= _SETTLE and (agree or calm or pulled):
            self.agreed = agree
            self.sliding, self.since, self.contradicted = False, stamp, False

    def _watch_steadiness(self, stamp: int, judged: list[int], rim_speeds: Sequence[float], middle: float) -> None:
        """Note since when the wheels turn alike and hardly change. Then they roll, whatever the accelerometer reads."""
        allowed = _SPREAD_AT_REST + _SPREAD * abs(middle)
        alike = [index for index in judged if abs(rim_speeds[index] - middle) <= allowed]
        if not judged or len(alike) < len(judged) or abs(middle) <= _BLIND:
            self._steady_from = None
        elif self._steady_from is None:
            self._steady_from = (stamp, middle)
        else:
            elapsed = (stamp - self._steady_from[0]) / NANOSECONDS
            if abs(middle - self._steady_from[1]) > _STEADY * elapsed + self._p.threshold:
                self._steady_from = (stamp, middle)
