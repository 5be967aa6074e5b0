"""The demo: the whole graph as separate processes, a live view, and at the end summary, page, picture and bag."""

from __future__ import annotations

import os
import signal
import sys
import time
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path
from tempfile import TemporaryDirectory

import rclpy
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.signals import SignalHandlerOptions
from rich.console import Console

from friction_adapter.map_file import add_map_argument, load_map
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_vehicle import vehicle_for
from friction_bags.offline.plan import SayOnce
from friction_bags.remapped_bag import RemappedBag, write_remapped
from friction_bags.results.braking_rows import braking_rows
from friction_bags.results.braking_table import add_table_arguments, show_brakings
from friction_bags.results.run_reader import read_run, require_samples
from friction_bringup import graph
from friction_bringup.demo_drive import CARS, ROAD_TEXT
from friction_bringup.demo_graph import DemoError, DemoGraph, DemoOptions
from friction_bringup.live_view import LiveView
from friction_bringup.monitor import show_live
from friction_bringup.processes import AT_ONCE
from friction_parameters.parameter import ParameterError
from friction_report.page import write_page
from friction_report.picture import write_picture
from friction_report.summary import print_summary
from friction_runtime.installed import shipped_file
from friction_runtime.processor import silent
from friction_runtime.spin import stop_on_signals, take_down
from vehicle_models.vehicle_file import add_vehicle_argument

_STARTUP_LIMIT = 120.0
"""Wall time [s] within which the processes must find each other, and again within which the first sample must come."""
_SETTLE = 1.0
"""Wall time [s] after this process has discovered all others until these have discovered each other too."""
_QUIET = 1.0
"""Wall time [s] without a new sample after which everything in flight has arrived."""
_PATIENCE = 20.0
"""Wall time [s] in which the processes must end when the run has ended by itself."""
_INTERRUPTED = 130
"""Exit code after an interruption."""
_FILE_WIDTH = 120

