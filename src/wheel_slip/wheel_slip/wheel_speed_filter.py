"""Speed and acceleration of one wheel from noisy samples at irregular times: a Kalman filter with white jerk.

    d/dt [omega, omega_dot] = [omega_dot, w],    z = omega + n

The density q of w and the variance R of n set the bandwidth, (q / (R T))^(1/4) [rad/s] at sample time T. Sample times
from 1 to 40 ms and bursts of near-equal stamps are handled by the exact discretisation.

A rolling wheel is quiet, one in an ABS cycle has a hundred times its jerk. So q adapts: with m the mean of the squared
innovation over the last samples, in units of what it is for a quiet wheel,

    q = q_0 max(1, m / 2)^2

Noise alone hardly reaches m = 2, so that the smoothing of a quiet wheel stays what q_0 makes it. Above 200 Hz one
innovation says little of a lag, and what is squared is their mean over 4.5 ms.

A speed from the times of edges is that of a time before its stamp: by half a sample, or half a tooth where there are
fewer, and half a tooth more. What the wheel has done since is not seen, and is in the variance.
"""

from dataclasses import dataclass
from math import nan, pi, sqrt
from typing import Final

from friction_parameters.parameter import parameter
from sensor_monitor.missing_tooth import MissingTooth
from vehicle_models.nanoseconds import NANOSECONDS

_FIRST_ACCELERATION_VARIANCE: Final = 100.0**2
"""Variance of an unknown acceleration [rad^2/s^4]: ten times that of a wheel that rolls in a hard stop, squared."""
_MEMORY: Final = 0.3
"""Share of the newest sample in the mean squared innovation: six samples, of which noise seldom makes twice its own.

A number of samples up to 200 Hz, for so many squares of noise have that mean, and of the times _TOGETHER above.
"""
_TOGETHER: Final = 0.0045
"""Time over which innovations are averaged before they are squared [s]: a lag makes all of them alike, noise none."""
_KNEE: Final = 2.0
"""Mean squared innovation above which the wheel is no longer quiet."""
_LARGEST_GAIN: Final = 1e4
"""Largest factor on the density q: the acceleration of a wheel that locks changes by 400 rad/s^2 in 5 ms."""
_SLOWEST: Final = 1e-3
"""Speed of a wheel that stands [rad/s]."""
_AGE_SHARE: Final = 0.35
"""Deviation of the age as a share of it: the last edge is anywhere within a tooth."""
_SETTLE_TIME: Final = round(0.018 * NANOSECONDS)
"""Time [ns] after which the acceleration is measured, not assumed: to 5 rad/s^2 in five samples at 200 Hz."""


@dataclass(frozen=True)
class WheelFilterParameters:
    """Parameters of the filter of every wheel."""

    speed_stddev: float = parameter(0.07, "noise of a wheel speed", unit="rad/s", minimum=1e-4, maximum=10.0)
    jerk_density: float = parameter(
        3e3,
        "jerk density q_0 of a steady wheel (bandwidth of the filter)",
        unit="rad^2/s^5",
        minimum=1.0,
        maximum=1e9,
    )
    edges: bool = parameter(
        False,
        "wheel speeds are means between two edges of the encoder, up to a sample and a tooth old at their stamp",
    )
    missing_teeth: int = parameter(
        0,
        "missing teeth in a row of each ring, not corrected by the sender (60-2: 2 of 60 encoder_teeth)",
        minimum=0,
        maximum=4,
    )


