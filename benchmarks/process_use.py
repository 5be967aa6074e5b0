"""Memory, threads and descriptors of a process, from /proc."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class ProcessUse:
    """What a process holds at one time."""

    rss: int
    """Resident memory [B]."""
    threads: int
    descriptors: int


def use_of(process: int) -> ProcessUse:
    """Return what the process with this id holds.

    Raises:
        OSError: there is no such process, or it is another user's.
    """
    directory = Path("/proc", str(process))
    lines = (directory / "status").read_text(encoding="ascii", errors="replace").splitlines()
    fields = dict(line.split(":", 1) for line in lines)
    rss = int(fields.get("VmRSS", "0 kB").split()[0]) * 1024  # one that ends has none any more
    return ProcessUse(rss, int(fields["Threads"]), len(list((directory / "fd").iterdir())))
