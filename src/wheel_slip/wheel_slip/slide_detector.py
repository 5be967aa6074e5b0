"""Detection of rolling wheels and of their duration: the evidence for a change of mode (mode.py).

Over a short window each wheel's change of rim speed r omega is compared with the integrated corrected acceleration:

    D_i = [r_i omega_i](t) - [r_i omega_i](t - T) - integral of a over T

A wheel rolls while |D_i| is small (for what is known of the offset) and its rim speed is that of the others. This sees
a slide on snow, where the car hardly decelerates, and does not use the integrated speed.
"""

from collections import deque
from collections.abc import Sequence
from math import isfinite, nan
from statistics import median
from typing import Final

from friction_runtime.filters import Debounce, first_order_gain
from vehicle_models.nanoseconds import NANOSECONDS
from wheel_slip.mode import Evidence
from wheel_slip.slope_watch import SlopeWatch
from wheel_slip.tuning import SlideTuning, SlopeTuning

_NOT: Final = -1.0
"""Sentinel time [s]: condition not met."""
_LAG: Final = 0.015
"""Time constant [s] that gives the acceleration the lag of the wheel filter."""


class SlideDetector:
    """The wheels of one car."""

    def __init__(self, parameters: SlideTuning, slope: SlopeTuning, driven: Sequence[bool]) -> None:
        """Start without samples.

        Args:
            parameters: when a wheel rolls.
            slope: what a road may do.
            driven: which wheels the engine drives. All and none come to the same: no wheel is freer than another.
        """
        self._p = parameters
        self.free = [index for index, by_engine in enumerate(driven) if not by_engine] if any(driven) else []
        """The wheels that the engine does not drive, where it drives others."""
        self._all = list(range(len(driven)))
        self._road = slope
        self.slope = SlopeWatch(slope)
        settled = parameters.settle_time * NANOSECONDS
        self._rolls, self._keeps, self._calms = Debounce(), Debounce(settled), Debounce(settled)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.slope.reset()
        self.rolling = [False] * len(self._all)
        """Which wheels roll."""
        self.acceleration: float | None = None
        """Acceleration [m/s^2] with the lag of the wheel filters."""
        self._strength = 0.0
        """The same [m/s^2]; without an accelerometer how the wheels change: those that slow down are braked."""
        self.spread = nan
        """Largest difference between rim speeds [m/s]."""
        self.direction = 1.0
        """-1.0 while the wheels turn backwards: they are braked then where the car accelerates forwards."""
        self._history: deque[tuple[int, float, Sequence[float]]] = deque()
        self._wheels_roll = self._pulled = self._agree = False
        self._rolled = self._steady = _NOT
        self.begin_slide()
        self._travelled = self._force = 0.0
        self._calm = False
        self._calms.reset()

    def update(
        self,
        stamp: int,
        rim_speeds: Sequence[float],
        rim_accelerations: Sequence[float],
        acceleration: float | None,
        specific_force: float | None,
        offset_stddev: float,
        undoubted_stddev: float,
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
            undoubted_stddev: the same on a road that has not stepped within the slide [m/s^2].
            integrated: integrated speed [m/s] and its standard deviation [m/s]; None if there is none.
        """
        self._integrate(stamp, acceleration, specific_force)
        known = sorted([speed for speed in rim_speeds if isfinite(speed)])
        self.spread = known[-1] - known[0] if known else nan
        history, begin = self._history, stamp - self._p.window * NANOSECONDS
        history.append((stamp, self._travelled, rim_speeds))
        while len(history) > 2 and history[1][0] <= begin:
            history.popleft()
        allowed = self._allowed(offset_stddev, specific_force)
        undoubted = self._allowed(undoubted_stddev, specific_force)
        middle = 0.5 * (known[(len(known) - 1) // 2] + known[len(known) // 2]) if known else nan
        self.direction = -1.0 if middle < -self._p.blind_below else 1.0
        slip = 1.0 - middle / integrated[0] if integrated is not None and integrated[0] > self._p.blind_below else nan
        self._watch_slope(stamp, rim_speeds, middle, slip)
        self.rolling = self._roll(rim_speeds, rim_accelerations, middle, allowed)
        kept = self.rolling if undoubted == allowed else self._roll(rim_speeds, rim_accelerations, middle, undoubted)
        self._strength = self.acceleration if self.acceleration is not None else self._change_of_wheels(stamp, middle)
        self._judge(stamp, rim_speeds, middle, kept, integrated)

    def _allowed(self, offset_stddev: float, specific_force: float | None) -> float:
        """Return by how much a wheel that rolls may differ over the window [m/s]."""
        allowed = self._p.threshold + 2.0 * offset_stddev * self._p.window
        if specific_force is not None and abs(specific_force) < self._road.forceless:
            allowed += self._road.steepest * self._p.window
        return allowed

    @property
    def has_rolled(self) -> bool:
        """Whether the wheels have rolled for a while, by what the accelerometer reads."""
        return self._rolled >= self._p.settle_time

    def believed(self) -> list[int]:
        """Return the wheels to take the speed from: those that roll, without the driven ones if a free one is left."""
        free = [index for index in self.free if self.rolling[index]]
        return free or [index for index in self._all if self.rolling[index]]

    def free_believed(self) -> bool:
        """Whether the wheels that are believed are not driven, and some are."""
        return any(self.rolling[index] for index in self.free)

    def _integrate(self, stamp: int, acceleration: float | None, specific_force: float | None) -> None:
        if acceleration is None or specific_force is None:
            self.acceleration = None
            return
        before = self.acceleration
        if before is None or not self._history:
            self.acceleration, self._force = acceleration, specific_force
            return
        dt = (stamp - self._history[-1][0]) / NANOSECONDS
        share = first_order_gain(dt, _LAG)
        self.acceleration = before + share * (acceleration - before)
        self._force += share * (specific_force - self._force)
        self._travelled += 0.5 * dt * (before + self.acceleration)

    def _watch_slope(self, stamp: int, rim_speeds: Sequence[float], middle: float, slip: float) -> None:
        known = self.acceleration is not None and abs(middle) > self._p.blind_below
        alike = known and self.spread <= self._p.likeness(middle)
        begin, travelled, before = self._history[0]
        time = (stamp - begin) / NANOSECONDS
        differences: list[float] = []
        if time >= 0.5 * self._p.window:
            change = self._travelled - travelled
            changes = [now - earlier for now, earlier in zip(rim_speeds, before, strict=True)]
            differences = [(each - change) / time for each in changes if isfinite(each)]
        self.slope.update(stamp, alike, differences, self.acceleration or 0.0, slip)

    def _roll(
        self, rim_speeds: Sequence[float], rim_accelerations: Sequence[float], middle: float, allowed: float
    ) -> list[bool]:
        """Return which wheels roll; `middle`: median of the rim speeds; `allowed`: what they may differ by [m/s]."""
        alike = self._p.likeness(middle)
        if self.acceleration is None:
            return [
                abs(speed - middle) <= alike and abs(rate) < self._p.strongest
                for speed, rate in zip(rim_speeds, rim_accelerations, strict=True)
            ]
        _, travelled, before = self._history[0]
        travelled = self._travelled - travelled
        return [
            abs(speed - middle) <= alike and abs(speed - earlier - travelled) <= allowed
            for speed, earlier in zip(rim_speeds, before, strict=True)
        ]

    def _change_of_wheels(self, stamp: int, middle: float) -> float:
        """Return how fast the median of the rim speeds, `middle` now, has changed over the window [m/s^2]."""
        begin, _, before = self._history[0]
        known = [speed for speed in before if isfinite(speed)]
        time = (stamp - begin) / NANOSECONDS
        return (middle - median(known)) / time if known and time >= 0.5 * self._p.window else 0.0

    def begin_slide(self) -> None:
        """Count the times of rolling from the next sample on."""
        self._rolls.reset()
        self._keeps.reset()
        self._steady_from: tuple[int, float] | None = None

    def evidence(self, sensor: bool, speed_at_wheels: bool) -> Evidence:
        """Return what the last sample says of the mode, beside the other two things that are asked for."""
        return Evidence(
            sensor=sensor,
            speed_at_wheels=speed_at_wheels,
            wheels_roll=self._wheels_roll,
            pulled=self._pulled,
            acceleration=abs(self.acceleration or 0.0),
            calm=self._calm,
            agree=self._agree,
            rolled=self._rolled,
            steady=self._steady,
        )

    def _judge(
        self,
        stamp: int,
        rim_speeds: Sequence[float],
        middle: float,
        kept: Sequence[bool],
        integrated: tuple[float, float] | None,
    ) -> None:
        """Judge all wheels; `kept`: which of them roll on a road that has not stepped within the slide."""
        self._watch_calm(stamp)
        a = self.direction * self._strength
        # Free wheels roll while the engine pulls, however strongly.
        self._pulled = bool(self.free) and a > -0.5
        judged = [index for index in (self.free if self._pulled else self._all) if isfinite(rim_speeds[index])]
        allowed = 1 if len(judged) >= 3 else 0
        self._wheels_roll = bool(judged) and len([index for index in judged if not self.rolling[index]]) <= allowed
        # What a wheel that creeps from its peak has made of the slope must not make the same wheel one that rolls.
        lasts = self._keeps.update(stamp, len([index for index in judged if not kept[index]]) <= allowed)
        self._agree = integrated is None or (lasts and self._agrees(middle, *integrated))
        self._rolls.update(stamp, self._wheels_roll and (self._pulled or abs(a) <= self._p.roll_below))
        self._rolled = _NOT if self._rolls.since is None else self._rolls.elapsed(stamp) / NANOSECONDS
        self._watch_steadiness(stamp, judged, rim_speeds, middle)
        self._steady = _NOT if self._steady_from is None else (stamp - self._steady_from[0]) / NANOSECONDS

    def _watch_calm(self, stamp: int) -> None:
        """Note whether nothing has made the wheels slip for a while, neither brake nor engine.

        Downhill tyres have more force than the car slows, and a moment without some of it makes no wheel roll.
        """
        force = 0.0 if self.acceleration is None else abs(self._force) - self._p.most_offset
        self._calm = self._calms.update(stamp, not max(abs(self.acceleration or 0.0), force) >= self._p.calm_below)

    def _agrees(self, middle: float, speed: float, stddev: float) -> bool:
        """Whether wheels at a rim speed [m/s] agree with a speed of a standard deviation [m/s].

        Wheels may keep a steady slip while they are braked: they do not become right because the speed has become
        uncertain.
        """
        if not self._calm or abs(self._strength) > self._p.calm_below:
            stddev = 0.0
        return abs(middle - speed) <= stddev + self._p.agreement * abs(middle) + self._p.agreement_at_rest

    def _watch_steadiness(self, stamp: int, judged: list[int], rim_speeds: Sequence[float], middle: float) -> None:
        """Note since when the wheels turn alike and hardly change."""
        allowed = self._p.likeness(middle)
        alike = [index for index in judged if abs(rim_speeds[index] - middle) <= allowed]
        if not judged or len(alike) < len(judged) or abs(middle) <= self._p.blind_below:
            self._steady_from = None
        elif self._steady_from is None:
            self._steady_from = (stamp, middle)
        else:
            elapsed = (stamp - self._steady_from[0]) / NANOSECONDS
            if abs(middle - self._steady_from[1]) > self._p.steady_below * elapsed + self._p.threshold:
                self._steady_from = (stamp, middle)
