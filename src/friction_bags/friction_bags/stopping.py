"""Stopping a command on SIGINT or SIGTERM without losing what it holds."""

import signal
from threading import Event


def stop_on_signals() -> Event:
    """Event that is set by SIGINT or SIGTERM, instead of an exception in the middle of a call."""
    stop = Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    return stop
