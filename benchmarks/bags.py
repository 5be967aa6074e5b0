"""Offline processing: speed against reading and decoding, memory over the length of a bag."""

from __future__ import annotations

import argparse
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from rich.progress import track
from rosbags.highlevel import AnyReader

from benchmarks.runner import Row, at_most, not_judged
from corner_sim.parameters import SimParameters
from corner_sim.ros.simulation import Simulation
from friction_bags.bag_io.bag_format import Topic
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.bag_writer import BagWriter
from friction_bags.bag_io.cdr import encode, installed_topic
from friction_parameters.command_line import count
from friction_parameters.parameter import from_mapping
from vehicle_models.vehicle_file import load_vehicle

_VEHICLE = "chapter_car"
_START = 10**12
_CYCLE_NS = 20 * 10**9
_SURFACES = ("dry", "wet", "snow")
_MINUTE_NS = len(_SURFACES) * _CYCLE_NS
_LARGEST_RATIO = 12.0
"""Of the time of one process for a bag to that of rosbags to read and decode it (docs/friction_bags.md)."""
_STAMP = struct.Struct("<iI")
_STAMP_AT = 4
_ESTIMATORS = ("wheel_slip", "friction_slope", "abs_supervisor", "friction_curve_id")
_MEASURE = """
import resource, subprocess, sys
subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL)
usage = resource.getrusage(resource.RUSAGE_CHILDREN)
print(usage.ru_utime + usage.ru_stime, usage.ru_maxrss)
"""
"""Runs a command, in a process of its own, because the memory of a parent counts as that of what it starts."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add its own options."""
    parser.add_argument(
        "--minutes", type=count, nargs="+", default=[2], help="lengths of the bags (10 60 for the record)"
    )
    parser.add_argument("--processes", type=count, nargs="+", default=[1, 2], help="processes for one bag")


def run(options: argparse.Namespace) -> list[Row]:
    """Make a bag of each length, read it, process it; return one row a length and number of processes."""
    rows: list[Row] = []
    with tempfile.TemporaryDirectory(prefix="benchmarks_") as name:
        directory = Path(name)
        minute = list(_minute())
        for minutes in track(sorted(options.minutes), description="bags"):
            bag = directory / f"bag_{minutes}"
            _write(bag, minute, minutes)
            reading = _reading_time(bag)
            for processes in options.processes:
                out = directory / f"out_{minutes}_{processes}"
                rows.append({"minutes": minutes, **_process(bag, out, processes, reading)})
    return rows


def _minute() -> Iterator[tuple[Topic, int, bytes]]:
    """A minute of four wheels at 200 Hz: every 20 s a braking of 3 s, on dry, wet and snow."""
    vehicle = load_vehicle(_VEHICLE)
    for cycle, surface in enumerate(_SURFACES):
        start = _START + cycle * _CYCLE_NS
        given = {
            "surfaces": [surface],
            "demand_level": 0.8,
            "demand_start": 1.0,
            "demand_rise": 0.5,
            "demand_hold": 2.3,
            "demand_release": 0.2,
            "end_time": _CYCLE_NS * 1e-9,
            "acceleration_variance": 0.01,
            "seed": cycle,
        }
        simulation = Simulation(from_mapping(SimParameters, given), vehicle, start)
        while simulation.end is None:
            for topic, message in simulation.messages():
                if not topic.startswith("truth/"):
                    yield installed_topic(f"/{topic}", type(message)), simulation.stamp, encode(message)
            simulation.advance()


def _write(bag: Path, minute: list[tuple[Topic, int, bytes]], minutes: int) -> None:
    """Write the minute repeatedly, with stamps that continue."""
    with BagWriter(bag, chunk_size=4 << 20) as writer:
        for repeat in range(minutes):
            shift = repeat * _MINUTE_NS
            for topic, stamp, data in minute:
                seconds, rest = _STAMP.unpack_from(data, _STAMP_AT)
                moved = _STAMP.pack(seconds + shift // 10**9, rest)
                end = _STAMP_AT + _STAMP.size
                writer.write(writer.add_topic(topic), stamp + shift, data[:_STAMP_AT] + moved + data[end:])


def _reading_time(bag: Path) -> float:
    """Time in which rosbags reads and decodes every message [s]."""
    begun = time.perf_counter()
    with AnyReader([bag]) as reader:
        for connection, _, data in reader.messages():
            reader.deserialize(data, connection.msgtype)
    return time.perf_counter() - begun


def _process(bag: Path, out: Path, processes: int, reading: float) -> Row:
    command = [sys.executable, "-m", "friction_bags", "process", str(bag), "--out", str(out), "--jobs", str(processes)]
    command += ["--vehicle", _VEHICLE, "--estimators", *_ESTIMATORS]
    begun = time.perf_counter()
    measured = subprocess.run([sys.executable, "-c", _MEASURE, *command], check=True, capture_output=True, text=True)
    seconds = time.perf_counter() - begun
    cpu_seconds, memory = map(float, measured.stdout.split())
    with BagReader(bag) as reader:
        duration = (reader.end - reader.start) * 1e-9
    ratio = seconds / reading
    return {
        "processes": processes,
        "seconds": seconds,
        "cpu_seconds": cpu_seconds,
        "real_time_factor": duration / seconds,
        "reading_and_decoding_seconds": reading,
        "largest_memory_mb": memory / 1024.0,
        "quantity": "ratio to reading and decoding",
        **(at_most(ratio, _LARGEST_RATIO) if processes == 1 else not_judged(ratio)),
    }
