import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from friction_msgs.msg import BrakeDemand, SupervisorState, WheelSlip
from rclpy.serialization import deserialize_message
from std_msgs.msg import String

from corner_sim.parameters import SimParameters
from corner_sim.ros.simulation import Simulation
from friction_bags.__main__ import main
from friction_bags.bag_io.bag_format import BagError, Topic
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.bag_writer import BagWriter
from friction_bags.bag_io.cdr import encode, installed_topic
from friction_bags.offline.estimated_run import estimated_run
from friction_bags.offline.plan import ProcessOptions, graph_stages
from friction_bags.offline.run import process_bag
from friction_bags.results.run_reader import read_run
from friction_parameters.parameter import ParameterError, from_mapping
from friction_runtime.installed import message_class
from friction_runtime.messages import from_nanoseconds
from friction_runtime.processor import ProcessorGraph
from vehicle_models.vehicle_file import load_vehicle

CAR = Path(__file__).parent / "two_corners.yaml"
WHEELS = ("front_left", "rear_right")
START = 10**12
Rows = list[tuple[str, int, Any]]


def braking(seconds: float = 1.2) -> Rows:
    """Topic, arrival [ns] and message of the sensors of two braked wheels."""
    given = {"demand_level": 0.9, "demand_rise": 0.2, "demand_start": 0.1, "seed": 3}
    return simulated({**given, "end_time": seconds, "acceleration_variance": 0.01}, str(CAR))


def simulated(given: dict[str, Any], vehicle: str) -> Rows:
    """Topic, arrival [ns] and message of the sensors of a drive."""
    simulation = Simulation(from_mapping(SimParameters, given), load_vehicle(vehicle), START)
    rows: Rows = []
    while simulation.end is None:
        rows += [(topic, simulation.stamp, message) for topic, message in simulation.messages() if "truth" not in topic]
        simulation.advance()
    return rows


def write(bag: Path, rows: Rows, prefix: str = "/", car: str = str(CAR)) -> None:
    with BagWriter(bag, custom_data={"vehicle": car} if car else {}) as writer:
        for name, stamp, message in rows:
            writer.write(writer.add_topic(installed_topic(prefix + name, type(message))), stamp, encode(message))


def read(bag: Path) -> dict[str, list[tuple[int, bytes]]]:
    found: dict[str, list[tuple[int, bytes]]] = {}
    with BagReader(bag) as reader:
        for topic in reader.counts:
            found[topic.name] = []
        for topic, stamp, data in reader.messages():
            found[topic.name].append((stamp, data))
        assert reader.problems == []
    return found


def process(bag: Path, out: Path, processes: int = 1, **options: Any) -> dict[str, list[tuple[int, bytes]]]:
    process_bag(bag, out, ProcessOptions(**options), processes, lambda _: None)
    return read(out)


@pytest.fixture(scope="module")
def rows() -> Rows:
    return braking()


