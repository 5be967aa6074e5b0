"""A flag that a signal handler may set while the same thread waits for it."""

from contextlib import suppress
from queue import Empty, SimpleQueue


class StopFlag:
    """Asks a loop to end.

    Not a threading.Event: its lock is not reentrant, so that a handler which runs while `wait` holds it waits forever.
    """

    def __init__(self) -> None:
        """Begin with the flag not set."""
        self._is_set = False
        self._wake: SimpleQueue[None] = SimpleQueue()

    def set(self) -> None:
        """Set the flag; may be called anywhere, also in a signal handler."""
        self._is_set = True
        self._wake.put(None)

    def is_set(self) -> bool:
        """Whether the flag is set."""
        return self._is_set

    def wait(self, timeout: float) -> bool:
        """Return at once when the flag is or becomes set, else after `timeout` [s], >= 0; return whether it is set.

        One thread may wait at a time.
        """
        if not self._is_set:
            with suppress(Empty):
                self._wake.get(timeout=timeout)
        return self._is_set
