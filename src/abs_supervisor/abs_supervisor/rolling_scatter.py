"""Free-rolling noise: scatter of slip and deceleration of an unbraked wheel.

A wheel that is not braked has no slip, and no deceleration of its own: what is measured then is error (ripple of the
encoder, a radius that is not right, noise of the speed) and will be there under braking too. An eccentric encoder wheel
errs by a share of the wheel speed, once per revolution: in slip that is the same at all speeds, in deceleration it goes
with the square of the wheel speed. So both are learned in these units.
"""

from math import isfinite, sqrt
from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS

_SLOWEST: Final = 10.0
"""[rad/s] slower wheels tell too little."""
_FREE_FOR: Final = 0.1
"""[s] after the brake until a wheel counts as rolling freely."""
_MEMORY: Final = 200.0
"""Samples over which errors are averaged: several revolutions."""
_ENOUGH: Final = 20
"""Samples from which something counts as learned."""
_ORDINARY_SLIP: Final = 0.005
"""Error of slip with the sensors that friction_curve_id is tuned for."""
_MOST_SLIP: Final = 0.05
"""A larger mean error of slip is a wrong speed or a driven wheel, not scatter."""


class RollingScatter:
    """Root mean squares of the errors of one wheel."""

    def __init__(self) -> None:
        """Start with nothing learned."""
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._slip = self._stated = self._rate = 0.0
        self._slips = self._rates = 0
        self._braked: int | None = None

    @property
    def slip(self) -> float:
        """Root mean square error of slip beyond what its own variance says [-]; 0 where nothing was learned."""
        return min(sqrt(max(self._slip - self._stated, 0.0)), _MOST_SLIP)

    @property
    def slip_of_curve(self) -> float:
        """Root mean square error of slip beyond what a curve takes into account [-]; 0 where nothing was learned."""
        return min(sqrt(max(self._slip - _ORDINARY_SLIP**2, 0.0)), _MOST_SLIP)

    @property
    def learned(self) -> bool:
        """Whether the wheel has been seen to roll freely for long enough."""
        return self._rates >= _ENOUGH

    def rate(self, wheel_speed: float) -> float:
        """Root mean square error of a deceleration [rad/s^2] at a wheel speed [rad/s]; 0 where nothing was learned."""
        return sqrt(self._rate) * wheel_speed * wheel_speed

    def update(self, stamp: int, braked: bool, wheel_speed: float, rate: float, slip: float, variance: float) -> None:
        """Take what is known at a stamp [ns].

        Args:
            stamp: [ns].
            braked: whether the wheel is braked, or a demand is there.
            wheel_speed: [rad/s].
            rate: of the wheel speed [rad/s^2], NaN where unknown.
            slip: [-], NaN where unknown.
            variance: of slip as stated [-].
        """
        if braked or self._braked is None:
            self._braked = stamp
        if stamp - self._braked < _FREE_FOR * NANOSECONDS or wheel_speed < _SLOWEST:
            return
        if isfinite(rate):
            self._rates += 1
            scatter = rate / (wheel_speed * wheel_speed)
            self._rate += (scatter * scatter - self._rate) / min(self._rates, _MEMORY)
        if isfinite(slip):
            self._slips += 1
            share = 1.0 / min(self._slips, _MEMORY)
            self._slip += share * (slip * slip - self._slip)
            self._stated += share * (variance - self._stated)
