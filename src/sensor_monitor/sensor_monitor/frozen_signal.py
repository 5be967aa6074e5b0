"""Frozen signal check: a sensor that repeats one value to the last bit."""

from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS

_STUCK_AFTER: Final = round(0.25 * NANOSECONDS)


class FrozenSignal:
    """Watches one value. Noise moves the last bits of a live sensor; a dead one repeats its last value."""

    def __init__(self) -> None:
        """Start without samples."""
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._value: float | None = None
        self._since = 0

    def repeats(self, stamp: int, value: float | None) -> bool:
        """Take a value at a stamp [ns]; return whether it has been exactly the same for 0.25 s."""
        if value is None or value != self._value:
            self._value, self._since = value, stamp
        return value is not None and stamp - self._since >= _STUCK_AFTER
