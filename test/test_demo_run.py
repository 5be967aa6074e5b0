"""The demo from the outside: a short braking over DDS, its replay, and its end by signals."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import yaml
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.bag_writer import write_bag
from friction_bags.results.recorded_run import RecordedRun
from friction_bags.results.run_reader import read_run
from friction_bringup.__main__ import main
from friction_runtime.installed import shipped_file
from friction_runtime.messages import from_nanoseconds
from friction_test_support.dds_client import PATIENCE

SHORT = {"initial_speed": 20.0, "end_speed": 5.0, "real_time_factor": 0.0}
"""A braking of two seconds, as fast as the commands come."""
ENDLESS = {"end_speed": -1.0}
WHEELS = ("front_left",)


def parameters(directory: Path, values: Mapping[str, float | str], node: str = "corner_sim") -> Path:
    """Write the demo's parameter file with other values for a node."""
    shipped = yaml.safe_load(shipped_file("friction_bringup", "demo").read_text())
    shipped.setdefault(f"/**/{node}", {"ros__parameters": {}})["ros__parameters"].update(values)
    path = directory / "parameters.yaml"
    path.write_text(yaml.safe_dump(shipped))
    return path


def command(out: Path, *arguments: str) -> list[str]:
    return [sys.executable, "-m", "friction_bringup", "demo", "--out", str(out), *arguments]


def processes_of(out: Path) -> dict[int, str]:
    """Return the command lines of the processes that still run and whose logs go below a directory, by number."""
    found = {}
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if f"ROS_LOG_DIR={out}".encode() in (process / "environ").read_bytes():
                found[int(process.name)] = (process / "cmdline").read_bytes().replace(b"\0", b" ").decode()
        except OSError:
            continue
    return found


def until_under_way(process: subprocess.Popen[str]) -> None:
    """Wait until a demo shows the slip of a braked wheel."""
    assert process.stdout is not None
    for line in process.stdout:
        if re.search(r"slip +0\.\d", line):
            break


@dataclass
class Finished:
    """A demo that has ended."""

    output: str
    directory: Path
    """Directory of its one run."""

    @property
    def bag(self) -> Path:
        return self.directory / "bag"


def run(out: Path, *arguments: str) -> Finished:
    result = subprocess.run(command(out, *arguments), capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    return Finished(result.stdout, next(out.iterdir()))


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Finished:
    directory = tmp_path_factory.mktemp("demo")
    return run(directory / "out", "--car", "corner", "--surface", "wet", "--params", str(parameters(directory, SHORT)))


def test_demo_prints_the_summary_and_leaves_plot_page_and_bag_and_no_process(demo: Finished) -> None:
    for text in ("crossings of the peak", "ideal distance", "front_left/friction_slope", "Brakings of", "µ_max"):
        assert text in demo.output
    assert (demo.directory / "drive.png").read_bytes().startswith(b"\x89PNG")
    assert (demo.directory / "page.html").read_text().startswith("<!DOCTYPE html>")
    assert processes_of(demo.directory) == {}


def test_demo_shows_each_quantity_while_it_runs(demo: Finished) -> None:
    lines = [line for line in demo.output.splitlines() if re.match(r" +\d+\.\d\d ", line)]
    shown = r"slip +0\.\d{3} slope [+−?] λ +[–.\d]+ µ +[–.\d]+ +curve 0\.\d{3} +(increase|hold|decrease) +\d+\.\d bar"
    assert any(re.search(shown, line) for line in lines), demo.output


def test_bag_holds_the_answer_of_every_node_to_every_sample(demo: Finished) -> None:
    with BagReader(demo.bag) as reader:
        assert reader.problems == []
        assert reader.custom_data["vehicle"] == "chapter_corner"
    found = read_run(demo.bag, WHEELS)
    assert found.samples.size > 100
    for topic in ("slip", "friction_slope", "slope_vote", "abs_supervisor", "brake_command"):
        assert np.isin(found.samples, found.series[f"front_left/{topic}"].time).all(), topic


def test_supervisor_is_in_the_loop(demo: Finished) -> None:
    """The driver demands 1.5 times the peak torque: without release the wheel locks."""
    found = read_run(demo.bag, WHEELS)
    truth, command = found.series["truth/front_left/slip"], found.series["front_left/brake_command"]
    assert np.any(command["command"] == 3.0)
    locked = (truth["slip"] > 0.95) & (truth["vehicle_speed"] > 5.0)
    changes = np.flatnonzero(np.diff(locked.astype(int), prepend=0, append=0))
    assert max(np.diff(changes)[::2], default=0) * 0.005 < 0.05


def test_same_seed_gives_the_same_run_although_the_estimators_stall(demo: Finished, tmp_path: Path) -> None:
    out = tmp_path / "out"
    arguments = command(out, "--car", "corner", "--surface", "wet", "--params", str(parameters(tmp_path, SHORT)))
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True) as process:
        until_under_way(process)
        (estimators,) = (number for number, line in processes_of(out).items() if "friction_bringup graph" in line)
        os.kill(estimators, signal.SIGSTOP)
        time.sleep(1.0)  # far longer than the samples for which the supervisor knows the curve in advance
        os.kill(estimators, signal.SIGCONT)
        assert process.stdout is not None
        output = process.stdout.read()
    assert process.returncode == 0, output
    first, second = (read_run(each / "bag", WHEELS) for each in (demo.directory, next(out.iterdir())))
    for topic, column in (("truth/front_left/slip", "slip"), ("front_left/brake_command", "command")):
        assert np.array_equal(answers(first, topic, column), answers(second, topic, column), equal_nan=True), topic


