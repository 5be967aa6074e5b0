"""Offline processing: speed against reading and decoding, memory over the length of a bag, cost of the own codec."""

from __future__ import annotations

import argparse
import struct
import subprocess
import sys
import tempfile
import time
from collections import deque
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any

from mcap.writer import CompressionType, Writer
from rclpy.serialization import deserialize_message
from rich.progress import track
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from benchmarks.rows import Row, at_most, not_judged
from corner_sim.parameters import SimParameters
from corner_sim.ros.simulation import Simulation
from friction_bags.bag_io.bag_format import Topic
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.bag_writer import BagWriter
from friction_bags.bag_io.cdr import decode, encode, installed_topic
from friction_bags.offline.plan import ProcessOptions
from friction_bags.offline.run import process_bag
from friction_parameters.command_line import count
from friction_parameters.parameter import from_mapping
from friction_runtime.message_type import message_class
from vehicle_models.vehicle_file import load_vehicle


def library_seconds(bag: Path, inputs: Collection[str], out: Path) -> float:
    """CPU seconds in which the libraries decode the inputs in a bag, encode the others and write all of them.

    Args:
        bag: made by offline processing.
        inputs: names of the topics that were copied from the bag before.
        out: mcap file to be made.
    """
    store: Any = get_typestore(Stores.EMPTY)
    channels: dict[Topic, int] = {}
    seconds = 0.0
    with BagReader(bag) as reader, out.open("xb") as file:
        writer = Writer(file, chunk_size=4 << 20, compression=CompressionType.ZSTD)
        writer.start(profile="ros2")
        for topic in reader.counts:
            store.register(get_types_from_msg(topic.definition, topic.type))
            schema = writer.register_schema(topic.type, topic.definition_encoding, topic.definition.encode())
            channels[topic] = writer.register_channel(topic.name, "cdr", schema)
        for topic, stamp, data in reader.messages():
            begun = time.process_time()
            message = store.deserialize_cdr(data, topic.type)
            if topic.name not in inputs:
                begun = time.process_time()
                data = store.serialize_cdr(message, topic.type)
            writer.add_message(channels[topic], stamp, bytes(data), stamp)
            seconds += time.process_time() - begun
        begun = time.process_time()
        writer.finish()
    return seconds + time.process_time() - begun


_VEHICLE = "chapter_car"
_START = 10**12
_CYCLE_NS = 20 * 10**9
_SURFACES = ("dry", "wet", "snow")
_MINUTE_NS = len(_SURFACES) * _CYCLE_NS
_LARGEST_RATIO = 8.0
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
_PARAMETERS = "/**/friction_curve_id:\n  ros__parameters:\n    method: rls\n"


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
        (directory / "parameters.yaml").write_text(_PARAMETERS)
        minute = list(_minute())
        ours, libraries = _bag_times(minute, directory)
        for minutes in track(sorted(options.minutes), description="bags"):
            bag = directory / f"bag_{minutes}"
            _write(bag, minute, minutes)
            reading = _reading_time(bag)
            for processes in options.processes:
                out = directory / f"out_{minutes}_{processes}"
                row = _process(bag, out, processes, reading)
                row["bag_cpu_seconds"] = minutes * ours
                row["bag_cpu_seconds_with_libraries"] = minutes * libraries
                rows.append({"minutes": minutes, **row})
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


def _bag_times(minute: list[tuple[Topic, int, bytes]], directory: Path) -> tuple[float, float]:
    """CPU seconds to read, decode, encode and write a processed minute, and those of the libraries for the same."""
    bag, processed = directory / "minute", directory / "minute_processed"
    _write(bag, minute, 1)
    options = ProcessOptions(_ESTIMATORS, _VEHICLE, (directory / "parameters.yaml",))
    process_bag(bag, processed, options, 1, lambda _: None)
    inputs = {topic.name for topic, _, _ in minute}
    begun = time.process_time()
    with BagReader(bag) as reader:
        deque(reader.messages(), maxlen=0)
    reading = time.process_time() - begun
    kinds: dict[Topic, Any] = {topic: message_class(topic.type) for topic, _, _ in minute}
    begun = time.process_time()
    for topic, _, data in minute:
        decode(data, kinds[topic])
    decoding = time.process_time() - begun
    writing = _writing_time(processed, inputs, directory / "minute_again")
    return reading + decoding + writing, reading + library_seconds(processed, inputs, directory / "minute.mcap")


def _writing_time(processed: Path, inputs: Collection[str], out: Path) -> float:
    """CPU seconds in which a processed bag is encoded and written; the inputs are written only."""
    seconds = 0.0
    with BagReader(processed) as reader, BagWriter(out, chunk_size=4 << 20) as writer:
        for topic, stamp, data in reader.messages():
            message = None if topic.name in inputs else deserialize_message(data, message_class(topic.type))
            channel = writer.add_topic(topic)
            begun = time.process_time()
            writer.write(channel, stamp, data if message is None else encode(message))
            seconds += time.process_time() - begun
    return seconds


def _process(bag: Path, out: Path, processes: int, reading: float) -> Row:
    command = [sys.executable, "-m", "friction_bags", "process", str(bag), "--out", str(out), "--jobs", str(processes)]
    command += ["--vehicle", _VEHICLE, "--params-file", str(bag.parent / "parameters.yaml")]
    command += ["--estimators", *_ESTIMATORS]
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
