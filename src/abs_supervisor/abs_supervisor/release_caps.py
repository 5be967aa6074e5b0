"""Limits on the duration of a release, and the return of the pressure after a limit."""

from collections import deque
from enum import IntEnum
from typing import Final

from abs_supervisor.tuning import CapTuning
from vehicle_models.brake_actuator import ActuatorParameters, Command
from vehicle_models.nanoseconds import NANOSECONDS


class Cap(IntEnum):
    """Cap in force; the values are those of friction_msgs/SupervisorState."""

    NONE = 0
    CONTINUOUS = 1
    SHARE = 2
    RETURN = 3
    LOW_SPEED = 4


_SAME_RELEASE: Final = 0.02
"""Releases with less between them count as one [s]."""
_AGAIN: Final = 0.8
"""Share of `most_in_window` below which a wheel may be released again: not for a sample now and then."""
_TIGHT: Final = 0.6
"""Share of `most_in_window` above which the pressure comes back as slowly as after a cap."""
_REACHED: Final = 0.98
"""Share of the demand at which the pressure has returned."""

_MOST_OPENING: Final = 2.0
"""Of `longest`, for which wheels that stand may be released until their brakes are open."""


class ReleaseCaps:
    """Follows the releases of one wheel."""

    def __init__(self, parameters: CapTuning, actuator: ActuatorParameters) -> None:
        """Start without releases; `actuator` are the hydraulics."""
        self._p, self._actuator = parameters, actuator
        self._share = min(parameters.return_rate / actuator.apply_rate, 1.0)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.cap = Cap.NONE
        self.count = 0
        """Releases that a cap has ended."""
        self._released: deque[tuple[int, float]] = deque()
        self._in_window = 0.0
        self._last: int | None = None
        self._released_for = self._begun_with = 0.0
        self._released_at: int | None = None
        self._returning: int | None = None
        self._why = Cap.NONE
        self._allowed = 0.0

    def command(
        self, stamp: int, release: bool, recovering: bool, deep: bool, stands: bool, torque: float, demand: float
    ) -> Command:
        """Return DECREASE, or what takes its place.

        Args:
            stamp: [ns], later than the last.
            release: whether a release is asked for, and there is evidence for it.
            recovering: whether the wheel is seen to recover with a slip above the threshold.
            deep: whether the slip is beyond the peak by far.
            stands: whether the wheel stands in a moving car, and another with it.
            torque: of the brake [N m].
            demand: of the driver [N m].
        """
        dt = self._advance(stamp)
        if self._returning is not None:
            back = (stamp - self._returning) / NANOSECONDS
            again = back >= self._p.return_time and self._in_window <= _AGAIN * self._p.most_in_window
            returned = torque >= _REACHED * demand or back * self._p.return_rate >= demand
            if not (again and (release or returned)):
                self.cap = self._why if back < self._p.return_time or returned else Cap.RETURN
                return Command.INCREASE if returned else self._pulse()
            self._returning = None
        self.cap = Cap.NONE
        if not release:
            if torque >= _REACHED * demand:
                return Command.INCREASE
            # A wheel that comes back from far beyond the peak is let come. A slow rise needs fewer releases, so that a
            # law that works does not reach the cap.
            if deep and recovering:
                return Command.HOLD
            slow = deep or self._in_window > _TIGHT * self._p.most_in_window
            return self._pulse() if slow else Command.INCREASE
        goes_on = self._goes_on(stamp, dt)
        if not goes_on:
            self._begun_with = torque
        self.cap = self._exceeded(dt, goes_on, recovering, stands)
        if self.cap is not Cap.NONE:
            self.count += 1
            self._why, self._returning, self._allowed = self.cap, stamp, 0.0
            return self._pulse()
        self._released_for = self._released_for + dt if goes_on else dt
        self._released_at = stamp
        self._released.append((stamp, dt))
        self._in_window += dt
        return Command.DECREASE

    def driver(self, stamp: int, slow: bool) -> None:
        """Note that the driver has the brake at a stamp [ns], at once: by fail-safe, or as braking is over or `slow`.

        What was released before counts on.
        """
        self._advance(stamp)
        self._returning = None
        self.cap = Cap.LOW_SPEED if slow else Cap.NONE

    def _advance(self, stamp: int) -> float:
        """Return the time since the last sample [s], and drop what has left the window."""
        dt = 0.0 if self._last is None else (stamp - self._last) / NANOSECONDS
        self._last = stamp
        oldest = stamp - round(self._p.window * NANOSECONDS)
        while self._released and self._released[0][0] < oldest:
            self._in_window -= self._released.popleft()[1]
        if not self._released:
            self._in_window = 0.0
        return dt

    def _goes_on(self, stamp: int, dt: float) -> bool:
        """Whether a release at this stamp belongs to the one before."""
        return self._released_at is not None and stamp - self._released_at <= (_SAME_RELEASE + dt) * NANOSECONDS

    def _exceeded(self, dt: float, goes_on: bool, recovering: bool, stands: bool) -> Cap:
        if self._in_window + dt > self._p.most_in_window:
            return Cap.SHARE
        longest = self._p.longest
        if stands:
            # Pressure that comes back before the brake is open keeps a wheel standing that it has locked.
            opens = self._begun_with / self._actuator.release_rate + self._actuator.delay
            longest = max(longest, min(opens, _MOST_OPENING * longest))
        if goes_on and self._released_for + dt > longest and not recovering:
            return Cap.CONTINUOUS
        return Cap.NONE

    def _pulse(self) -> Command:
        """INCREASE for a share of the samples and HOLD for the others, so that the mean rate is that of the return."""
        self._allowed += self._share
        if self._allowed >= 1.0:
            self._allowed -= 1.0
            return Command.INCREASE
        return Command.HOLD
