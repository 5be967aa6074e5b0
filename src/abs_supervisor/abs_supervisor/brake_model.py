"""Brake model: the torque that the orders under way will give, how late the brake is, and whether its pressure follows.

An order acts from its stamp plus the delay of the hydraulics on, until the next one does. An additional delay is found
by comparison: each lateness is a way in which the torque should have changed from the last sample to this one. The true
one is wrong by noise alone, another by a whole step wherever rise, hold and fall follow each other; a wrong rate makes
all of them wrong, and the true one least. What is left is the plausibility of the pressure.
"""

from collections import deque
from math import isfinite, nan
from typing import Final, NamedTuple

from friction_runtime.filters import Debounce, SlidingWindow
from vehicle_models.brake_actuator import ActuatorParameters, Command
from vehicle_models.nanoseconds import NANOSECONDS

ORDER_MEMORY: Final = 0.1
"""[s] for which an order is remembered after it last acted; after a longer gap between samples all begins anew."""
# Additional delay
DELAY_STEP, DELAYS = 0.005, 7
"""[s] and number of its values, from 0 to 30 ms: more is no brake for slip control."""
LONGEST_STEP: Final = 0.02
"""[s] over a longer step nothing is learned."""
BAND: Final = 20.0
"""[N m] smallest difference of torques that a command answers."""
DELAY_MEMORY: Final = 100.0
"""Samples with a change of torque, after which what was seen counts e times less."""
TORQUE_NOISE: Final = 5.0
"""[N m] of a change from one sample to the next: no sensor is better."""
LOG_LIKELIHOOD: Final = 12.0
"""Logarithm of the likelihood ratio from which another delay is adopted."""
EXPLAINED: Final = 0.5
"""[-] of the squared changes of torque that the best delay leaves at most: else the brake does not follow at all."""
# Plausibility of the pressure
LATE: Final = 0.025
"""[s] by which a pressure may be later than the delay of the hydraulics, and for which a deviation must last."""
RATIO, OFFSET = 0.2, 12.0
"""[-] of the expected torque and [N m] by which it may be wrong."""
FORGETS: Final = 0.25
"""[s] in which the model follows a pressure that is right: a command that came late to the brake is not remembered."""
CLEAN: Final = 1.0
"""[s] without deviation after which the pressure counts as right again."""


class _Order(NamedTuple):
    begins: int
    command: Command
    demand: float


class BrakeModel:
    """One brake: `update` at every sample, then `order`."""

    def __init__(self, actuator: ActuatorParameters) -> None:
        """Choose the hydraulics."""
        self._rise, self._fall = actuator.apply_rate, actuator.release_rate
        self.delay = round(actuator.delay * NANOSECONDS)
        """[ns] of the hydraulics as stated."""
        self._window: SlidingWindow[float] = SlidingWindow(LATE * NANOSECONDS)
        self._wrong = Debounce(LATE * NANOSECONDS)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._orders: deque[_Order] = deque()
        self.late = 0
        """[ns] additional delay, 0 to 30 ms."""
        self._squares = [0.0] * DELAYS
        self._counted = self._changes = 0.0
        self._stamp, self._torque = 0, nan
        self._model = nan
        self._named: int | None = None
        self._window.clear()
        self._wrong.reset()
        self.text = ""
        """Deviation of the pressure in words, empty where there is none."""

    def order(self, stamp: int, command: Command, demand: float) -> None:
        """Note the command that was given at a stamp [ns], later than the last, with the driver's demand [N m]."""
        orders = self._orders
        if not (orders and orders[-1].command is command and orders[-1].demand == demand):
            orders.append(_Order(stamp + self.delay, command, demand))
        while len(orders) > 1 and orders[1].begins <= stamp - ORDER_MEMORY * NANOSECONDS:
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

    def update(self, stamp: int, torque: float, obeys: bool) -> None:
        """Take the measured torque.

        Args:
            stamp: [ns], later than the last.
            torque: [N m], NaN where unknown.
            obeys: whether demand and commands are all that moves the brake; else its pressure is not judged.
        """
        before, last = self._stamp, self._torque
        self._stamp, self._torque = stamp, torque
        if isfinite(torque - last) and stamp - before <= LONGEST_STEP * NANOSECONDS:
            self._learn_delay(before, last, stamp, torque)
        if obeys and isfinite(torque):
            self._judge(before, stamp, torque)
        else:
            self.text = ""

    def _learn_delay(self, before: int, last: float, stamp: int, torque: float) -> None:
        steps = [round(k * DELAY_STEP * NANOSECONDS) for k in range(DELAYS)]
        expected = [self.torque_at(last, before - step, stamp - step) for step in steps]
        if max(expected) - min(expected) < TORQUE_NOISE:
            return
        kept = 1.0 - 1.0 / DELAY_MEMORY
        self._counted = kept * self._counted + 1.0
        self._changes = kept * self._changes + (torque - last) * (torque - last)
        for k in range(DELAYS):
            wrong = torque - expected[k]
            self._squares[k] = kept * self._squares[k] + wrong * wrong
        least = min(self._squares)
        margin = 2.0 * LOG_LIKELIHOOD * max(least / self._counted, TORQUE_NOISE * TORQUE_NOISE)
        follows = self._changes > margin and least < EXPLAINED * self._changes
        if follows and self._squares[steps.index(self.late)] - least > margin:
            self.late = steps[self._squares.index(least)]

    def _judge(self, before: int, stamp: int, torque: float) -> None:
        """Compare the torque with the band of those that the model has had within LATE."""
        if not isfinite(self._model) or stamp - before > ORDER_MEMORY * NANOSECONDS:
            self._model = max(torque, 0.0)
            self._orders.clear()
            self._window.clear()
        else:
            self._model = self.torque_at(self._model, before, stamp)
        self._window.append(stamp, self._model)
        low, high = min(each for _, each in self._window), max(each for _, each in self._window)
        allowed = OFFSET + RATIO * max(high, 0.0)
        deviates = torque < low - allowed or torque > high + allowed
        if not deviates:
            self._model += (torque - self._model) * min((stamp - before) / NANOSECONDS / FORGETS, 1.0)
        if self._wrong.update(stamp, deviates):
            self._named = stamp
            self.text = f"{torque:.0f} N m, where demand and commands give {low:.0f} to {high:.0f} N m"
        elif self._named is not None and stamp - self._named > CLEAN * NANOSECONDS:
            self._named, self.text = None, ""
