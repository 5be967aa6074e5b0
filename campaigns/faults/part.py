"""Campaign of faults in closed loop: ordinary braking must stay ordinary, and no fault may release a healthy brake.

Plant, fault, shipped processors (wheel_slip, friction_slope, friction_curve_id, abs_supervisor) and plant again,
without middleware, from 30 m/s to standstill. `value` is the distance over that without ABS, `failures` names every
limit that does not hold. The numbers are the worst over the seeds.
"""

import argparse
from os import times

from rich.progress import Progress

from abs_supervisor.parameters import CURVE, SLOPE_SIGN
from benchmarks.rows import Row
from campaigns.faults.plan import Plan, quick, whole
from campaigns.faults.rows import rows
from friction_parameters.command_line import count, positive

LAWS = (SLOPE_SIGN, CURVE)
"""What may ask for a release: the sign of the slope, section 8.2.2, or the slip control on the identified curve."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this part."""
    parser.add_argument("--seeds", type=count, default=1, help="seeds of sensor noise and fault for each row")
    parser.add_argument("--law", choices=LAWS, default=LAWS[0], help="what asks for the release")
    parser.add_argument(
        "--quick", action="store_true", help="the fixed subset of docs/faults.md: at most 8 CPU minutes"
    )
    parser.add_argument(
        "--live", type=int, metavar="TRIALS", help="instead: fail-safe times over DDS, trials per input"
    )
    for name in ("car", "surface", "fault"):
        parser.add_argument(f"--{name}", action="append", help="only these rows; repeatable")
    parser.add_argument("--processes", type=count, default=1, help="processes that share the stops")
    parser.add_argument("--demand", type=positive, action="append", help="only these rows; repeatable")


def run(options: argparse.Namespace) -> list[Row]:
    """Make all stops; return a row per car, surface, demand and fault."""
    if options.live is not None:
        return _live(options.live)
    found = rows(_chosen(options), options.seeds, options.law, options.processes)
    print(f"{len(found)} rows, {sum(times()[:4]):.0f} s of CPU")
    return found


def _live(trials: int) -> list[Row]:
    # here, because the campaign itself needs no middleware
    from campaigns.faults.live import LIVE_ROWS, fail_safe_rows

    with Progress() as progress:
        task = progress.add_task("fail-safe times", total=LIVE_ROWS * trials)
        return fail_safe_rows(trials, lambda: progress.advance(task))


def _chosen(options: argparse.Namespace) -> Plan:
    plan = []
    for manoeuvre, cases in quick() if options.quick else whole():
        chosen = [case for case in cases if not options.fault or case.name in options.fault]
        if (
            (not options.car or manoeuvre.car in options.car)
            and (not options.surface or manoeuvre.surface in options.surface)
            and (not options.demand or manoeuvre.demand in options.demand)
            and chosen
        ):
            plan.append((manoeuvre, chosen))
    return plan
