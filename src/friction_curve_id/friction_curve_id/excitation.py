"""Whether the latest samples say anything about the curve: torque changes, or a wheel that not just decelerates."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_TORQUE_SPAN = 8.0
_BEND = 6.0
"""Both in standard deviations of the measurement: twice what noise alone reaches within some ten samples."""


def is_excited(time: Array, wheel_speed: Array, torque: Array, wheel_speed_noise: float, torque_noise: float) -> bool:
    """Do torque [N m] or wheel speed [rad/s] over `time` [s], shapes (n,), differ from a constant and a straight line?

    Args:
        time: stamps, rising.
        wheel_speed: measured.
        torque: measured.
        wheel_speed_noise: standard deviation [rad/s].
        torque_noise: standard deviation [N m].
    """
    if float(np.ptp(torque)) > _TORQUE_SPAN * torque_noise:
        return True
    if len(time) < 4:
        return False
    centred = time - time.mean()
    trend = (centred @ wheel_speed) / (centred @ centred)
    bend = wheel_speed - wheel_speed.mean() - trend * centred
    return float(np.abs(bend).max()) > _BEND * wheel_speed_noise
