"""Vertical load of a wheel from the acceleration of the car: load transfer behind the pitch of the body.

The springs pass the load q moved to the front axle on only as the body pitches, a damped oscillation of natural
frequency w and damping ratio z:

    q_ddot = w^2 (q_ss - q) - 2 z w q_dot,    q_ss = -m a h / L,    Fz = Fz_rest +- q / (wheels of the axle)

A lag of first order has the delay of this but not its rate, and the rate is what (8.3) needs: through the build-up of a
stop it errs by half the rate, and after it by the sign. With the acceleration linear in between, the step from one
sample to the next is exact.
"""

from math import cos, exp, pi, sin, sqrt
from typing import Final

from vehicle_models.nanoseconds import NANOSECOND
from vehicle_models.vehicle import Vehicle

LEAST_SHARE: Final = 0.1
"""Smallest load over that at rest: a wheel that lifts is not described, and a division by its load stays finite."""


class WheelLoad:
    """Load of one wheel, sample by sample."""

    def __init__(self, vehicle: Vehicle, wheel: str) -> None:
        """Start at rest.

        Args:
            vehicle: its mass, load share, height of the centre of gravity, wheelbase and pitch are used.
            wheel: name of the wheel.

        Raises:
            KeyError: there is no wheel of this name.
        """
        self.at_rest = vehicle.corner(wheel).vertical_load
        """Load without acceleration [N]."""
        share = vehicle.transfer_shares[vehicle.wheel_names.index(wheel)]
        self.transfer = -share * vehicle.mass
        """Steady change of load over acceleration, forward positive [kg]; 0 where there is one axle only."""
        self._frequency = 2.0 * pi * vehicle.pitch_frequency
        self._damping = vehicle.pitch_damping
        self.reset()

    def reset(self) -> None:
        """Forget the past: the next acceleration is taken to have lasted."""
        self._stamp: int | None = None
        self._settled = 0.0
        self._moved = 0.0
        self.rate = 0.0
        """dFz/dt [N/s], forgetting LEAST_SHARE."""

    @property
    def load(self) -> float:
        """Fz [N], at least LEAST_SHARE of that at rest."""
        return max(self.at_rest + self._moved, LEAST_SHARE * self.at_rest)

    def update(self, stamp: int, acceleration: float) -> None:
        """Take the acceleration of the car at a stamp.

        Args:
            stamp: [ns], later than the last.
            acceleration: [m/s^2], forward positive, finite.
        """
        settled = self.transfer * acceleration
        if self._stamp is None:
            self._moved, self.rate = settled, 0.0
        else:
            self._step((stamp - self._stamp) * NANOSECOND, settled)
        self._stamp, self._settled = stamp, settled

    def _step(self, dt: float, settled: float) -> None:
        w, z = self._frequency, self._damping
        slope = (settled - self._settled) / dt
        # Behind a ramp of q_ss the mode moves steadily, 2 z / w late; what differs from that is a free oscillation.
        behind = 2.0 * z / w * slope
        away, rate = self._moved - (self._settled - behind), self.rate - slope
        damped = w * sqrt(1.0 - z * z)
        decay, c, s = exp(-z * w * dt), cos(damped * dt), sin(damped * dt) / damped
        self._moved = settled - behind + decay * ((c + z * w * s) * away + s * rate)
        self.rate = slope + decay * ((c - z * w * s) * rate - w * w * s * away)
