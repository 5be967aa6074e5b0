"""Vehicle speed by dead reckoning from the wheel and the brake alone.

Eliminating Fx from (2.15) gives m v_dot = -(J omega_dot + T_b) / r, hence

    v(t) = v0 - (J / (m r)) (omega(t) - omega(0)) - (1 / (m r)) integral of T_b dt.

The noise of omega enters scaled by J / (m r), some 0.015 m per rad, and that of T_b integrated: a thousandth of
what a speed sensor with 0.5 m/s gives. What remains is the anchor v0 and the model: an error of m, J or of the
torque's gain, a slope of the road or the drag of the air makes the speed drift. The anchor is omega r while the
wheel rolls freely (no brake torque at the start, or none for a while: a wheel just released still slips), and a
measured speed, where there is one, weighted by its variance.
"""

from typing import Final

from friction_curve_id.interface import Refusal
from friction_curve_id.measurement_noise import MeasurementNoise
from vehicle_models.reason import Reason
from vehicle_models.vehicle import CornerParameters

_UNKNOWN = float("inf")
"""Variance of an unknown speed."""
_RECOVERY_TIME: Final = 0.2
"""A wheel released this long [s] rolls freely again."""
FREE_ROLLING_TORQUE: Final = 15.0
"""Brake torque [N m], five times its noise, below which the wheel rolls freely: v = omega r."""
_ACCELERATION_ERROR: Final = 0.3
"""Error of the model's acceleration of the vehicle [m/s^2]: drag, slope, errors of its parameters."""


class DeadReckonedSpeed:
    """Speed of the vehicle at one wheel, one scalar Kalman step per sample."""

    def __init__(self, wheel: CornerParameters, noise: MeasurementNoise = MeasurementNoise()) -> None:
        """Start without an anchor."""
        self._wheel = wheel
        self._noise = noise
        self.reset()

    def reset(self) -> None:
        """Forget the anchor."""
        self._speed: float | None = None
        self._variance = 0.0
        self._released_for = 0.0

    def start(self, wheel_speed: float, measured: float | None, torque: float) -> float | Refusal:
        """Anchor at a first sample: wheel speed [rad/s], measured speed [m/s] or None, brake torque [N m].

        Returns:
            The speed [m/s], or a refusal while the wheel is braked and no speed is measured.
        """
        self.reset()
        free = abs(torque) <= FREE_ROLLING_TORQUE
        if not free and measured is None:
            return Refusal(Reason.NO_SLIP, "no vehicle speed: none is measured, and no sample of free rolling came yet")
        return self._correct(0.0, _UNKNOWN, wheel_speed, measured, free)

    def advance(
        self, duration: float, wheel_speed_change: float, mean_torque: float, wheel_speed: float, measured: float | None
    ) -> float:
        """Advance by `duration` [s] over which omega changed [rad/s] under the mean torque [N m]; return v [m/s].

        Raises:
            RuntimeError: there is no anchor.
        """
        if self._speed is None:
            raise RuntimeError("advance before start")
        w = self._wheel
        predicted = self._speed - (w.inertia * wheel_speed_change + mean_torque * duration) / (w.mass * w.radius)
        drift = _ACCELERATION_ERROR * duration
        variance = self._variance + drift * drift
        released = abs(mean_torque) <= FREE_ROLLING_TORQUE
        self._released_for = self._released_for + duration if released else 0.0
        return self._correct(predicted, variance, wheel_speed, measured, self._released_for >= _RECOVERY_TIME)

    def _correct(self, speed: float, variance: float, wheel_speed: float, measured: float | None, free: bool) -> float:
        noise, radius = self._noise, self._wheel.radius
        if free:
            rolling_variance = noise.wheel_speed_variance * radius * radius
            speed, variance = _weigh(speed, variance, wheel_speed * radius, rolling_variance)
        if measured is not None:
            speed, variance = _weigh(speed, variance, measured, noise.speed_variance)
        self._speed, self._variance = speed, variance
        return speed


def _weigh(value: float, variance: float, measured: float, measured_variance: float) -> tuple[float, float]:
    if variance == _UNKNOWN:
        return measured, measured_variance
    gain = variance / (variance + measured_variance)
    return value + gain * (measured - value), (1.0 - gain) * variance
