"""Output of the slip estimator: one estimate per wheel and sample, with the reason where there is none."""

from collections.abc import Mapping
from enum import IntEnum
from typing import Final

from vehicle_models.reason import Reason


class SpeedSource(IntEnum):
    """Where the vehicle speed comes from; the values are those of friction_msgs/WheelSlip."""

    NONE = 0
    SENSOR = 1
    WHEELS = 2
    INTEGRATED = 3


class Mode(IntEnum):
    """Which inputs the vehicle speed is made of; the values are those of friction_msgs/WheelSlip."""

    WAITING = 0
    ROLLING = 1
    SLIDING = 2
    SENSOR_ROLLING = 3
    SENSOR_SLIDING = 4


SOURCES: Final[Mapping[Mode, SpeedSource]] = {
    Mode.WAITING: SpeedSource.NONE,
    Mode.ROLLING: SpeedSource.WHEELS,
    Mode.SLIDING: SpeedSource.INTEGRATED,
    Mode.SENSOR_ROLLING: SpeedSource.SENSOR,
    Mode.SENSOR_SLIDING: SpeedSource.SENSOR,
}
"""Where the speed comes from in each mode."""


class WheelEstimate:
    """Slip of one wheel at one sample. Unknown values are NaN; slip and slip_rate are NaN unless reason is OK."""

    def __init__(
        self,
        slip: float,
        slip_rate: float,
        vehicle_speed: float,
        wheel_speed: float,
        slip_variance: float,
        slip_rate_variance: float,
        vehicle_speed_variance: float,
        mode: Mode,
        reason: Reason,
        text: str,
    ) -> None:
        """Hold what is estimated.

        Args:
            slip: [-], braking positive.
            slip_rate: [1/s].
            vehicle_speed: [m/s].
            wheel_speed: [rad/s], filtered.
            slip_variance: [-].
            slip_rate_variance: [1/s^2].
            vehicle_speed_variance: [m^2/s^2].
            mode: which inputs the vehicle speed is made of.
            reason: why the slip is not valid.
            text: the reason in words, empty where it is OK.
        """
        self.slip = slip
        self.slip_rate = slip_rate
        self.vehicle_speed = vehicle_speed
        self.wheel_speed = wheel_speed
        self.slip_variance = slip_variance
        self.slip_rate_variance = slip_rate_variance
        self.vehicle_speed_variance = vehicle_speed_variance
        self.mode = mode
        self.source = SOURCES[mode]
        self.reason = reason
        self.text = text
