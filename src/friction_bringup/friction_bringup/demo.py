"""The demo: the whole graph as separate processes, a live view, and at the end summary, plots and bag."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import rclpy
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.signals import SignalHandlerOptions
from rich.console import Console
from rich.live import Live

from friction_bags.bag_format import BagError
from friction_bringup import graph
from friction_bringup.domain import free_domain_id
from friction_bringup.live_view import LiveView
from friction_bringup.plots import write_plots
from friction_bringup.processes import ProcessGroup
from friction_bringup.recorded_run import read_run
from friction_bringup.summary import print_summary

_STARTUP_LIMIT = 30.0
"""Wall time [s] within which the first sample must come."""
_QUIET = 0.4
"""Wall time [s] without a new sample after which everything in flight has arrived."""
_LINE_PERIOD = 0.25
_TABLE_RATE = 10.0


class DemoError(RuntimeError):
    """The demo cannot go on; the text says what failed and where its log is."""


@dataclass(frozen=True)
class DemoOptions:
    """What the command line asks for."""

    surface: str
    bag: Path | None
    """Bag to be replayed in place of the plant."""
    params_file: Path
    out: Path
    """Directory that gets a directory for each run."""


def run_demo(options: DemoOptions) -> int:
    """Run the demo.

    Returns:
        Exit code: 0, 130 after an interruption.

    Raises:
        DemoError: a process of the graph failed, or no sample came.
    """
    console = Console()
    what = options.bag.name if options.bag else options.surface
    directory = (options.out / f"{what}_{datetime.now():%Y%m%d_%H%M%S}").absolute()
    bag = directory / "bag"
    env = _environment(directory)
    os.environ.update(env)
    console.print(f"Friction graph on ROS_DOMAIN_ID={env['ROS_DOMAIN_ID']}, this machine only; everything of this run")
    console.print(f"goes to {directory}. Ctrl-C ends it.", soft_wrap=True)
    with ProcessGroup(directory / "log") as processes:
        previous = signal.signal(signal.SIGTERM, signal.default_int_handler)
        try:
            source = _start(processes, options, bag, env)
            _watch(console, processes, source, what)
        except KeyboardInterrupt:
            processes.stop()
            console.print(f"\nInterrupted. The bag is closed: {bag}", soft_wrap=True)
            return 130
        finally:
            signal.signal(signal.SIGTERM, previous)
        killed = processes.stop()
    if killed:
        raise DemoError(f"{', '.join(killed)} did not end in time and was killed; logs in {directory / 'log'}")
    _report(console, bag, directory, what)
    return 0


def _environment(directory: Path) -> dict[str, str]:
    return dict(
        os.environ,
        ROS_DOMAIN_ID=str(free_domain_id()),
        ROS_AUTOMATIC_DISCOVERY_RANGE="LOCALHOST",
        # Over loopback only: discovery in 50 ms instead of up to 2 s, and nothing is left in /dev/shm.
        FASTDDS_BUILTIN_TRANSPORTS="UDPv4",
        ROS_LOG_DIR=str(directory / "log"),
        RCUTILS_COLORIZED_OUTPUT="0",
        PYTHONUNBUFFERED="1",
        OMP_NUM_THREADS="1",
    )


def _start(processes: ProcessGroup, options: DemoOptions, bag: Path, env: dict[str, str]) -> str:
    """Start recorder, estimators and then the source of samples; return the name of the latter."""
    python = [sys.executable, "-m"]
    processes.start("recorder", [*python, "friction_bags", "record", "--out", str(bag), *graph.QUIET_LOG], env)
    replay = options.bag is not None
    for node in graph.ESTIMATORS:
        overrides: dict[str, graph.ParameterValue] = {"shadow": True} if replay and node == "abs_supervisor" else {}
        files = graph.parameter_files(node, options.params_file)
        processes.start(node, [*graph.command(node, files, overrides), *graph.QUIET_LOG], env)
    if options.bag is not None:
        processes.start("player", [*python, "friction_bags", "play", str(options.bag), *graph.QUIET_LOG], env)
        return "player"
    files = graph.parameter_files(graph.PLANT, options.params_file)
    overrides = {
        "surfaces": [options.surface],
        "exit_when_done": True,
        "wait_for_subscribers": 2,
    }
    processes.start(graph.PLANT, [*graph.command(graph.PLANT, files, overrides), *graph.QUIET_LOG], env)
    return graph.PLANT


def _watch(console: Console, processes: ProcessGroup, source: str, what: str) -> None:
    """Show the graph until its source ends and all that was sent has arrived."""
    rclpy.init(args=list(graph.QUIET_LOG), signal_handler_options=SignalHandlerOptions.NO)
    view = LiveView()
    executor = EventsExecutor()
    executor.add_node(view)
    try:
        with console.status("starting the processes and waiting for them to find each other"):
            _spin_until(executor, lambda: view.samples > 0 or _failed(processes, source), _STARTUP_LIMIT)
        _check(processes, source)
        if view.samples == 0:
            raise DemoError(f"no wheel_states within {_STARTUP_LIMIT:.0f} s; logs in {processes.log('').parent}")
        if console.is_terminal:
            with Live(view.table(what), console=console, refresh_per_second=_TABLE_RATE) as live:
                _follow(executor, processes, source, 1.0 / _TABLE_RATE, lambda: live.update(view.table(what)))
        else:
            _follow(executor, processes, source, _LINE_PERIOD, lambda: print(view.line(), flush=True))
        samples = -1
        while samples != view.samples:
            samples = view.samples
            _spin_until(executor, lambda: False, _QUIET)
    finally:
        view.destroy_node()
        rclpy.try_shutdown()


def _follow(
    executor: EventsExecutor, processes: ProcessGroup, source: str, period: float, show: Callable[[], None]
) -> None:
    while source not in processes.ended():
        _spin_until(executor, lambda: False, period)
        _check(processes, source)
        show()


def _spin_until(executor: EventsExecutor, done: Callable[[], bool], limit: float) -> None:
    deadline = time.monotonic() + limit
    while not done() and (remaining := deadline - time.monotonic()) > 0.0:
        executor.spin_once(timeout_sec=min(remaining, 0.05))


def _failed(processes: ProcessGroup, source: str) -> bool:
    return any(name != source or code != 0 for name, code in processes.ended().items())


def _check(processes: ProcessGroup, source: str) -> None:
    for name, code in processes.ended().items():
        if name != source or code != 0:
            log = processes.log(name)
            tail = "\n".join(log.read_text(errors="replace").splitlines()[-15:])
            raise DemoError(f"{name} ended with exit code {code}; the end of {log}:\n{tail}")


def _report(console: Console, bag: Path, directory: Path, what: str) -> None:
    try:
        run = read_run(bag)
    except (BagError, ValueError) as error:
        raise DemoError(str(error)) from error
    print_summary(console, run)
    for path in write_plots(run, directory, what):
        console.print(f"plot  {path}", soft_wrap=True)
    console.print(f"bag   {bag}", soft_wrap=True)
