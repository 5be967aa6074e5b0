"""How busy this machine is: a limit of wall time is for a machine that has nothing else to do."""

from __future__ import annotations

import os
from pathlib import Path

_PROCESSORS = len(os.sched_getaffinity(0))


def slowdown() -> float:
    """By how much longer everything takes now, at least 1: threads that want to run by processor.

    The larger of the mean of the last minute and what there is at this moment.
    """
    fields = Path("/proc/loadavg").read_text(encoding="ascii").split()
    now = int(fields[3].split("/")[0])
    return max(1.0, float(fields[0]) / _PROCESSORS, now / _PROCESSORS)
