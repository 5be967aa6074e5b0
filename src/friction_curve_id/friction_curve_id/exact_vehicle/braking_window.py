"""The latest samples of one braking, and the speed of the vehicle between them.

Eliminating Fx from (2.15) gives m v + (J / r) omega + (1 / r) integral of T_b dt = const. With that constant over m as
an unknown, the `momentum_speed` u [m/s], the speed at sample k is

    v_k = u - (J / (m r)) omega_k - I_k,   I_k = (1 / (m r)) integral of T_b dt up to sample k.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vehicle_models.vehicle import CornerParameters

Array = NDArray[np.float64]

SET_ASIDE = 1e-6
"""Weight of a measurement that is set aside: negligible, but it keeps the matrix regular."""

_SLOWEST = 0.1
"""Floor of the speed where slip is taken [m/s], far below what the gate admits."""


@dataclass(frozen=True)
class NewestSlip:
    """The newest slip and how it depends on the unknowns."""

    speed: float
    """Vehicle speed [m/s]."""
    slip: float
    per_u: float
    """d slip / d u [s/m]."""
    per_omega: float
    """d slip / d omega [s]."""


class BrakingWindow:
    """Arrays over the samples in the window, oldest first; `count` of them are in use."""

    def __init__(self, wheel: CornerParameters, capacity: int) -> None:
        """Make an empty window of at most `capacity` samples."""
        self._radius = wheel.radius
        self._per_impulse = 1.0 / (wheel.mass * wheel.radius)
        self.speed_per_wheel_speed = wheel.inertia / (wheel.mass * wheel.radius)
        """J / (m r) [m/rad]."""
        self.count = 0
        self.capacity = capacity
        self._rows = rows = np.zeros((9, capacity))
        self.time = rows[0]
        """[s]"""
        self.measured_wheel_speed = rows[1]
        """[rad/s]"""
        self.measured_speed = rows[2]
        """[m/s], 0 where missing."""
        self.has_speed = rows[3]
        """1 where the speed is measured, else 0."""
        self.torque = rows[4]
        """[N m]"""
        self.impulse = rows[5]
        """I_k [m/s]"""
        self.wheel_speed = rows[6]
        """Estimated omega [rad/s]."""
        self.wheel_speed_trust = rows[7]
        """Weight of the measured wheel speed, 1 or (set aside) nearly 0."""
        self.equation_trust = rows[8]
        """Weight of the wheel equation that leads to this sample, 1 or (set aside) nearly 0."""

    def speeds(self, momentum_speed: float) -> Array:
        """Vehicle speed at the samples [m/s], shape (count,), at least _SLOWEST."""
        n = self.count
        speed = momentum_speed - self.speed_per_wheel_speed * self.wheel_speed[:n] - self.impulse[:n]
        return np.maximum(speed, _SLOWEST)

    def slips(self, momentum_speed: float) -> Array:
        """Slip at the samples [-], shape (count,)."""
        return np.asarray(1.0 - self._radius * self.wheel_speed[: self.count] / self.speeds(momentum_speed))

    def newest_slip(self, momentum_speed: float) -> NewestSlip:
        """Slip at the newest sample."""
        last = self.count - 1
        omega = float(self.wheel_speed[last])
        speed = max(momentum_speed - self.speed_per_wheel_speed * omega - float(self.impulse[last]), _SLOWEST)
        per_u = self._radius * omega / speed**2
        slip = 1.0 - self._radius * omega / speed
        return NewestSlip(speed, slip, per_u, -per_u * self.speed_per_wheel_speed - self._radius / speed)

    def impulse_after(self, time: float, torque: float) -> float:
        """Return I [m/s] at a next sample, at `time` [s] under `torque` [N m]."""
        last = self.count - 1
        if last < 0:
            return 0.0
        mean = 0.5 * (self.torque[last] + torque)
        return float(self.impulse[last] + (time - self.time[last]) * mean * self._per_impulse)

    def append(
        self, time: float, measured_wheel_speed: float, speed: float | None, torque: float, wheel_speed: float
    ) -> None:
        """Add a sample with a first estimate of its wheel speed [rad/s]; the window must not be full."""
        k = self.count
        self.impulse[k] = self.impulse_after(time, torque)
        self.time[k] = time
        self.measured_wheel_speed[k] = measured_wheel_speed
        self.measured_speed[k] = 0.0 if speed is None else speed
        self.has_speed[k] = 0.0 if speed is None else 1.0
        self.torque[k] = torque
        self.wheel_speed[k] = wheel_speed
        self.wheel_speed_trust[k] = self.equation_trust[k] = 1.0
        self.count = k + 1

    def rehabilitate_newest_torques(self, torques: list[float]) -> None:
        """Put the measured torques [N m] of the newest samples in place and trust their wheel equations."""
        first = self.count - len(torques)
        self.torque[first : self.count] = torques
        self.equation_trust[first : self.count] = 1.0
        before = max(first - 1, 0)
        part = slice(before, self.count)
        mean = 0.5 * (self.torque[part][1:] + self.torque[part][:-1])
        gained = self._per_impulse * np.cumsum(np.diff(self.time[part]) * mean)
        self.impulse[before + 1 : self.count] = self.impulse[before] + gained

    def drop_oldest(self, number: int) -> None:
        """Forget the oldest `number` samples."""
        rest = self.count - number
        self._rows[:, :rest] = self._rows[:, number : self.count]  # numpy handles the overlap
        self.count = rest

    def clear(self) -> None:
        """Forget all samples."""
        self.count = 0
