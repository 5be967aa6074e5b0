"""White measurement noise of section 8.3.2."""

from dataclasses import dataclass


@dataclass(frozen=True)
class SensorNoise:
    """Variances of the additive white noise of the sensors."""

    wheel_speed_variance: float = 0.005
    """[rad^2/s^2]"""
    speed_variance: float = 0.25
    """[m^2/s^2]"""
    torque_variance: float = 10.0
    """[N^2 m^2]"""


CHAPTER_NOISE = SensorNoise()
NO_NOISE = SensorNoise(0.0, 0.0, 0.0)