def test_replay_of_the_bag_gives_the_same_estimates_and_no_command(demo: Finished, tmp_path: Path) -> None:
    replayed = run(tmp_path / "out", "--bag", str(demo.bag))  # its notes name the car
    assert "shadow mode" in replayed.output
    live, again = read_run(demo.bag, WHEELS), read_run(replayed.bag, WHEELS)
    for topic, column in (
        ("front_left/slip", "slip"),
        ("front_left/friction_slope", "indicator"),
        ("front_left/abs_supervisor", "state"),
    ):
        assert np.array_equal(answers(live, topic, column), answers(again, topic, column), equal_nan=True), topic
    assert "front_left/brake_command" not in again.series


def answers(run: RecordedRun, topic: str, column: str) -> np.ndarray:
    """Return the answers of a topic to each sample, without those of its watchdog after the last sample."""
    series = run.series[topic]
    first = np.searchsorted(series.time, run.samples)
    assert np.array_equal(series.time[first], run.samples)
    return series[column][first]


@pytest.fixture
def running(tmp_path: Path) -> Iterator[tuple[subprocess.Popen[str], Path]]:
    """Start a demo that does not end by itself; it is under way when the test begins."""
    out = tmp_path / "out"
    arguments = ["--car", "corner", "--params", str(parameters(tmp_path, ENDLESS))]
    with subprocess.Popen(command(out, *arguments), stdout=subprocess.PIPE, text=True) as process:
        until_under_way(process)
        yield process, next(out.iterdir())
        process.kill()


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_signal_ends_every_process_and_closes_the_bag(
    running: tuple[subprocess.Popen[str], Path], how: signal.Signals
) -> None:
    process, directory = running
    process.send_signal(how)
    assert process.wait(PATIENCE) == 130
    assert processes_of(directory) == {}
    with BagReader(directory / "bag") as reader:
        assert reader.problems == []
        assert reader.message_count > 100


def test_killed_demo_leaves_no_process_behind(running: tuple[subprocess.Popen[str], Path]) -> None:
    process, directory = running
    process.kill()
    deadline = time.monotonic() + PATIENCE
    while processes_of(directory):
        assert time.monotonic() < deadline, processes_of(directory)
        time.sleep(0.05)
    assert read_run(directory / "bag", WHEELS).samples.size > 0


@pytest.fixture
def refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """Return a function that returns the one line printed by a demo that does not start."""

    def run_in_vain(*arguments: str) -> str:
        assert main(["demo", "--out", str(tmp_path / "out"), *arguments]) != 0
        printed = capsys.readouterr()
        assert printed.out == ""
        assert len(printed.err.splitlines()) == 1, printed.err
        assert not (tmp_path / "out").exists()
        return printed.err

    return run_in_vain


def test_bad_file_is_named_and_nothing_starts(refused: Callable[..., str], tmp_path: Path) -> None:
    assert "'initial_speed' = -0.3 m/s" in refused("--params", str(parameters(tmp_path, {"initial_speed": -0.3})))
    assert "no_such.yaml" in refused("--params", str(tmp_path / "no_such.yaml"))
    assert "compact_car" in refused("--vehicle", "no_such_car")


def test_node_that_ends_too_soon_is_named_with_its_log_and_ends_the_demo(tmp_path: Path) -> None:
    bad = parameters(tmp_path, {"calibration_file": "/no/such/file"}, "smart_tyre_forces")
    arguments = ["--car", "corner", "--params", str(bad)]
    result = subprocess.run(command(tmp_path / "out", *arguments), capture_output=True, text=True, check=False)
    assert result.returncode == 1
    assert "estimators ended with exit code 2" in result.stderr
    assert "/no/such/file" in result.stderr
    assert processes_of(tmp_path / "out") == {}


def test_map_without_bag_or_that_is_none_is_refused(refused: Callable[..., str], tmp_path: Path) -> None:
    assert "--map is for a bag" in refused("--map", "gazebo", "--vehicle", "compact_car")
    assert "there is no signal map 'no_map'" in refused("--bag", str(tmp_path), "--map", "no_map")


def test_bag_without_wheels_is_refused_with_what_it_lacks(refused: Callable[..., str], tmp_path: Path) -> None:
    (tmp_path / "bag").mkdir()
    assert str(tmp_path / "bag") in refused("--bag", str(tmp_path / "bag"))


def test_bag_that_does_not_name_its_car_is_refused_with_the_cars_there_are(
    refused: Callable[..., str], tmp_path: Path
) -> None:
    message = JointState(header=Header(stamp=from_nanoseconds(1_000_000_000)), name=["FL"], velocity=[1.0])
    write_bag(tmp_path / "bag", [("/wheel_states", message)], {})
    said = refused("--bag", str(tmp_path / "bag"))
    assert "--vehicle" in said
    assert "compact_car" in said
