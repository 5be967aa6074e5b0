"""The driver's foot: line pressure over time."""

from dataclasses import dataclass


@dataclass(frozen=True)
class DriverProfile:
    """Nothing until `start`, a ramp to `pressure` within `rise`, `hold`, and a ramp back to nothing within `release`.

    A rise or release of 0 is a step.
    """

    pressure: float
    """Line pressure held [Pa], >= 0."""
    start: float
    """Start of the rise [s since the start of the run], >= 0."""
    rise: float
    """Duration of the rise [s], >= 0."""
    hold: float
    """Duration at full pressure [s], >= 0."""
    release: float
    """Duration of the release [s], >= 0."""

    def __post_init__(self) -> None:
        """Refuse negative values."""
        for name in ("pressure", "start", "rise", "hold", "release"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name} must be >= 0, is {getattr(self, name)}")

    def demand(self, time: float) -> float:
        """Line pressure [Pa] that the driver demands at `time` [s since the start of the run]."""
        since_start = time - self.start
        if since_start < 0.0:
            return 0.0
        if since_start < self.rise:
            return self.pressure * since_start / self.rise
        since_release = since_start - self.rise - self.hold
        if since_release < 0.0:
            return self.pressure
        if since_release < self.release:
            return self.pressure * (1.0 - since_release / self.release)
        return 0.0
