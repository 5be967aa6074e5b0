"""Messages of one topic by their stamps."""

from collections import deque
from typing import Final, Generic, TypeVar

from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.physical_bounds import NEW_RUN

Item = TypeVar("Item")
_KEPT: Final = 1000
"""Messages kept: 5 s at 200 Hz, far more than a sample waits for."""


class History(Generic[Item]):
    """The latest messages of a topic; a jump back in time forgets those before it."""

    def __init__(self) -> None:
        """Start empty."""
        self._items: deque[tuple[int, Item]] = deque(maxlen=_KEPT)

    def put(self, stamp: int, item: Item) -> None:
        """Add a message with its stamp [ns]; one that is late is left out."""
        if self._items and stamp <= self._items[-1][0]:
            if self._items[-1][0] - stamp < NEW_RUN:
                return
            self._items.clear()
        self._items.append((stamp, item))

    def at(self, stamp: int, timeout: float) -> Item | None:
        """Return the newest message at or before a stamp [ns], None where it is older than the timeout [s].

        Messages before it are forgotten: stamps only grow between jumps back.
        """
        while len(self._items) > 1 and self._items[1][0] <= stamp:
            self._items.popleft()
        if self._items and 0 <= stamp - self._items[0][0] <= timeout * NANOSECONDS:
            return self._items[0][1]
        return None