@pytest.fixture(scope="module")
def bag(rows: Rows, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("process") / "bag"
    write(path, rows)
    return path


@pytest.fixture(scope="module")
def processed(bag: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("processed") / "out"
    process(bag, out)
    return out


def test_every_sample_of_the_bag_gets_the_estimates_of_every_wheel(bag: Path, processed: Path) -> None:
    before, after = read(bag), read(processed)
    samples = [stamp for stamp, _ in before["/wheel_states"]]
    for wheel in WHEELS:
        for name, kind in (
            ("slip", "WheelSlip"),
            ("friction_slope", "FrictionSlope"),
            ("friction_curve", "FrictionCurve"),
            ("friction_curve_debug", "FrictionCurveDebug"),
            ("abs_supervisor_debug", "SupervisorDebug"),
        ):
            found = after[f"/{wheel}/{name}"]
            assert [stamp for stamp, _ in found] == samples
            cls: Any = message_class(f"friction_msgs/msg/{kind}")
            messages = [deserialize_message(data, cls) for _, data in found]
            assert {message.wheel for message in messages} == {wheel}
            assert [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in messages] == samples
        slips = [deserialize_message(data, WheelSlip) for _, data in after[f"/{wheel}/slip"]]
        assert sum(message.validity.valid for message in slips) > len(samples) / 2
        assert len(after[f"/{wheel}/abs_supervisor"]) == len(samples)


def test_estimates_without_a_bag_are_those_of_the_bag(bag: Path, tmp_path: Path) -> None:
    result, run = estimated_run(bag, ProcessOptions())
    process(bag, tmp_path / "out", outputs_only=True)
    expected = read_run(tmp_path / "out")
    assert (run.wheels, run.start, run.notes) == (expected.wheels, expected.start, expected.notes)
    assert set(run.series) == set(expected.series)
    for topic, series in expected.series.items():
        found = run.series[topic]
        assert (found.reasons, set(found.columns)) == (series.reasons, set(series.columns))
        assert np.array_equal(found.time, series.time)
        assert all(np.array_equal(found[name], series[name], equal_nan=True) for name in series.columns)
    assert result.problems == ()
    assert result.outputs == sum(len(messages) for messages in read(tmp_path / "out").values())


def test_the_topics_of_the_bag_are_copied_as_they_are(bag: Path, processed: Path) -> None:
    after = read(processed)
    for name, messages in read(bag).items():
        assert after[name] == messages


@pytest.mark.parametrize("processes", [1, 2, 5])
def test_the_bytes_depend_neither_on_the_run_nor_on_the_number_of_processes(
    bag: Path, processed: Path, tmp_path: Path, processes: int
) -> None:
    process(bag, tmp_path / "out", processes)
    for file in ("out_0.mcap", "metadata.yaml"):
        assert (tmp_path / "out" / file).read_bytes() == (processed / file).read_bytes()


def test_a_system_that_allows_small_pipes_only_gets_the_same_bytes(
    bag: Path, processed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []

    def refuse(*arguments: int) -> int:
        asked.append(arguments)
        raise PermissionError

    monkeypatch.setattr("friction_bags.offline.run.fcntl", refuse)
    process(bag, tmp_path / "out", 2)
    assert asked
    assert (tmp_path / "out" / "out_0.mcap").read_bytes() == (processed / "out_0.mcap").read_bytes()


@pytest.mark.parametrize("seed", range(3))
def test_the_order_of_arrival_across_topics_does_not_matter(
    rows: Rows, processed: Path, tmp_path: Path, seed: int
) -> None:
    shuffled = shuffle(rows, random.Random(seed), 30_000_000)
    assert [name for name, _, _ in shuffled] != [name for name, _, _ in rows]
    write(tmp_path / "bag", shuffled)
    after, expected = process(tmp_path / "bag", tmp_path / "out"), read(processed)
    assert set(after) == set(expected)
    for name in expected:
        made = [data for _, data in after[name]]
        # what still waits for another topic at the end of the bag has no answer
        assert len(made) > len(expected[name]) - 8
        assert made == [data for _, data in expected[name]][: len(made)]


def shuffle(rows: Rows, generator: random.Random, most: int) -> Rows:
    """Delay every message by up to `most` [ns], keeping the order within each topic."""
    last: dict[str, int] = {}
    delayed = []
    for name, stamp, message in rows:
        last[name] = max(last.get(name, 0) + 1, stamp + generator.randrange(most))
        delayed.append((name, last[name], message))
    return sorted(delayed, key=lambda row: row[1])


def test_messages_of_unknown_types_pass_through(rows: Rows, tmp_path: Path) -> None:
    unknown = Topic("/strange", "strange_msgs/msg/Thing", "int32 a\n", "ros2msg")
    with BagWriter(tmp_path / "bag", custom_data={"vehicle": str(CAR)}) as writer:
        for name, stamp, message in rows:
            writer.write(writer.add_topic(installed_topic(f"/{name}", type(message))), stamp, encode(message))
            if name == "wheel_states":
                writer.write(writer.add_topic(unknown), stamp, b"\0\1\0\0" + stamp.to_bytes(8, "little"))
    after = process(tmp_path / "bag", tmp_path / "out", estimators=("wheel_slip",))
    assert [data[4:] for _, data in after["/strange"]] == [
        stamp.to_bytes(8, "little") for name, stamp, _ in rows if name == "wheel_states"
    ]
    with BagReader(tmp_path / "out") as reader:
        assert unknown.definition in {topic.definition for topic in reader.counts}


def test_estimates_that_the_bag_holds_are_made_again(rows: Rows, tmp_path: Path) -> None:
    old = WheelSlip(wheel="front_left", slip=0.99)
    write(tmp_path / "bag", [*rows, ("front_left/slip", START + 1, old)])
    after = process(tmp_path / "bag", tmp_path / "out", estimators=("wheel_slip",), outputs_only=True)
    assert set(after) == {"/vehicle_speed", *(f"/{wheel}/slip" for wheel in WHEELS)}
    assert encode(old) not in {data for _, data in after["/front_left/slip"]}


def test_a_namespace_is_kept(rows: Rows, tmp_path: Path) -> None:
    write(tmp_path / "bag", rows, "/car/")
    after = process(tmp_path / "bag", tmp_path / "out", namespace="/car", estimators=("wheel_slip",))
    assert len(after["/car/front_left/slip"]) == len(after["/car/wheel_states"])
    with pytest.raises(BagError, match="wheel_states"):
        process(tmp_path / "bag", tmp_path / "out2")


def test_a_topic_of_another_type_is_named_and_not_taken(
    rows: Rows, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    wrong = [("brake_demand", stamp, String(data="hard")) for name, stamp, _ in rows if name == "wheel_states"]
    write(tmp_path / "bag", sorted([row for row in rows if row[0] != "brake_demand"] + wrong, key=lambda row: row[1]))
    after = process(tmp_path / "bag", tmp_path / "out")
    assert "/brake_demand is std_msgs/msg/String" in capsys.readouterr().err
    assert len(after["/brake_demand"]) == len(wrong)


def test_a_supervisor_without_its_estimators_names_what_is_missing(
    bag: Path, processed: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    made = process(bag, tmp_path / "alone", estimators=("abs_supervisor",))
    (warning,) = capsys.readouterr().err.splitlines()
    assert warning.startswith("warning: neither in the bag nor estimated: ")
    assert {f"/{wheel}/{name}" for wheel in WHEELS for name in ("slope_vote", "slip")} == set(
        warning.rpartition(": ")[2].split(", ")
    )
    assert not made["/front_left/abs_supervisor"]
    beside = process(bag, tmp_path / "beside", estimators=("friction_slope", "abs_supervisor"))
    state = deserialize_message(beside["/front_left/abs_supervisor"][100][1], SupervisorState)
    assert state.validity.valid
    assert "release by deceleration alone (front_left/slip: " in state.unchecked
    capsys.readouterr()
    again = process(processed, tmp_path / "again", estimators=("abs_supervisor",))
    assert capsys.readouterr().err == ""
    assert again["/front_left/abs_supervisor"] == read(processed)["/front_left/abs_supervisor"]


def test_parameters_come_from_the_files_in_their_order_and_bad_ones_are_named(bag: Path, tmp_path: Path) -> None:
    (tmp_path / "a").write_text(
        "/**:\n  ros__parameters:\n    estimator: {minimum_speed: 1.0}\n    use_sim_time: false\n"
    )
    (tmp_path / "b").write_text("/**/wheel_slip:\n  ros__parameters:\n    estimator: {minimum_speed: 40.0}\n")
    for order, valid in (("ab", False), ("ba", True)):
        files = tuple(tmp_path / name for name in order)
        made = process(bag, tmp_path / order, estimators=("wheel_slip",), parameter_files=files)
        assert deserialize_message(made["/front_left/slip"][30][1], WheelSlip).validity.valid is valid
    (tmp_path / "bad").write_text("wheel_slip:\n  ros__parameters:\n    estimator: {minimum_speed: -1.0}\n")
    with pytest.raises(ParameterError, match=r"bad: line 3: .*estimator\.minimum_speed"):
        process(bag, tmp_path / "out2", parameter_files=(tmp_path / "bad",))


def test_several_bags_are_processed_at_once_and_a_bad_one_does_not_stop_the_others(
    bag: Path, processed: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(bag, tmp_path / "first")
    shutil.copytree(bag, tmp_path / "second")
    bags = [str(tmp_path / name) for name in ("first", "missing", "second")]
    assert main(["process", *bags, "--out", str(tmp_path / "out"), "--jobs", "2"]) == 2
    assert "missing does not exist" in capsys.readouterr().err
    for name in ("first", "second"):
        assert (tmp_path / "out" / name / f"{name}_0.mcap").read_bytes() == (processed / "out_0.mcap").read_bytes()


def test_messages_that_cannot_be_decoded_are_left_out_and_said(rows: Rows, processed: Path, tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag", custom_data={"vehicle": str(CAR)}) as writer:
        for name, stamp, message in rows:
            channel = writer.add_topic(installed_topic(f"/{name}", type(message)))
            if name == "imu/data" and stamp == START + 100_000_000:
                writer.write(channel, stamp, encode(message)[:50])
            writer.write(channel, stamp, encode(message))
    result = process_bag(tmp_path / "bag", tmp_path / "out", ProcessOptions(), 1, lambda _: None)
    assert result.problems == ("imu/data: 1 messages cannot be decoded",)
    assert read(tmp_path / "out")["/front_left/slip"] == read(processed)["/front_left/slip"]


@pytest.mark.parametrize(("number", "count"), [(signal.SIGINT, 2), (signal.SIGTERM, 1)])
def test_a_signal_ends_processing_at_once(rows: Rows, tmp_path: Path, number: int, count: int) -> None:
    bags = [tmp_path / f"bag{index}" for index in range(count)]
    shifted = [(name, stamp + shift * 10**12, message) for shift in range(10) for name, stamp, message in rows]
    for path in bags:
        write(path, shifted)
    out = tmp_path / "out"
    command = [sys.executable, "-m", "friction_bags", "process", *map(str, bags), "--out", str(out), "--jobs", "2"]
    process = subprocess.Popen(command, start_new_session=True)
    made = out if count == 1 else out / "bag0"
    end = time.monotonic() + 120.0
    file = made / f"{made.name}_0.mcap"
    while not (file.exists() and file.stat().st_size):
        assert time.monotonic() < end
        time.sleep(0.01)
    process.send_signal(number)
    assert process.wait(timeout=120.0) == 130
    if count == 1:
        assert read(made)


class Relay:
    """A processor that answers each message on one topic with one on others."""

    def __init__(self, taken: str, *given: str) -> None:
        self.sensors = {taken: BrakeDemand}
        self.estimates: dict[str, type] = {}
        self.outputs = dict.fromkeys(given, BrakeDemand)

    def process(self, topic: str, message: BrakeDemand) -> Sequence[tuple[str, Any]]:
        return [(name, BrakeDemand(header=message.header, wheel=name)) for name in self.outputs]


def test_a_message_is_passed_on_to_all_who_take_it_once() -> None:
    chain: Any = [Relay("c", "d"), Relay("a", "b", "c"), Relay("b", "e")]
    message = BrakeDemand()
    message.header.stamp = from_nanoseconds(5)
    given = ProcessorGraph(chain).feed("a", message)
    assert sorted(name for name, _ in given) == ["b", "c", "d", "e"]
    assert all(each.header.stamp.nanosec == 5 for _, each in given)
    assert ProcessorGraph(chain).feed("unknown", message) == []


def test_a_stage_takes_topics_of_the_stages_before_it_only() -> None:
    shared: Any = Relay("wheel_states", "left/slip", "right/slip")
    left: Any = Relay("left/slip", "left/slope")
    right: Any = Relay("right/slip", "right/slope")
    assert graph_stages([shared, left, right], 2) == [(shared, left), (right,)]
    assert graph_stages([shared, left, right], 9) == [(shared, left), (right,)]
    assert graph_stages([shared, left, right], 1) == [(shared, left, right)]
    state: Any = Relay("left/slope", "left/state")
    curve: Any = Relay("left/slip", "left/curve")
    assert graph_stages([shared, curve, left, right, state], 2) == [(shared, curve), (right, left, state)]
    assert graph_stages([left, state], 2) == [(left, state)]
    taken_back: Any = Relay("right/slope", "left/speed", "right/speed")
    assert graph_stages([shared, left, right, taken_back], 2) == [(shared, left, right, taken_back)]


def test_tyre_signals_are_processed_beside_an_accelerometer(tmp_path: Path) -> None:
    """With a calibration smart_tyre_forces takes both: what was read from a bag is told apart by its topic."""
    calibration = Path(__file__).parents[2] / "smart_tyre_forces" / "calibration" / "plant_tyres.yaml"
    parameters = tmp_path / "parameters.yaml"
    parameters.write_text(f"/**/smart_tyre_forces:\n  ros__parameters: {{calibration_file: {calibration}}}\n")
    plant = {"tyre_signals": True, "initial_speed": 20.0, "demand_level": 0.0, "end_time": 1.5}
    write(tmp_path / "bag", simulated(plant, "smart_tyre_car"), car="smart_tyre_car")
    after = process(
        tmp_path / "bag", tmp_path / "out", estimators=("smart_tyre_forces",), parameter_files=(parameters,)
    )
    for wheel in ("front_left", "rear_left"):
        assert len(after[f"/{wheel}/contact_patch"]) == len(after[f"/{wheel}/tyre_force"]) > 5
