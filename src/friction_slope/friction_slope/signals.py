"""Wheel signals of (8.3) from the last samples.

    H = omega_ddot + T_b_dot / J = d^2 z / dt^2,    z = omega + (1/J) integral of T_b dt    (8.3)

With a vertical load that changes, J z_dot = r Fz mu, the same equation has a second part, and the slope is in the rest:

    z_ddot - z_dot Fz_dot / Fz = (r Fz / J) mu_1 slip_rate

The two terms of H are thousands of rad/s^3 while the torque changes, and cancel to tens. Taken from z as one second
derivative they pass the same filter and cancel exactly; taken apart they would leave the difference of two filters.
"""

from math import log, nan
from typing import Final

from friction_slope.derivatives import LocalPolynomial
from friction_slope.estimate import SlopeSample
from vehicle_models.nanoseconds import NANOSECOND

_OMEGA: Final = 0
_Z: Final = 1
_SLIP: Final = 2
_SLIP_RATE: Final = 3
_ACCELERATION: Final = 4
_LOG_LOAD: Final = 5
_TORQUE: Final = 6
_SIGNALS: Final = 7


class SignalWindow:
    """The last samples of one wheel, and the signals read from them once the windows are full."""

    def __init__(self, inertia: float, window: int, rate_window: int, lead: float) -> None:
        """Start empty.

        Args:
            inertia: wheel inertia J [kg m^2], > 0.
            window: samples N for H, >= 3; >= 4 with a lead.
            rate_window: samples for the first derivatives, >= 2.
            lead: where H is read: 0 at the centre of its window (parabola, least noise), 1 at the newest sample, beyond
                1 ahead of it (cubic).
        """
        self._inertia = inertia
        self._lead = lead
        self._window = LocalPolynomial(window, degree=2 if lead == 0.0 else 3, signals=_SIGNALS)
        self._rates = LocalPolynomial(rate_window, degree=1, signals=_SIGNALS)
        self.reset()

    def reset(self) -> None:
        """Forget every sample."""
        self._window.reset()
        self._rates.reset()
        self._impulse = 0.0
        self._last: SlopeSample | None = None
        self.delay = 0.0
        """Delay of h and slip behind the newest sample [s]; negative where they are predicted."""
        self._rate_delay = 0.0

    @property
    def ready(self) -> bool:
        """Whether the windows are full."""
        return self._window.ready and self._rates.ready

    def update(self, sample: SlopeSample, slip: float = nan, load: float = nan) -> None:
        """Take a sample, later than the last, with finite wheel speed and torque.

        Args:
            sample: its slip is not used.
            slip: slip that the tyre has built up [-], NaN where unknown.
            load: vertical load [N], > 0, NaN where unknown.
        """
        if self._last is not None:
            dt = (sample.stamp - self._last.stamp) * NANOSECOND
            self._impulse += 0.5 * dt * (self._last.brake_torque + sample.brake_torque)
        self._last = sample
        z = sample.wheel_speed + self._impulse / self._inertia
        torque = sample.brake_torque
        values = [sample.wheel_speed, z, slip, sample.slip_rate, sample.acceleration, log(load), torque]
        self._window.update(sample.stamp, values)
        self._rates.update(sample.stamp, values)
        self.delay = 0.5 * self._window.span * (1.0 - self._lead)
        self._rate_delay = 0.5 * self._rates.span

    def h(self) -> float:
        """H of (8.3), omega_ddot + T_b_dot / J = (r Fz / J) mu_1 slip_rate [rad/s^3], at a constant load."""
        return self._window.derivative(2, self.delay, _Z)

    def h_of_load(self) -> float:
        """Part of H that a changing load has caused, z_dot Fz_dot / Fz [rad/s^3]; NaN if the load was unknown."""
        load_rate = self._window.derivative(1, self.delay, _LOG_LOAD)
        return self._window.derivative(1, self.delay, _Z) * load_rate

    def torque_rate(self) -> float:
        """T_b_dot / J [rad/s^3], where h is read."""
        return self.h() - self._window.derivative(2, self.delay, _OMEGA)

    def torque_jerk(self) -> float:
        """T_b_ddot / J [rad/s^4], where h is read."""
        return self._window.derivative(2, self.delay, _TORQUE) / self._inertia

    def slip(self) -> float:
        """Slip that the tyre has built up [-]; NaN if it was unknown anywhere in the window."""
        return self._window.derivative(0, self.delay, _SLIP)

    def slip_rate(self) -> float:
        """Mean slip rate over the rate window [1/s]; NaN if it was unknown anywhere in it."""
        return self._rates.derivative(0, self._rate_delay, _SLIP_RATE)

    def wheel_acceleration(self) -> float:
        """omega_dot [rad/s^2], mean over the rate window."""
        return self._rates.derivative(1, self._rate_delay, _OMEGA)

    def acceleration(self) -> float:
        """Acceleration of the car [m/s^2], mean over the rate window; NaN if it was unknown anywhere in it."""
        return self._rates.derivative(0, self._rate_delay, _ACCELERATION)

    def earlier_h(self, load_known: bool) -> float:
        """H [rad/s^3] in the older half of its window; where the load is known, without the part of its change."""
        h = self._window.earlier(2, _Z)
        return h - self._window.earlier(1, _Z) * self._window.earlier(1, _LOG_LOAD) if load_known else h

    def earlier_slip(self) -> float:
        """Slip that the tyre had built up in the older half of the window of h; NaN if unknown anywhere in it."""
        return self._window.earlier(0, _SLIP)

    def earlier_slip_rate(self) -> float:
        """Slip rate [1/s] in the older half of the window of h; NaN if it was unknown anywhere in it."""
        return self._window.earlier(0, _SLIP_RATE)

    def earlier_wheel_acceleration(self) -> float:
        """omega_dot [rad/s^2] in the older half of the window of h."""
        return self._window.earlier(1, _OMEGA)

    def earlier_friction_moment(self) -> float:
        """r Fx [N m], braking positive, in the older half of the window of h."""
        return self._inertia * self._window.earlier(1, _Z)

    @property
    def span(self) -> float:
        """Time that the window of h spans [s]."""
        return self._window.span

    def scatter(self) -> float:
        """Standard deviation of z about the polynomial that gives h [rad/s]: noise and what else swings."""
        return self._window.scatter(_Z)

    def friction_moment(self) -> float:
        """r Fx = J z_dot = J omega_dot + T_b [N m], braking positive, mean over the rate window."""
        return self._inertia * self._rates.derivative(1, self._rate_delay, _Z)
