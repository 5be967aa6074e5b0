"""`play`: the command that replays a bag."""

import sys
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import inf
from pathlib import Path
from time import monotonic

from rclpy.node import Node
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from friction_bags.bag_io.bag_format import BagError
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.record_replay.flow_control import FlowControl
from friction_bags.record_replay.player import Player, Span
from friction_bags.record_replay.topic_selection import TopicSelection, add_selection_arguments, selection_of
from friction_parameters.command_line import count, not_negative, positive
from friction_parameters.parameter import ParameterError
from friction_runtime.spin import made, start_middleware, stop_on_signals, take_down
from friction_runtime.stop_flag import StopFlag
from vehicle_models.nanoseconds import NANOSECONDS

_PROGRESS_PERIOD = 0.1


def add_arguments(parser: ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("bag", type=Path, help="directory of a bag, or an .mcap or .db3 file")
    add_selection_arguments(parser)
    parser.add_argument("--rate", type=positive, default=1.0, help="seconds of the bag per second (default 1)")
    parser.add_argument(
        "--as-fast-as-possible", action="store_true", help="do not pace by recording times; best with --follow"
    )
    parser.add_argument(
        "--follow",
        nargs="+",
        default=[],
        metavar="TOPIC",
        help="flow control: publish the next stamp when these have answered the last, such as '*/abs_supervisor'",
    )
    parser.add_argument(
        "--ahead", type=count, default=1, metavar="N", help="stamps --follow lets go unanswered (default 1)"
    )
    parser.add_argument("--loop", action="store_true", help="start again at the end")
    parser.add_argument("--start-offset", type=not_negative, default=0.0, metavar="S", help="start S s into the bag")
    parser.add_argument("--duration", type=positive, metavar="S", help="replay only S seconds of the bag")
    parser.add_argument("--remap", nargs="+", default=[], type=_remapping, metavar="OLD:=NEW", help="rename topics")
    parser.add_argument(
        "--clock", type=positive, nargs="?", const=100.0, metavar="HZ", help="publish /clock (default 100 Hz)"
    )
    parser.add_argument(
        "--wait",
        type=not_negative,
        default=3.0,
        metavar="S",
        help="wait at most S until each topic has its subscribers (default 3: discovery can take 2.5 s)",
    )
    parser.add_argument(
        "--subscribers",
        nargs="+",
        type=_subscribers,
        default=[],
        metavar="[TOPIC=]N",
        help="subscribers to wait for, of one topic or of each that is not named (default 1)",
    )
    parser.add_argument(
        "--settle",
        type=not_negative,
        default=0.0,
        metavar="S",
        help="wait also until no new subscriber has come for S seconds (default 0)",
    )


def run(args: Namespace, ros_args: list[str]) -> int:
    """Replay until the end of the bag or a signal.

    Returns:
        Exit code: 0, 1 when the bag is damaged or not all was delivered.

    Raises:
        BagError: nothing can be replayed.
        ParameterError: the middleware does not accept a name or an argument, or nobody publishes what to follow.
    """
    stop = stop_on_signals()
    reader = BagReader(args.bag)
    start_middleware(ros_args)
    node = made(lambda: Node("player", enable_rosout=False, start_parameter_services=False))
    try:
        with reader:
            return _play(args, node, reader, stop)
    finally:
        take_down(node)


def _play(args: Namespace, node: Node, reader: BagReader, stop: StopFlag) -> int:
    selection = selection_of(args, node.get_namespace())
    remapping = {_absolute(old): new for old, new in args.remap}
    topics = [topic for topic in reader.counts if selection.wants(topic.name)]
    player = made(lambda: Player(node, reader, topics, remapping))
    for name, reason in player.skipped.items():
        print(f"skipping {name}: {reason}", file=sys.stderr)
    if not player.topics:
        raise BagError(f"{args.bag}: no topic to replay")
    if args.clock:
        player.publish_clock(args.clock)
    start = reader.start + round(args.start_offset * NANOSECONDS)
    stop_at = reader.end + 1 if args.duration is None else start + round(args.duration * NANOSECONDS)
    span = Span(start, min(stop_at, reader.end + 1))
    if span.stop <= span.start:
        raise BagError(f"{args.bag}: nothing behind --start-offset {args.start_offset} s")
    wanted = dict(args.subscribers)
    others = wanted.pop("", 1)
    for name in player.wait_for_subscribers(wanted, others, args.wait, stop, args.settle):
        print(f"{name}: less than {wanted.get(name, others)} subscribers after {args.wait} s", file=sys.stderr)
    rate = inf if args.as_fast_as_possible else args.rate
    flow = _flow_control(args, node, stop) if args.follow else None
    if flow is not None and not flow.topics:
        raise ParameterError(f"no publisher of {' '.join(args.follow)}: start the nodes first")
    begun = monotonic()
    with _progress((span.stop - span.start) / NANOSECONDS) as progress:
        player.play(span, rate, stop, progress, flow)
        while args.loop and not stop.is_set():
            player.play(span, rate, stop, progress, flow)
    delivered = stop.is_set() or player.wait_for_delivery()
    for problem in reader.problems:
        print(f"damaged: {problem}", file=sys.stderr)
    if not delivered:
        print("some subscribers have not acknowledged everything", file=sys.stderr)
    late = "" if rate == inf else f", at most {player.latest * 1e3:.1f} ms late"
    print(
        f"{args.bag}: {player.published} messages on {len(player.topics)} topics replayed "
        f"in {monotonic() - begun:.1f} s{late}",
        flush=True,
    )
    return 0 if delivered and not reader.problems else 1


def _flow_control(args: Namespace, node: Node, stop: StopFlag) -> FlowControl:
    """Follow the topics that appear within the time for discovery, which ends once all named ones have appeared."""
    flow = FlowControl(node, args.ahead)
    selection = TopicSelection(args.follow, (), node.get_namespace())
    end = monotonic() + args.wait
    while not selection.is_complete(flow.topics) and monotonic() < end and not stop.is_set():
        flow.follow(selection)
        stop.wait(_PROGRESS_PERIOD)
    while not flow.is_connected() and not stop.is_set() and monotonic() < end + args.wait:
        stop.wait(_PROGRESS_PERIOD)
    return flow


@contextmanager
def _progress(total: float) -> Iterator[Callable[[float], None]]:
    """Yield a function that shows progress on a terminal, by the time into the bag [s]."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda _: None
        return
    columns = (BarColumn(), TextColumn("{task.completed:.1f} of {task.total:.1f} s"), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True, auto_refresh=False) as bar:
        task = bar.add_task("replay", total=total)
        shown = 0.0

        def show(offset: float) -> None:
            nonlocal shown
            if (now := monotonic()) - shown > _PROGRESS_PERIOD:
                shown = now
                bar.update(task, completed=offset, refresh=True)

        yield show


def _remapping(text: str) -> tuple[str, str]:
    old, separator, new = text.partition(":=")
    if not (old and separator and new):
        raise ArgumentTypeError(f"{text} is not of the form OLD:=NEW")
    return old, new


def _subscribers(text: str) -> tuple[str, int]:
    """Read `TOPIC=N`, or N with an empty name: the topics that are not named."""
    name, _, number = text.rpartition("=")
    return _absolute(name) if name else "", count(number)


def _absolute(name: str) -> str:
    return name if name.startswith("/") else f"/{name}"
