"""Command line: `python3 -m benchmarks PART [--seeds N] [--json FILE]`."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from benchmarks.runner import main_of

PARTS = {
    "slope": "delay, false alarms and slip at detection of the slope sign, both methods, all surfaces",
    "slope_position": "slope signs in ABS stops of whole cars, straight and in curves, on a plant of its own",
    "abs": "closed loop with the supervisor: adhesion utilisation, stopping distance, wheel lock",
    "identification": "Monte Carlo of lambda_max: the chapter's methods beside the Cramer-Rao bound",
    "real_car": "friction curves of cars that are not known exactly, on a plant of its own",
    "measured": "whole-vehicle fit on measured data: BMW stop, Putnam laps, tyre rig",
    "slip": "vehicle speed and slip without a speed sensor, simulated stops and the measured one",
    "smart_tyre": "Fz and Fx from the in-tyre accelerometer",
    "grip": "friction used, proven and left in ordinary driving on changing roads",
    "doctor": "vehicle doctor: injected faults reported, healthy drives without alarm, accuracy",
    "bags": "offline processing of bags: real-time factor, memory over length",
    "headlines": "the headline numbers of README.md, each by its command, within its stated noise",
    "results": "docs/results.md, one page from the JSON files of the last `make bench`",
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one part; return its exit code."""
    return main_of("benchmarks", PARTS, arguments)


if __name__ == "__main__":
    sys.exit(main())
