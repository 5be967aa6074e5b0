"""Curves that wait until they count, in the order of their stamps."""

from collections import deque
from typing import Final, Generic, TypeVar

from vehicle_models.nanoseconds import NANOSECONDS

_OLDER: Final = round(0.05 * NANOSECONDS)
"""[ns] a curve counts for samples at least this much later: by then it has come, so that the answer to a sample does
not depend on which of the two came first."""
Curve = TypeVar("Curve")


class CurveQueue(Generic[Curve]):
    """Holds what was said by curves, in whichever order they come."""

    def __init__(self) -> None:
        """Start empty."""
        self._waiting: deque[tuple[int, Curve]] = deque()
        self._counted = 0

    def put(self, stamp: int, curve: Curve) -> int:
        """Take a curve of a stamp [ns]; return from which stamp on it counts.

        One replaces another of its stamp. One that is older than another that counts already is left out.
        """
        if stamp > self._counted:
            later = [each for each in self._waiting if each[0] > stamp]
            while self._waiting and self._waiting[-1][0] >= stamp:
                self._waiting.pop()
            self._waiting.append((stamp, curve))
            self._waiting.extend(later)
        return stamp + _OLDER

    def until(self, stamp: int) -> list[Curve]:
        """Return the curves that count from now on, at a sample with a stamp [ns], oldest first."""
        found: list[Curve] = []
        while self._waiting and self._waiting[0][0] <= stamp - _OLDER:
            self._counted, curve = self._waiting.popleft()
            found.append(curve)
        return found
