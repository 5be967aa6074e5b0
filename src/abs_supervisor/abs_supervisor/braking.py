"""Does the driver brake? The condition between S0 and the other states."""


class TorqueWithHysteresis:
    """Where there is no demand topic: from the wheel's own torque, which the supervisor's release takes to zero.

    Braking begins at the upper threshold, and is over when the torque has been below the lower one for the hold time,
    which is longer than a release.
    """

    def __init__(self, begin: float, end: float, hold: float) -> None:
        """Start not braking.

        Args:
            begin: T-bar [N m].
            end: lower threshold [N m], < begin.
            hold: [s], >= 0.
        """
        self._begin, self._end, self._hold_ns = begin, end, round(hold * 1e9)
        self.reset()

    def reset(self) -> None:
        """Forget the past."""
        self._braking = False
        self._last_braked: int | None = None

    def update(self, stamp: int, torque: float) -> bool:
        """Take the torque [N m] at a stamp [ns]; return whether the driver brakes."""
        if torque >= (self._end if self._braking else self._begin):
            self._braking = True
            self._last_braked = stamp
        elif self._last_braked is None or stamp - self._last_braked > self._hold_ns:
            self._braking = False
        return self._braking
