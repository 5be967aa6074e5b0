"""Schedule of the samples on the wall clock."""

from corner_sim.plant import SAMPLE_TIME

_MAX_LAG = 0.5
"""Wall time [s] behind schedule beyond which the schedule is shifted: what subscribers' queues hold at 200 Hz."""


class Pace:
    """Schedule of samples against the steady clock.

    The schedule is absolute, so the mean rate does not drift. After a stall the samples that are due follow at once,
    and are counted; after a stall longer than 0.5 s the schedule shifts, and the shift is counted too. No sample is
    left out.
    """

    def __init__(self, real_time_factor: float, now: float) -> None:
        """Make the first sample due at `now` [s, steady clock]; factor > 0, or 0: always due."""
        self._period = SAMPLE_TIME / real_time_factor if real_time_factor > 0.0 else 0.0
        self._next = now
        self.overruns = 0
        """Samples that came more than one period late."""
        self.worst_lateness = 0.0
        """Largest delay of a sample behind the schedule [s]."""
        self.shifted = 0.0
        """Wall time by which the schedule was shifted after stalls [s]."""

    def due(self, now: float) -> bool:
        """Whether the next sample is due now or within half a period, so that a slightly early timer serves it."""
        return now >= self._next - 0.5 * self._period

    def taken(self, now: float) -> None:
        """Note that the due sample is taken at `now` [s]."""
        if self._period > 0.0:
            lateness = now - self._next
            self.worst_lateness = max(self.worst_lateness, lateness)
            self.overruns += lateness > self._period
            if lateness > _MAX_LAG:
                self.shifted += lateness
                self._next = now
        self._next += self._period
