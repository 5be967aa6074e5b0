"""Brake line and its hydraulic actuator: T_b = k p (1.1), behind a transport delay and rate limits.

Torques stand for pressures throughout (p = T_b / k), so that the limits are in N m/s whatever the gain of the line.
"""

from collections import deque
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from friction_parameters.parameter import parameter

Array = NDArray[np.float64]


class Command(IntEnum):
    """Command to the actuator; the values are those of friction_msgs/BrakeCommand."""

    NONE = 0
    INCREASE = 1
    HOLD = 2
    DECREASE = 3


@dataclass(frozen=True)
class ActuatorParameters:
    """Delay and rate limits of the hydraulics."""

    delay: float = parameter(
        0.01, "transport delay of demand and command", unit="s", minimum=0.0, maximum=1.0, read_only=True
    )
    apply_rate: float = parameter(
        5000.0, "fastest rise of brake torque", unit="N m/s", minimum=1.0, maximum=1e7, read_only=True
    )
    release_rate: float = parameter(
        5000.0, "fastest fall of brake torque", unit="N m/s", minimum=1.0, maximum=1e7, read_only=True
    )

    def __post_init__(self) -> None:
        """Refuse values without physical meaning."""
        if not (self.delay >= 0.0 and self.apply_rate > 0.0 and self.release_rate > 0.0):
            raise ValueError(f"delay must be >= 0 and the rates > 0: {self}")


class BrakeActuator:
    """Brake torque of n wheels (or n runs), driven by the driver's demand and the supervisor's command.

    NONE and INCREASE move towards the demand, HOLD keeps, DECREASE releases. A command takes hold of the torque only
    after the delay, at the resolution of `dt`.
    """

    def __init__(self, count: int, dt: float, parameters: ActuatorParameters = ActuatorParameters()) -> None:
        """Start released.

        Args:
            count: wheels or runs.
            dt: sample time [s], > 0.
            parameters: delay and limits.
        """
        if not dt > 0.0:
            raise ValueError(f"dt must be > 0, is {dt}")
        self._dt = dt
        self._parameters = parameters
        self._count = count
        self.reset()

    def reset(self) -> None:
        """Release, and forget what is still under way."""
        idle = (np.zeros(self._count), np.full(self._count, int(Command.NONE)))
        steps = round(self._parameters.delay / self._dt)
        self._line: deque[tuple[Array, NDArray[np.int64]]] = deque([idle] * steps)
        self.torque: Array = np.zeros(self._count)
        """Present brake torque [N m], shape (count,)."""

    def step(self, demand_torque: ArrayLike, command: ArrayLike = Command.NONE) -> Array:
        """Advance by dt and return the brake torque [N m] at its end, shape (count,).

        Args:
            demand_torque: the driver's demand [N m], broadcasts to (count,); negative counts as zero.
            command: a Command for each, broadcasts to (count,).
        """
        demand = np.broadcast_to(np.asarray(demand_torque, dtype=np.float64), (self._count,)).copy()
        orders = np.broadcast_to(np.asarray(command, dtype=np.int64), (self._count,)).copy()
        self._line.append((demand, orders))
        demand, orders = self._line.popleft()
        target = np.where(orders == Command.DECREASE, 0.0, np.maximum(demand, 0.0))
        target = np.where(orders == Command.HOLD, self.torque, target)
        change = np.clip(
            target - self.torque, -self._parameters.release_rate * self._dt, self._parameters.apply_rate * self._dt
        )
        self.torque = self.torque + change
        return self.torque
