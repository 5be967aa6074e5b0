"""Brake torque between the command and the wheel: what the orders under way will do.

An order acts from its stamp plus the delay of the hydraulics on, until the next one does.
"""

from collections import deque
from typing import Final

from vehicle_models.brake_actuator import ActuatorParameters, Command
from vehicle_models.nanoseconds import NANOSECONDS

_KEPT: Final = round(0.1 * NANOSECONDS)
"""[ns] for which an order is remembered after it last acted."""


class _Order:
    __slots__ = ("begins", "command", "demand")

    def __init__(self, begins: int, command: Command, demand: float) -> None:
        self.begins = begins
        self.command = command
        self.demand = demand


class BrakeLine:
    """The orders to one brake."""

    def __init__(self, actuator: ActuatorParameters) -> None:
        """Choose the hydraulics."""
        self._rise, self._fall = actuator.apply_rate, actuator.release_rate
        self._delay = round(actuator.delay * NANOSECONDS)
        self.reset()

    def reset(self) -> None:
        """Forget all orders."""
        self._orders: deque[_Order] = deque()

    def order(self, stamp: int, command: Command, demand: float) -> None:
        """Note the command that was given at a stamp [ns], later than the last, with the driver's demand [N m]."""
        orders = self._orders
        if not (orders and orders[-1].command is command and orders[-1].demand == demand):
            orders.append(_Order(stamp + self._delay, command, demand))
        while len(orders) > 1 and orders[1].begins <= stamp - _KEPT:
            orders.popleft()

    def torque_at(self, torque: float, begin: int, end: int) -> float:
        """Return the torque [N m] at the stamp `end` [ns], which is `torque` at the stamp `begin` [ns].

        A brake that is late by some time is now where it should have been that time ago: both stamps are then earlier.
        """
        orders = self._orders
        count = len(orders)
        for index in range(count):
            order = orders[index]
            until = orders[index + 1].begins if index + 1 < count else end
            since = order.begins if order.begins > begin else begin
            if until > end:
                until = end
            if until > since:
                torque = self._moved(order, torque, (until - since) / NANOSECONDS)
        return torque

    def _moved(self, order: _Order, torque: float, seconds: float) -> float:
        if order.command is Command.HOLD:
            return torque
        target = 0.0 if order.command is Command.DECREASE else max(order.demand, 0.0)
        return min(max(target, torque - self._fall * seconds), torque + self._rise * seconds)