class WheelSpeedFilter:
    """Filter of one wheel. `speed` and `acceleration` mean something after the first update."""

    def __init__(self, parameters: WheelFilterParameters, max_gap: float, teeth: int) -> None:
        """Start empty.

        Args:
            parameters: parameters of the filter.
            max_gap: gap [s] beyond which the filter starts again.
            teeth: teeth of the encoder, missing ones included.
        """
        self._pitch = 2.0 * pi / teeth if parameters.edges else 0.0
        self._gap = MissingTooth(parameters.missing_teeth, 2.0 * pi / teeth) if parameters.missing_teeth else None
        self._jerk_density = parameters.jerk_density
        self._max_gap = max_gap
        self.know_noise(parameters.speed_stddev**2, 0.0)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.speed = nan
        """Wheel speed [rad/s]; NaN before the first sample."""
        self.acceleration = 0.0
        """Wheel acceleration [rad/s^2]."""
        self.speed_variance = self._variance
        """[rad^2/s^2]"""
        self.age = 0.0
        """Age of a speed at its stamp [s]."""
        self.age_variance = 0.0
        """Of what the wheel has done since [rad^2/s^2]."""
        self.lag_variance = 0.0
        """Square of what the mean innovation shows of a lag, above 200 Hz [rad^2/s^2]; the filter's own has none."""
        self.acceleration_variance = _FIRST_ACCELERATION_VARIANCE
        """[rad^2/s^4]"""
        self.in_gap = False
        """Whether the last sample was that of missing teeth, and says nothing."""
        self.restarted_by_gap = False
        """Whether the last restart was caused by a gap."""
        self.settled = False
        """Whether there are enough samples since start or gap."""
        self._covariance = 0.0
        self._unrest = 1.0
        self._mean_innovation = 0.0
        self._mean_weight = 1.0
        self._stamp: int | None = None
        self._begin = 0
        if self._gap is not None:
            self._gap.reset()

    def know_noise(self, variance: float, lasting: float) -> None:
        """Take the variance of a wheel speed in place of the stated one, and the part that lasts [rad^2/s^2]."""
        self._variance = variance - lasting
        self.lasting_variance = lasting
        """Of what lasts of the noise, which the filter does not average out [rad^2/s^2]."""

    def update(self, stamp: int, measured: float) -> None:
        """Take a wheel speed [rad/s], finite, at a stamp [ns] later than the last."""
        dt = 0.0 if self._stamp is None else (stamp - self._stamp) / NANOSECONDS
        if self._stamp is None or dt > self._max_gap:
            gap = self._stamp is not None
            self.reset()
            self.restarted_by_gap = gap
            self.speed = measured
            self._begin = stamp
        else:
            self._step(dt, measured)
        self._stamp = stamp
        self.settled = stamp - self._begin >= _SETTLE_TIME

    def _step(self, dt: float, measured: float) -> None:
        """Predict over `dt` [s] and correct by the measured wheel speed [rad/s]."""
        r, q0 = self._variance, self._jerk_density
        q = q0 * min(max(1.0, self._unrest / _KNEE) ** 2, _LARGEST_GAIN)
        p11, p12, p22 = self.speed_variance, self._covariance, self.acceleration_variance
        p11 = p11 + dt * (2.0 * p12 + dt * (p22 + q * dt / 3.0))
        p12 = p12 + dt * (p22 + 0.5 * q * dt)
        p22 += q * dt
        speed = self.speed + dt * self.acceleration
        innovation = measured - speed
        self.in_gap = self._gap is not None and self._gap.holds(dt, speed, measured, sqrt(p11 + r + self.age_variance))
        if self.in_gap:
            self.speed = speed
            self.speed_variance, self._covariance, self.acceleration_variance = p11, p12, p22
        else:
            quiet = 1.6 * r + 1.5 * q0 * dt**3
            newest = min(dt / _TOGETHER, 1.0)
            self._mean_innovation = (1.0 - newest) * self._mean_innovation + newest * innovation
            self._mean_weight = (1.0 - newest) ** 2 * self._mean_weight + newest**2
            of_mean = quiet * self._mean_weight
            self._unrest += _MEMORY * newest * (self._mean_innovation**2 / of_mean - self._unrest)
            gain, acceleration_gain = p11 / (p11 + r), p12 / (p11 + r)
            self.speed = speed + gain * innovation
            self.acceleration += acceleration_gain * innovation
            self.speed_variance = gain * r
            self._covariance = acceleration_gain * r
            self.acceleration_variance = p22 - acceleration_gain * p12
            seen = max(self._mean_innovation**2 - of_mean, 0.0) if newest < 1.0 else 0.0
            self.lag_variance = (1.0 - gain) ** 2 * seen
        if self._pitch:
            tooth = min(self._pitch / max(abs(self.speed), _SLOWEST), self._max_gap)
            self.age = 0.5 * (max(dt, tooth) + tooth)
            moved = self.acceleration_variance + (_AGE_SHARE * self.acceleration) ** 2
            self.age_variance = self.age**2 * (moved + q * self.age / 3.0)