SpinUntil = Callable[[Callable[[], bool], float], None]
"""Spins until a condition holds, for at most a time [s]; raises KeyboardInterrupt after a signal."""


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the options of this command."""
    parser.add_argument("--surface", default="dry", metavar="ROAD", help=f"{ROAD_TEXT} (default: dry)")
    parser.add_argument("--car", choices=CARS, default="car", help="a whole car, or the corner of the chapter")
    parser.add_argument(
        "--law", choices=graph.LAWS, default=graph.LAWS[0], help="what commands the brake (default: curve)"
    )
    parser.add_argument("--bag", type=Path, help="replay this bag in place of the plant")
    add_map_argument(parser)
    add_vehicle_argument(parser, "that of --car, or the one the bag names")
    parser.add_argument(
        "--params", type=Path, help="parameter file (default: that of the demo, or the one the bag names)"
    )
    parser.add_argument("--out", type=Path, default=Path("out"), help="directory for the results (default: out)")
    add_table_arguments(parser)


def run(options: Namespace) -> int:
    """Run the demo of the command line; return the exit code: 1 where it failed."""
    try:
        with _mapped(options) as native:
            return run_demo(_demo_options(native), native)
    except DemoError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1


@contextmanager
def _mapped(options: Namespace) -> Iterator[Namespace]:
    """Yield options whose bag holds the topics of this graph: where a signal map is given, what it makes of the bag.

    Raises:
        ParameterError: the map is not valid, or there is no bag for it.
        BagError: the bag cannot be read, or lacks a topic of the map.
    """
    if not options.map:
        yield options
        return
    if not options.bag:
        raise ParameterError("--map is for a bag: give --bag")
    signal_map = load_map(options.map, options.vehicle)
    with TemporaryDirectory(prefix="friction_demo_") as directory:
        native = Path(directory, options.bag.resolve().stem)
        with RemappedBag(options.bag, signal_map, SayOnce()) as bag:
            write_remapped(bag, native, signal_map.notes)
        yield Namespace(**{**vars(options), "bag": native})


def _demo_options(options: Namespace) -> DemoOptions:
    """Complete the command line from the notes of the bag.

    Raises:
        ParameterError: neither the bag nor the command line names the car.
        BagError: the bag cannot be read, or holds no wheel_states.
    """
    vehicle, parameters = options.vehicle or CARS[options.car], "demo"
    if options.bag:
        with BagReader(options.bag) as reader:
            require_samples(reader)
            vehicle = vehicle_for(reader, options.vehicle, "", silent)
            parameters = reader.custom_data.get("parameters", parameters)
    params = options.params or shipped_file("friction_bringup", parameters)
    return DemoOptions(options.surface, options.law, options.bag, vehicle, params.absolute(), options.out)


def run_demo(options: DemoOptions, files: Namespace) -> int:
    """Run the demo.

    Args:
        options: what is run.
        files: options of add_table_arguments.

    Returns:
        Exit code: 0, 130 after an interruption.

    Raises:
        ParameterError: the parameter file or the vehicle file is bad; nothing was started.
        DemoError: a process of the graph failed, or no sample came.
        BagError: the bag to replay, or the one of this run, cannot be read.
    """
    console = Console()
    if not console.is_terminal:
        console = Console(width=_FILE_WIDTH)
    what = options.bag.name if options.bag else options.surface
    directory = (options.out / f"{what}_{datetime.now():%Y%m%d_%H%M%S}").absolute()
    demo = DemoGraph(options, directory)
    domain = demo.environment["ROS_DOMAIN_ID"]
    console.print(f"Friction graph on this machine alone, ROS_DOMAIN_ID={domain}. Ctrl-C ends it.")
    console.print(f"run   {directory}", soft_wrap=True)
    for note in demo.notes:
        console.print(note, soft_wrap=True, markup=False)
    os.environ.update(demo.environment)
    stop = stop_on_signals()
    rclpy.init(args=list(graph.QUIET_LOG), signal_handler_options=SignalHandlerOptions.NO)
    view = LiveView()
    executor = EventsExecutor()
    executor.add_node(view)

    def spin_until(done: Callable[[], bool], limit: float) -> None:
        deadline = time.monotonic() + limit
        while not done() and (remaining := deadline - time.monotonic()) > 0.0:
            executor.spin_once(timeout_sec=min(remaining, 0.05))
            if stop.is_set():
                raise KeyboardInterrupt

    try:
        interrupted = _run_graph(console, demo, view, what, spin_until) or stop.is_set()
        if interrupted:
            console.print(f"\nInterrupted. The bag is closed.\nbag   {demo.bag}", soft_wrap=True)
            return _INTERRUPTED
        for number in (signal.SIGINT, signal.SIGTERM):
            # Nothing is left to end; an exception in the middle of drawing would surface as any error.
            signal.signal(number, lambda *_: os._exit(_INTERRUPTED))
        _report(console, demo, directory, what, files)
        return 0
    finally:
        take_down(view, executor)  # last: it may end this process


def _run_graph(console: Console, demo: DemoGraph, view: LiveView, what: str, spin_until: SpinUntil) -> bool:
    """Start the processes, show their messages, end them; return whether a signal came."""
    interrupted, grace = False, AT_ONCE
    try:
        demo.start()
        _watch(console, demo, view, what, spin_until)
        grace = _PATIENCE
    except KeyboardInterrupt:
        interrupted = True
    finally:
        killed = demo.stop(grace)
    if killed and not interrupted:
        raise DemoError(f"{', '.join(killed)} did not end in time and was killed; logs in {demo.bag.parent / 'log'}")
    return interrupted


def _watch(console: Console, demo: DemoGraph, view: LiveView, what: str, spin_until: SpinUntil) -> None:
    """Show the graph until its source ends and all messages have arrived."""
    with console.status("starting the processes and waiting for them to find each other"):
        _bring_up(demo, view, spin_until)
    show_live(console, view, what, lambda period: spin_until(lambda: demo.done, period), lambda: demo.done)
    samples = -1
    while samples != view.samples:
        samples = view.samples
        spin_until(lambda: False, _QUIET)


def _bring_up(demo: DemoGraph, view: LiveView, spin_until: SpinUntil) -> None:
    """Wait until all processes are connected, begin, and wait for the first sample."""
    spin_until(lambda: demo.ended or not demo.missing(view), _STARTUP_LIMIT)
    if not demo.done and (missing := demo.missing(view)):
        raise DemoError(f"still not there: {', '.join(missing)}")
    spin_until(lambda: False, _SETTLE)
    demo.begin(view, lambda done: spin_until(lambda: demo.ended or done(), _STARTUP_LIMIT))
    spin_until(lambda: demo.ended or view.samples > 0, _STARTUP_LIMIT)
    if not demo.done and view.samples == 0:
        raise DemoError(f"no wheel_states in time from {demo.source}")


def _report(console: Console, demo: DemoGraph, directory: Path, what: str, files: Namespace) -> None:
    run = read_run(demo.bag, demo.wheels)
    print_summary(console, run)
    picture = directory / "drive.png"
    write_picture(run, picture, what)
    show_brakings(files, {directory.name: braking_rows(run)}, console)
    console.print(f"plot  {picture}", soft_wrap=True)
    page = directory / "page.html"
    write_page(run, page, directory.name)
    console.print(f"page  {page}", soft_wrap=True)
    console.print(f"bag   {demo.bag}", soft_wrap=True)
