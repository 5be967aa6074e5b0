"""A loop that waits in short steps is stopped by a signal, wherever in its wait the signal comes."""

import subprocess
import sys
from threading import Timer
from time import monotonic

from friction_runtime.spin import StopFlag

_PATIENCE = 300.0

_STOPPED_OFTEN = """
import random, signal
from friction_runtime.spin import StopFlag

current = StopFlag()
signal.signal(signal.SIGALRM, lambda *_: current.set())
for _ in range(2000):
    current = StopFlag()
    signal.setitimer(signal.ITIMER_REAL, random.uniform(1e-4, 1e-3))
    while not current.is_set():
        current.wait(1e-5)
print("stopped")
"""


def test_signal_in_the_middle_of_a_wait_stops_the_loop() -> None:
    command = [sys.executable, "-c", _STOPPED_OFTEN]
    result = subprocess.run(command, capture_output=True, text=True, timeout=_PATIENCE, check=False)
    assert (result.returncode, result.stdout) == (0, "stopped\n"), result.stderr


def test_wait_ends_at_once_when_the_flag_is_set_and_returns_whether_it_is() -> None:
    stop = StopFlag()
    assert not stop.wait(0.0)
    timer = Timer(0.05, stop.set)
    timer.start()
    begun = monotonic()
    assert stop.wait(_PATIENCE)
    assert stop.wait(_PATIENCE)
    assert stop.is_set()
    assert monotonic() - begun < _PATIENCE
    timer.join()
