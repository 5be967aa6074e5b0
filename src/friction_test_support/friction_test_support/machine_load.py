"""Load of this machine, which scales limits of wall time chosen for an idle one."""

from __future__ import annotations

import os
from pathlib import Path

_PROCESSORS = len(os.sched_getaffinity(0))


def slowdown() -> float:
    """Return the factor by which everything takes longer now, >= 1: runnable threads per processor.

    The larger of the mean over the last minute and the present number.
    """
    fields = Path("/proc/loadavg").read_text(encoding="ascii").split()
    now = int(fields[3].split("/")[0])
    return max(1.0, float(fields[0]) / _PROCESSORS, now / _PROCESSORS)
