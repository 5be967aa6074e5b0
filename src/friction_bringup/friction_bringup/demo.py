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

from friction_bringup import graph
from friction_bringup.domain import free_domain_id
from friction_bringup.live_view import LiveView
from friction_bringup.plots import write_plots
from friction_bringup.processes import ProcessGroup
from friction_bringup.recorded_run import read_run, wheels_of
from friction_bringup.summary import print_summary

_STARTUP_LIMIT = 30.0
"""Wall time [s] within which the first sample must come."""
_QUIET = 0.4
"""Wall time [s] without a new sample after which everything in flight has arrived."""
_LISTENERS = len(graph.WHEEL_STATES_READERS) + 2
"""Subscriptions to wheel_states: the nodes, the recorder and the live view."""
_PLAYER = "player"
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
        BagError: the bag to be replayed, or the one of this run, cannot be read.
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
            _start(processes, options, bag, env)
            _watch(console, processes, options, what, env)
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


def _start(processes: ProcessGroup, options: DemoOptions, bag: Path, env: dict[str, str]) -> None:
    """Start recorder, estimators and plant. The plant waits for its listeners by itself."""
    overrides = _overrides(options)
    processes.start(
        "recorder", [sys.executable, "-m", "friction_bags", "record", "--out", str(bag), *graph.QUIET_LOG], env
    )
    for node in (*graph.ESTIMATORS, *(() if options.bag else (graph.PLANT,))):
        command = graph.command(node, graph.parameter_files(node, options.params_file), overrides.get(node, {}))
        processes.start(node, [*command, *graph.QUIET_LOG], env)


def _start_player(processes: ProcessGroup, bag: Path, env: dict[str, str]) -> None:
    """Start the replay: at its first sample two listeners of each topic must be there, wheel_slip and the recorder."""
    play = ["friction_bags", "play", str(bag), "--wait", "10", "--subscribers", "2", "--topics", *graph.INPUTS]
    processes.start(_PLAYER, [sys.executable, "-m", *play, *graph.QUIET_LOG], env)


def _overrides(options: DemoOptions) -> dict[str, dict[str, graph.ParameterValue]]:
    """Return what this run decides over the parameter files, by node."""
    if options.bag is None:
        return {
            graph.PLANT: {"surfaces": [options.surface], "exit_when_done": True, "wait_for_subscribers": _LISTENERS}
        }
    wheels = wheels_of(options.bag)
    decided: dict[str, dict[str, graph.ParameterValue]] = {node: {"wheels": wheels} for node in graph.ESTIMATORS}
    decided["abs_supervisor"] = {"wheels": wheels, "shadow": True}
    return decided


def _watch(console: Console, processes: ProcessGroup, options: DemoOptions, what: str, env: dict[str, str]) -> None:
    """Show the graph until plant or player end and all that was sent has arrived."""
    source = _PLAYER if options.bag else graph.PLANT
    rclpy.init(args=list(graph.QUIET_LOG), signal_handler_options=SignalHandlerOptions.NO)
    view = LiveView()
    executor = EventsExecutor()
    executor.add_node(view)
    try:
        with console.status("starting the processes and waiting for them to find each other"):
            if options.bag:
                _spin_until(executor, lambda: view.count_subscribers("wheel_states") >= _LISTENERS, _STARTUP_LIMIT)
                _check(processes, source)
                _start_player(processes, options.bag, env)
            _spin_until(executor, lambda: view.samples > 0 or bool(processes.ended()), _STARTUP_LIMIT)
        _check(processes, source)
        if view.samples == 0:
            raise DemoError(f"no wheel_states within {_STARTUP_LIMIT:.0f} s; logs in {processes.log('').parent}")
        if console.is_terminal:
            with Live(view.table(what), console=console, refresh_per_second=_TABLE_RATE) as live:
                _follow(executor, processes, source, 1.0 / _TABLE_RATE, lambda: live.update(view.table(what)))
        else:
            print(view.header())
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


def _check(processes: ProcessGroup, source: str) -> None:
    for name, code in processes.ended().items():
        if name != source or code != 0:
            log = processes.log(name)
            tail = "\n".join(log.read_text(errors="replace").splitlines()[-15:])
            raise DemoError(f"{name} ended with exit code {code}; the end of {log}:\n{tail}")


def _report(console: Console, bag: Path, directory: Path, what: str) -> None:
    run = read_run(bag)
    print_summary(console, run)
    for path in write_plots(run, directory, what):
        console.print(f"plot  {path}", soft_wrap=True)
    console.print(f"bag   {bag}", soft_wrap=True)
