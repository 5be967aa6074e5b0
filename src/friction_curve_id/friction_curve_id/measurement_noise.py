"""Measurement noise of wheel speed, vehicle speed and torque."""

from dataclasses import dataclass
from math import sqrt

from friction_parameters.parameter import parameter


@dataclass(frozen=True)
class MeasurementNoise:
    """White noise of the measurements; the defaults are those of section 8.3.2."""

    wheel_speed_variance: float = parameter(
        0.005, "variance of a measured wheel speed", unit="rad^2/s^2", minimum=1e-8, maximum=100.0
    )
    speed_variance: float = parameter(
        0.25, "variance of the measured vehicle speed", unit="m^2/s^2", minimum=1e-6, maximum=100.0
    )
    torque_variance: float = parameter(
        10.0,
        "variance of the brake torque, including errors of the wheel model",
        unit="N^2 m^2",
        minimum=1e-4,
        maximum=1e6,
    )

    @property
    def wheel_speed(self) -> float:
        """Standard deviation of a wheel speed [rad/s]."""
        return sqrt(self.wheel_speed_variance)

    @property
    def speed(self) -> float:
        """Standard deviation of the vehicle speed [m/s]."""
        return sqrt(self.speed_variance)

    @property
    def torque(self) -> float:
        """Standard deviation of the brake torque [N m]."""
        return sqrt(self.torque_variance)
