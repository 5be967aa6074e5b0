"""Live graph over DDS: lost samples, delay, agreement with the offline processors; the adapter beside a bare relay."""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from friction_msgs.msg import BrakeCommand, SlopeVote, SupervisorState, WheelSlip
from rich.progress import Progress, track
from sensor_msgs.msg import JointState

from benchmarks.protocol import CAR, VEHICLE, WHEEL
from benchmarks.runner import Row, at_most, not_judged
from campaigns.live.composed import comparison_rows, growth_rows, latency_rows
from campaigns.live.graph import Observation, run_graph, run_offline
from campaigns.live.recorded_run import PLAYER, SOURCE, Drive, observe, record
from corner_sim.parameters import SimParameters
from corner_sim.plant import SAMPLE_TIME, SAMPLE_TIME_NS
from corner_sim.ros.simulation import Simulation
from friction_bags.bag_io.cdr import encode
from friction_bags.offline.estimators import closed_loop_parameters, make_processors
from friction_bringup import graph
from friction_bringup.discovery import local_discovery
from friction_bringup.processes import ProcessGroup
from friction_parameters.command_line import positive
from friction_parameters.parameter import ParameterError, from_mapping
from friction_runtime.domain import free_domain_id
from friction_runtime.processor import silent
from friction_test_support.machine_load import slowdown
from vehicle_models.surfaces import TABLE_8_1

_DRIVE = Drive("compact_car", ("/car",), "car", tyres=False)
_ROUNDS = 3
_MOST = 1.5
_ADAPTER, _RELAY = "friction_adapter", "bare relay"
_MAP = f"""vehicle: {_DRIVE.vehicle}
signals:
  wheel_speed:
    from: {{topic: /car/wheel_states, type: sensor_msgs/msg/JointState}}
    field: "velocity[name={{joint}}]"
    unit: rpm
  acceleration: {{from: {{topic: /car/imu/data, type: sensor_msgs/msg/Imu}}, field: linear_acceleration.x, unit: g}}
  brake_pressure:
    from: {{topic: "/car/{{wheel}}/brake_pressure", type: sensor_msgs/msg/FluidPressure}}
    field: fluid_pressure
    unit: bar
"""


def adapter_rows(seconds: float) -> list[Row]:
    """Play joint states, IMU and four pressures at 200 Hz for `seconds` [s] to both; a row a round, then the rule."""
    rows: list[Row] = []
    with tempfile.TemporaryDirectory(prefix="friction_recording_") as directory:
        bag, signal_map = Path(directory, "bag"), Path(directory, "map.yaml")
        signal_map.write_text(_MAP, encoding="utf-8")
        record(_DRIVE, seconds, bag)
        for number in track(range(_ROUNDS), "rounds"):
            rows.append({"run": f"round {number + 1}", **_round(bag, signal_map, Path(directory, f"log_{number}"))})
    ratios = [float(row[f"{_ADAPTER} [% of a core]"]) / float(row[f"{_RELAY} [% of a core]"]) for row in rows]
    lost = sum(int(row["lost"]) for row in rows)
    return [
        *rows,
        {"run": "all", "quantity": "processor time over that of the relay", **at_most(float(np.median(ratios)), _MOST)},
        {"run": "all", "quantity": "samples that one of the two lost", **not_judged(float(lost))},
    ]


def _round(bag: Path, signal_map: Path, logs: Path) -> Row:
    os.environ.update(local_discovery())
    env = os.environ | {"ROS_DOMAIN_ID": str(free_domain_id())}
    parameters = ("-p", f"vehicle_file:={_DRIVE.vehicle}", "-p", f"map_file:={signal_map}")
    adapter = ["friction_adapter", "--ros-args", "-r", "__ns:=/mapped", *parameters]
    relay = ["campaigns.live.bare_relay", _DRIVE.vehicle, "/car", "/relayed"]
    play = ["friction_bags", "play", str(bag), "--wait", "8", "--settle", str(2.0 * slowdown()), "--subscribers", "2"]
    processes = ProcessGroup(logs)
    try:
        for name, module in ((_ADAPTER, adapter), (_RELAY, relay)):
            processes.start(name, [sys.executable, "-m", *module], env)
        start = partial(processes.start, PLAYER, [sys.executable, "-m", *play], env)
        taps = {f"{place}/{SOURCE}": JointState for place in ("/car", "/mapped", "/relayed")}
        measured = observe(taps, env["ROS_DOMAIN_ID"], processes, start, lambda _: None)
    finally:
        processes.stop()
    sent, *made = (each.published.keys() for each in measured.answers.values())
    row: Row = {f"{name} [% of a core]": 100.0 * measured.processor[name] for name in (_ADAPTER, _RELAY)}
    return {**row, "samples": len(sent), "lost": sum(len(sent - each) for each in made)}


