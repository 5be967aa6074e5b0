"""Command line: `python3 -m campaigns PART [--json FILE]`."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from benchmarks.runner import main_of

PARTS = {
    "faults": "faults in closed loop: what each does to the stop, and whether the limits hold",
    "fuzz": "hostile messages into every processor: exceptions, impossible valid estimates, recovery",
    "live": "the graph over DDS: lost samples, delay, agreement with the offline processors",
    "soak": "the whole graph with tyres over DDS for minutes: memory, threads, descriptors, lost samples, delays",
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one part; return its exit code."""
    return main_of("campaigns", PARTS, arguments)


if __name__ == "__main__":
    sys.exit(main())
