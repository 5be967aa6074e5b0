"""A signal that arrives late."""

from collections import deque
from math import floor


class LateSignal:
    """Values of every step, given back as they were a while ago; before the first it gives the first."""

    def __init__(self, delay: float, dt: float) -> None:
        """`delay` [s] >= 0 need be no multiple of the step dt [s]."""
        whole = floor(delay / dt + 1e-9)
        self._part = delay / dt - whole
        self._past: deque[float] = deque(maxlen=whole + 2)

    def put(self, value: float) -> None:
        """Take the value of the present step."""
        if not self._past:
            self._past.extend([value] * (self._past.maxlen or 0))
        self._past.append(value)

    def value(self) -> float:
        """Value `delay` before the last step that was put, linear between steps."""
        return self._past[1] + max(self._part, 0.0) * (self._past[0] - self._past[1])