LOOP = ("wheel_slip", "friction_slope", "abs_supervisor")
"""The nodes between the sensors and the command."""
CHAIN: Mapping[str, type] = {
    SOURCE: JointState,
    f"{WHEEL}/slip": WheelSlip,
    f"{WHEEL}/slope_vote": SlopeVote,
    f"{WHEEL}/abs_supervisor": SupervisorState,
    f"{WHEEL}/brake_command": BrakeCommand,
}
_BRAKING = 5.0
"""The last seconds of the run in real time are a panic stop [s]."""
_PATIENCE = 60.0
"""In lock-step the fail-safe waits this long for a silent input [s, wall clock]: a stall of the machine
must not change a run that has to repeat."""
_START_STAMP = 1_000_000_000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this part."""
    parser.add_argument(
        "--composed", action="store_true", help="compare the estimators in one process with separate ones instead"
    )
    parser.add_argument("--adapter", action="store_true", help="compare friction_adapter with a bare relay instead")
    parser.add_argument(
        "--latency", action="store_true", help="delay from sensors to command of four wheels, beside relays, instead"
    )
    parser.add_argument("--seconds", type=positive, default=60.0, help="length of a run in real time [s], at least 6")
    parser.add_argument("--surface", choices=TABLE_8_1, default="dry", help="road of both runs")
    parser.add_argument("--live-seed", type=int, default=0, help="seed of the sensor noise")


def run(options: argparse.Namespace) -> list[Row]:
    """Make both runs, or the comparison; return a row per topic and run.

    Raises:
        ParameterError: --seconds is too short for a run that cruises and brakes.
    """
    if not options.seconds >= _BRAKING + 1.0:
        raise ParameterError(f"--seconds must be at least {_BRAKING + 1.0}, is {options.seconds}")
    if options.adapter:
        return adapter_rows(options.seconds)
    if options.composed:
        return comparison_rows(options.seconds) + growth_rows()
    if options.latency:
        return latency_rows(options.seconds)
    real_time = real_time_rows(options.seconds, options.surface, options.live_seed)
    return real_time + agreement_rows(options.surface, options.live_seed)


def real_time_rows(seconds: float, surface: str, seed: int) -> list[Row]:
    """Run `seconds` [s] in real time; return a row per topic with what was lost and the delays [ms]."""
    plant: dict[str, graph.ParameterValue] = {
        "surfaces": [surface],
        "seed": seed,
        "demand_start": seconds - _BRAKING,
        "end_speed": -1.0,
        "end_time": seconds,
        "lock_step": False,
    }
    found = _run(plant, seconds)
    expected = round(seconds / SAMPLE_TIME) + 1
    return [real_time_row(topic, found[topic], found[SOURCE], expected, surface) for topic in CHAIN]


def agreement_rows(surface: str, seed: int) -> list[Row]:
    """Run in lock-step to 5 m/s, live and offline; return a row per topic with the number of messages that differ."""
    plant: dict[str, graph.ParameterValue] = {
        "surfaces": [surface],
        "seed": seed,
        "start_stamp": _START_STAMP,
        "end_speed": 5.0,
        "lock_step": True,
        "lock_step_timeout": 20.0,
        "real_time_factor": 0.0,
    }
    found = _run(plant, 60.0)
    values = {name: tuple(value) if isinstance(value, list) else value for name, value in plant.items()}
    simulation = Simulation(from_mapping(SimParameters, values), CAR, _START_STAMP)
    offline = run_offline(simulation, make_processors(closed_loop_parameters(LOOP), CAR, silent))
    rows: list[Row] = []
    for topic in CHAIN:
        live = [encode(message) for message in _without_fail_safe(found[topic].messages)]
        alike = sum(a == b for a, b in zip(live, offline[topic], strict=False))
        rows.append(
            {
                "run": "lock_step",
                "surface": surface,
                "topic": topic,
                "samples": len(offline[topic]),
                "received": len(live),
                "quantity": "differing",
                **at_most(max(len(live), len(offline[topic])) - alike, 0),
            }
        )
    return rows


def _without_fail_safe(messages: Sequence[Any]) -> Sequence[Any]:
    """Leave out what the fail-safe repeats with the last stamp when the plant has ended."""
    kept = len(messages)
    while kept > 1 and messages[kept - 1].header.stamp == messages[kept - 2].header.stamp:
        kept -= 1
    return messages[:kept]


def _run(plant: Mapping[str, graph.ParameterValue], seconds: float) -> dict[str, Observation]:
    overrides: dict[str, dict[str, graph.ParameterValue]] = {
        node: {"vehicle_file": VEHICLE} for node in (graph.PLANT, *LOOP)
    }
    overrides[graph.PLANT] |= plant
    overrides[graph.SUPERVISOR] |= {
        "shadow": False,
        "real_time": not plant["lock_step"],
        "stale_after": _PATIENCE,  # counts in lock-step only
    }
    with Progress() as progress:
        what, total = ("lock-step", None) if plant["lock_step"] else ("real time", seconds / SAMPLE_TIME)
        task = progress.add_task(f"live, {what}, {plant['surfaces']}", total=total)
        return run_graph(
            LOOP, CHAIN, overrides, 2.0 * seconds + 60.0, lambda count: progress.update(task, completed=count)
        )


def real_time_row(topic: str, found: Observation, source: Observation, expected: int, surface: str) -> Row:
    """Row of one topic: what was lost, steps between stamps other than 5 ms, delays [ms] behind the source.

    The first answer to a sample counts: a command is repeated as a heartbeat.
    """
    first: dict[int, int] = {}
    for stamp, at in zip(found.stamps, found.published, strict=True):
        first.setdefault(stamp, at)
    sent = dict(zip(source.stamps, source.published, strict=True))
    answered = [(sent[stamp], at) for stamp, at in first.items() if stamp in sent]
    delay = np.array([at - begin for begin, at in answered]) * 1e-6
    steps = np.diff(list(first))
    return {
        "run": "real_time",
        "surface": surface,
        "topic": topic,
        "samples": expected,
        "received": len(first),
        "quantity": "lost",
        **at_most(expected - len(first), 0),
        "irregular_steps": int(np.count_nonzero(steps != SAMPLE_TIME_NS)),
        "delay_median_ms": float(np.median(delay)),
        "delay_p99_ms": float(np.percentile(delay, 99.0)),
        "delay_max_ms": float(delay.max()),
        "duration_s": (source.published[-1] - source.published[0]) * 1e-9,
    }
