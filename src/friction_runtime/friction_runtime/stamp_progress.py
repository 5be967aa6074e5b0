"""Progress of the stamps of one input against the steady clock: whether the input is lost.

The age of a stamp by the steady clock as it arrives is constant but for the delay of transport, whatever the offset of
the two clocks is. So the least age seen is the reference, and the input is lost where its stamps lag behind it by more
than `LAG` and its own period: when it is silent, when its stamps repeat, crawl or have gone back. The reference follows
a slow drift of the clocks. A leap ahead is a loss as well, until the stamps are seen to progress with the clock again.

After a loss the input is back when it has kept up with the reference for `_KEEPS_UP` (what waited in a queue has been
read), or with a new reference for `_NEW_REFERENCE` (its clock has been set). A crawl keeps up with neither.
"""

from typing import Final

from vehicle_models.nanoseconds import NANOSECOND
from vehicle_models.physical_bounds import NEW_RUN

LAG: Final = 0.035
"""Lag of the stamps, beyond the input's period, with which it is lost [s]: 50 ms, less a period of the watch."""
_FIRST_REFERENCE: Final = 0.2
"""Time at the start in which the period is learned [s]."""
_KEEPS_UP: Final = 0.05
_NEW_REFERENCE: Final = 0.5
_LEAP: Final = 0.05
"""Stamps that are ahead of the reference by more have been set, not delayed less [s]."""
_DRIFT: Final = 1e-3
"""Highest drift of two clocks against each other [-]."""
_FIRST_PERIOD: Final = 0.005
_LONGEST_PERIOD: Final = 0.1
_PERIOD_GAIN: Final = 0.125
"""Weight of the newest step in the mean of the stamps' steps, which is the period; the first steps weigh alike."""


class StampProgress:
    """Follows one input: `note` its stamps as they are accepted, and `poll` with the clock every 10 ms or so."""

    def __init__(self) -> None:
        """Start without a message: lost."""
        self.period = _FIRST_PERIOD
        """Mean step between stamps [s], at most 0.1."""
        self.lost = True
        """Whether the input may not be relied upon, at the last poll."""
        self.lag = 0.0
        """Age of the newest stamp beyond the reference at the last poll [s]; 0 before the first message."""
        self._now = 0.0
        self._newest = 0
        self._steps = 0
        self.reference: float | None = None
        """Least age of a stamp on arrival by the steady clock [s], whose zero is any; None while it is being learned.
        Those of two inputs differ by their transport, unless their clocks differ."""
        self._keeps_up_since: float | None = None
        self._candidate = 0.0
        self._candidate_since: float | None = None

    @property
    def came(self) -> bool:
        """Whether there ever was a message."""
        return self._newest > 0

    def note(self, stamp: int) -> None:
        """Take the stamp [ns] of a message whose content is good; zero, repeated and late ones are no progress."""
        step = stamp - self._newest
        if stamp <= 0 or -NEW_RUN < step <= 0:
            return
        if self._newest > 0 and 0 < step * NANOSECOND <= 2.0 * _LONGEST_PERIOD:
            self._steps += 1
            gain = max(1.0 / self._steps, _PERIOD_GAIN)
            period = self.period + gain * (step * NANOSECOND - self.period)
            self.period = min(period, _LONGEST_PERIOD)
        self._newest = stamp

    def poll(self, now: float, quiet: float) -> bool:
        """Return whether the input is lost.

        Args:
            now: time of the steady clock [s], not before that of the last poll.
            quiet: time since the last message of any content came [s], inf before the first.
        """
        passed, self._now = now - self._now, now
        if not self.came:
            return True
        age = now - self._newest * NANOSECOND
        limit = LAG + self.period
        # An upper bound of the newest stamp's age on arrival: what came after it may have been refused.
        on_arrival = age - quiet
        self._follow_candidate(age, on_arrival, limit)
        if self.reference is None:
            self.lag = 0.0
            self.lost = self._candidate_steady_for() < _FIRST_REFERENCE
            if not self.lost:
                self.reference = self._candidate
            return self.lost
        self.reference += _DRIFT * min(passed, 1.0)
        self.lag = age - self.reference
        if not -_LEAP <= self.lag <= limit:
            self.lost, self._keeps_up_since = True, None
        else:
            self.reference = min(self.reference, on_arrival)
            if self._keeps_up_since is None:
                self._keeps_up_since = now
            self.lost = self.lost and now - self._keeps_up_since < _KEEPS_UP
        if self.lost and self._candidate_steady_for() >= _NEW_REFERENCE:
            self.reference, self.lost, self.lag = self._candidate, False, age - self._candidate
        return self.lost

    def is_old(self, stamp: int) -> bool:
        """Whether a stamp [ns] lay too far back at the last poll for an answer to it to be of use."""
        if self.reference is None:
            return False
        return self._now - stamp * NANOSECOND - self.reference > LAG + self.period

    def _follow_candidate(self, age: float, on_arrival: float, limit: float) -> None:
        """Look for stamps that progress with the clock: their age stays within the limits of an input."""
        since = self._candidate_since
        if since is None or not -_LEAP <= age - self._candidate <= limit:
            self._candidate, self._candidate_since = on_arrival, self._now
        else:
            self._candidate = min(self._candidate, on_arrival)

    def _candidate_steady_for(self) -> float:
        return 0.0 if self._candidate_since is None else self._now - self._candidate_since
