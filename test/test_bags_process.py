"""The live nodes on a replay against offline processing: the same messages, bit for bit."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from rclpy.serialization import deserialize_message

from friction_adapter.map_file import load_map
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.bag_writer import BagWriter, write_bag
from friction_bags.bag_io.cdr import encode
from friction_bags.experiments.library import Experiment, simulate
from friction_bags.importers.table import Table
from friction_bags.offline.estimators import WHEEL_ESTIMATORS
from friction_bags.offline.plan import ProcessOptions
from friction_bags.offline.run import process_bag
from friction_runtime.installed import message_class, shipped_file
from friction_test_support.dds_client import PATIENCE, own_domain

CAR = Path(__file__).parents[1] / "src" / "friction_bags" / "test" / "two_corners.yaml"
WHEELS = ["front_left", "rear_right"]
MADE = (
    *("slip", "friction_slope", "slope_vote", "friction_curve", "abs_supervisor", "brake_command"),
    *("friction_curve_debug", "abs_supervisor_debug"),
)
DATA = Path(os.environ.get("FRICTION_DATA", Path(__file__).parents[2] / "shared" / "data"))
BMW = DATA / "bmw_m8_abs_stop_100hz.csv"


class Processes:
    """Processes of this test, each with a log."""

    def __init__(self, directory: Path) -> None:
        self._directory = directory
        self._running: list[subprocess.Popen[bytes]] = []

    def log(self, name: str) -> str:
        return (self._directory / f"{name}.log").read_text()

    def start(self, name: str, *arguments: str) -> subprocess.Popen[bytes]:
        environment = {**os.environ, "ROS_DOMAIN_ID": str(own_domain()), "PYTHONUNBUFFERED": "1"}
        with (self._directory / f"{name}.log").open("w") as log:
            command = [sys.executable, "-m", *arguments]
            self._running.append(subprocess.Popen(command, stdout=log, stderr=log, env=environment))
        return self._running[-1]

    def stop(self) -> None:
        for process in self._running:
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
        for process in self._running:
            try:
                process.wait(PATIENCE)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self._running.clear()


@pytest.fixture
def processes(tmp_path: Path) -> Iterator[Processes]:
    started = Processes(tmp_path)
    yield started
    started.stop()


def sensors_of(bag: Path) -> list[str]:
    with BagReader(bag) as reader:
        return [topic.name for topic in reader.counts if "truth" not in topic.name]


@pytest.fixture
def parameters(tmp_path: Path) -> Path:
    """A parameter file with the car; the supervisor commands, and a stall of the machine does not trip its watchdog."""
    path = tmp_path / "parameters.yaml"
    path.write_text(
        f"/**:\n  ros__parameters:\n    vehicle_file: {CAR}\n"
        "/**/abs_supervisor:\n  ros__parameters:\n    shadow: false\n    real_time: false\n    stale_after: 5.0\n"
        # live nodes cannot know that a bag has no pressures, for which offline processing changes the method `auto`
        "/**/friction_curve_id:\n  ros__parameters:\n    method: car\n"
    )
    return path


def replay_to_live_nodes(processes: Processes, bag: Path, recording: Path, parameters: Path, how: list[str]) -> None:
    """Start nodes, recorder and player; return when the replay has ended and its answers are recorded."""
    for name in WHEEL_ESTIMATORS:
        files = ["--params-file", str(shipped_file(name)), "--params-file", str(parameters)]
        processes.start(name, name, "--ros-args", *files)
    recorder = processes.start("record", "friction_bags", "record", "--out", str(recording), "--topics", "*/*")
    end = time.monotonic() + PATIENCE
    expected = {f"recording /{wheel}/{name}" for wheel in WHEELS for name in MADE}
    while not all(line in processes.log("record") for line in expected):
        assert time.monotonic() < end, processes.log("record")
        time.sleep(0.1)
    answers = [f"{wheel}/{name}" for wheel in WHEELS for name in MADE[:4]]
    play = ["play", str(bag), "--topics", *sensors_of(bag), "--follow", *answers, "--wait", "60"]
    player = processes.start("play", "friction_bags", *play, *how)
    assert player.wait(PATIENCE) == 0, processes.log("play")
    recorder.send_signal(signal.SIGINT)
    assert recorder.wait(PATIENCE) == 0, processes.log("record")
    assert " 0 lost; closed" in processes.log("record")
    processes.stop()


def estimates(bag: Path) -> dict[str, list[bytes]]:
    """Estimates of a bag, encoded again: padding on the wire is not initialised."""
    found: dict[str, list[bytes]] = {f"/{wheel}/{name}": [] for wheel in WHEELS for name in MADE}
    with BagReader(bag) as reader:
        for topic, _, data in reader.messages([topic for topic in reader.counts if topic.name in found]):
            kind: Any = message_class(topic.type)
            found[topic.name].append(encode(deserialize_message(data, kind)))
        assert reader.problems == []
    return found


def assert_live_equals_offline(bag: Path, recording: Path, parameters: Path, directory: Path) -> None:
    options = ProcessOptions(parameter_files=(parameters,), outputs_only=True)
    process_bag(bag, directory / "offline", options, 1, lambda _: None)
    live, offline = estimates(recording), estimates(directory / "offline")
    for topic, expected in offline.items():
        assert expected, topic
        # messages of the watchdogs before the first sample and after the last do not belong to the bag
        first = live[topic].index(expected[0])
        assert live[topic][first : first + len(expected)] == expected, topic


@pytest.fixture
def braking(tmp_path: Path) -> Path:
    parameters = {
        "surfaces": ["dry", "wet"],
        "surface_distances": [0.0, 40.0],
        "demand_level": 0.9,
        "demand_rise": 0.3,
        "demand_hold": 0.6,
        "acceleration_variance": 0.01,
        "end_time": 2.0,
    }
    write_bag(tmp_path / "bag", simulate(Experiment("braking", parameters, vehicle=str(CAR)), seed=5), {})
    return tmp_path / "bag"


def test_live_nodes_give_what_offline_processing_gives(
    processes: Processes, braking: Path, parameters: Path, tmp_path: Path
) -> None:
    replay_to_live_nodes(processes, braking, tmp_path / "live", parameters, ["--rate", "1"])
    assert_live_equals_offline(braking, tmp_path / "live", parameters, tmp_path)


@pytest.mark.skipif(not BMW.is_file(), reason=f"{BMW} is absent (set FRICTION_DATA)")
def test_live_nodes_give_what_offline_processing_gives_on_the_measured_stop(
    processes: Processes, parameters: Path, tmp_path: Path
) -> None:
    """With gaps up to 70 ms and steps below 1 ms between stamps."""
    bag = tmp_path / "bmw"
    write_bag(bag, Table(BMW, load_map("bmw")).messages(), {})
    how = ["--as-fast-as-possible", "--start-offset", "14", "--duration", "6"]
    replay_to_live_nodes(processes, bag, tmp_path / "live", parameters, how)
    assert_live_equals_offline(part_of(bag, 14.0, 6.0, tmp_path / "part"), tmp_path / "live", parameters, tmp_path)


def part_of(bag: Path, offset: float, duration: float, part: Path) -> Path:
    """Bag of what a replay of a part of a bag publishes."""
    with BagReader(bag) as reader, BagWriter(part) as writer:
        start = reader.start + round(offset * 1e9)
        for topic, stamp, data in reader.messages(start=start, stop=start + round(duration * 1e9)):
            writer.write(writer.add_topic(topic), stamp, data)
    return part
