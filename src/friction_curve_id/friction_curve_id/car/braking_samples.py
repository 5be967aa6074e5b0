"""Samples of a braking and of the time before it, oldest first, in arrays of fixed capacity."""

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
        self._work = np.zeros((wheels, capacity))
        self._acceleration = np.zeros(capacity)
        self._speed_change = np.zeros(capacity)
        self._closed = np.zeros(capacity)
        self._yaw_rate = np.zeros(capacity)
        self._leftward = np.zeros(capacity)
        self._sideways = np.zeros(capacity)
        self._rolled = np.zeros(capacity)
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
    def work(self) -> Array:
        """Work of the brakes at nominal gain since the first sample of all [J], shape (W, n)."""
        return self._work[:, : self.count]

    @property
    def acceleration(self) -> Array:
        """Accelerations [m/s^2], shape (n,)."""
        return self._acceleration[: self.count]

    @property
    def speed_change(self) -> Array:
        """Integral of the acceleration [m/s], shape (n,)."""
        return self._speed_change[: self.count]

    @property
    def closed(self) -> Array:
        """1 where the throttle is closed, shape (n,)."""
        return self._closed[: self.count]

    @property
    def yaw_rate(self) -> Array:
        """Yaw rates, counter-clockwise [rad/s], shape (n,)."""
        return self._yaw_rate[: self.count]

    @property
    def leftward(self) -> Array:
        """Lateral accelerations, to the left [m/s^2], shape (n,)."""
        return self._leftward[: self.count]

    @property
    def sideways(self) -> Array:
        """Integral of the lateral acceleration less the centripetal one [m/s], shape (n,)."""
        return self._sideways[: self.count]

    @property
    def rolled(self) -> Array:
        """Lateral accelerations whose steady load transfer acts [m/s^2], shape (n,)."""
        return self._rolled[: self.count]

    def turn(self, yaw_rate: float, leftward: float, sideways: float, rolled: float) -> None:
        """Add the motion across the car to the newest sample, which has none."""
        k = self.count - 1
        self._yaw_rate[k], self._leftward[k] = yaw_rate, leftward
        self._sideways[k], self._rolled[k] = sideways, rolled

    def straighten(self) -> None:
        """Forget the motion across the car."""
        self._yaw_rate[:] = self._leftward[:] = self._sideways[:] = self._rolled[:] = 0.0

    def clear(self) -> None:
        """Forget all samples."""
        self.count = 0

    def append(
        self, time: float, wheel_speed: Array, torque: Array, acceleration: float, gained: float, closed: bool
    ) -> None:
        """Add a sample; the caller keeps room. `gained`: integral of the acceleration since the last one [m/s]."""
        k = self.count
        self._time[k] = time
        self._wheel_speed[:, k] = wheel_speed
        self._torque[:, k] = torque
        self._work[:, k] = 0.0
        if k > 0:
            done = 0.5 * (self._torque[:, k - 1] + torque) * wheel_speed * (time - self._time[k - 1])
            self._work[:, k] = self._work[:, k - 1] + done
        self._acceleration[k] = acceleration
        self._closed[k] = closed
        self._yaw_rate[k] = self._leftward[k] = self._sideways[k] = self._rolled[k] = 0.0
        self._speed_change[k] = gained + (self._speed_change[k - 1] if k > 0 else 0.0)
        self.count = k + 1

    def close_throttle(self, since: float) -> None:
        """Take the throttle as closed from `since` [s] on."""
        self.closed[self.time >= since] = 1.0

    def drop_oldest(self, number: int) -> None:
        """Forget the oldest samples."""
        keep = self.count - number
        across = (self._yaw_rate, self._leftward, self._sideways, self._rolled)
        arrays = (self._time, self._acceleration, self._speed_change, self._closed, *across)
        for array in (*arrays, self._wheel_speed, self._torque, self._work):
            array[..., :keep] = array[..., number : self.count].copy()
        self.count = keep
