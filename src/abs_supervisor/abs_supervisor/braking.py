"""Detection of the driver's braking: the condition between S0 and the other states."""

from dataclasses import dataclass

from friction_parameters.parameter import constant, parameter
from vehicle_models.nanoseconds import NANOSECONDS


@dataclass(frozen=True)
class PressureParameters:
    """When braking is over, judged by the wheel's own brake pressure."""

    release_torque: float = parameter(
        20.0, "braking is over some time below this torque", unit="N m", minimum=0.0, maximum=1e4, read_only=True
    )
    release_hold: float = constant(0.2, "that time, longer than the supervisor's own release", unit="s")


class TorqueWithHysteresis:
    """Whether the driver brakes, from the wheel's own torque; for a car without a demand topic.

    The supervisor's release takes that torque to zero. So braking begins at the upper threshold, and is over when the
    torque has been below the lower one for the hold time, which is longer than a release.
    """

    def __init__(self, begin: float, end: PressureParameters) -> None:
        """Start not braking.

        Args:
            begin: T-bar [N m], above the release torque.
            end: when braking is over.
        """
        self._begin, self._end, self._hold_ns = begin, end.release_torque, round(end.release_hold * NANOSECONDS)
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
