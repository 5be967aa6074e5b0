"""The slip estimator through a recorded drive, as the node feeds it: pressures later, readings by the vehicle file."""

from collections.abc import Iterator
from math import nan
from typing import Final

import numpy as np
from geometry_msgs.msg import Vector3
from numpy.typing import NDArray

from corner_sim.car.recording import Recording
from vehicle_models.vehicle import Vehicle
from wheel_slip.estimate import WheelEstimate
from wheel_slip.estimator import SlipEstimator

Array = NDArray[np.float64]

INTERVAL: Final = 1.96
"""Deviations of a 95 % interval."""
LEAST_SPEED: Final = 3.0
"""Speed below which nothing is judged [m/s]."""
_BASE_STAMP = 1_000_000_000
_LATE = 0.02
"""Time after which the node uses a brake pressure [s]."""


def estimates(
    estimator: SlipEstimator, run: Recording, vehicle: Vehicle, yaw_rate: Array | None = None
) -> Iterator[list[WheelEstimate]]:
    """Yield the estimates of all wheels at each sample of a recording.

    Args:
        estimator: of the same car.
        run: the recording.
        vehicle: the car as the estimator knows it.
        yaw_rate: as measured [rad/s], shape (N,); None where it is not.
    """
    mounting = vehicle.accelerometer
    gains = [wheel.brake_gain for wheel in vehicle.wheels]
    unknown = [[nan] * len(gains)] * round(_LATE / (run.time[1] - run.time[0]))
    torques = (unknown + (run.brake_pressure * gains).tolist())[: len(run.time)]
    turns = [None] * len(run.time) if yaw_rate is None else yaw_rate.tolist()
    for time, wheel_speeds, reading, torque, turn in zip(
        run.time, run.wheel_speed, run.acceleration, torques, turns, strict=True
    ):
        stamp = _BASE_STAMP + round(time * 1e9)
        forward = mounting.forward(Vector3(x=float(reading)))
        yield estimator.update(stamp, wheel_speeds.tolist(), forward, torques=torque, yaw_rate=turn)


def covered(z: Array) -> float:
    """Return the share of errors over their deviations that are inside the 95 % interval [%]."""
    return 100.0 * float(np.mean(np.abs(z) < INTERVAL))
