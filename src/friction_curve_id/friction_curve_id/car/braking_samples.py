"""Samples of a braking, oldest first, in arrays of fixed capacity."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class BrakingSamples:
    """The newest samples of W wheels; the integral of the acceleration goes on when old samples leave."""

    def __init__(self, wheels: int, capacity: int) -> None:
        """Reserve `capacity` samples of `wheels` wheels."""
        self._time = np.zeros(capacity)
        self._wheel_speed = np.zeros((wheels, capacity))
        self._torque = np.zeros((wheels, capacity))
        self._acceleration = np.zeros(capacity)
        self._speed_change = np.zeros(capacity)
        self._braked = np.zeros(capacity)
        self.count = 0

    @property
    def time(self) -> Array:
        """Stamps [s], shape (n,)."""
        return self._time[: self.count]

    @property
    def wheel_speed(self) -> Array:
        """Wheel speeds [rad/s], shape (W, n)."""
        return self._wheel_speed[:, : self.count]

    @property
    def torque(self) -> Array:
        """Brake torques at nominal gain [N m], shape (W, n)."""
        return self._torque[:, : self.count]

    @property
    def acceleration(self) -> Array:
        """Accelerations [m/s^2], shape (n,)."""
        return self._acceleration[: self.count]

    @property
    def speed_change(self) -> Array:
        """Integral of the acceleration since the first sample [m/s], shape (n,)."""
        return self._speed_change[: self.count]

    @property
    def braked(self) -> Array:
        """1 where the car brakes, shape (n,)."""
        return self._braked[: self.count]

    def clear(self) -> None:
        """Forget all samples."""
        self.count = 0

    def append(self, time: float, wheel_speed: Array, torque: Array, acceleration: float, braked: bool) -> None:
        """Add a sample; the caller keeps room."""
        k = self.count
        self._time[k] = time
        self._wheel_speed[:, k] = wheel_speed
        self._torque[:, k] = torque
        self._acceleration[k] = acceleration
        self._braked[k] = braked
        self._speed_change[k] = 0.0
        if k > 0:
            mean = 0.5 * (acceleration + self._acceleration[k - 1])
            self._speed_change[k] = self._speed_change[k - 1] + mean * (time - self._time[k - 1])
        self.count = k + 1

    def drop_oldest(self, number: int) -> None:
        """Forget the oldest samples."""
        keep = self.count - number
        arrays = (self._time, self._acceleration, self._speed_change, self._braked)
        for array in (*arrays, self._wheel_speed, self._torque):
            array[..., :keep] = array[..., number : self.count].copy()
        self.count = keep
