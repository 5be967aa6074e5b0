"""Command lines that are wrong: a one-line error and exit code 2, never a traceback."""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from itertools import chain
from pathlib import Path

import pytest

from benchmarks.__main__ import PARTS as STUDIES
from benchmarks.__main__ import main as benchmarks
from book.__main__ import main as book
from campaigns.__main__ import PARTS as CAMPAIGNS
from campaigns.__main__ import main as campaigns
from friction_bags.__main__ import main as bags
from friction_bags.bag_io.bag_format import Topic
from friction_bags.bag_io.bag_writer import BagWriter
from friction_bringup.__main__ import main as bringup
from friction_parameters.command_line import command
from friction_report.__main__ import main as report
from smart_tyre_forces.ros.calibration_tool import main as calibrate_smart_tyre
from vehicle_doctor.__main__ import main as doctor

DRY = str(Path(__file__).parents[1] / "bags/dry")
NUMBERS = ("", "-1", "nan", "inf", "1e300", "much", "0x10", "1,5")
COUNTS = (*NUMBERS, "0", "1.5", "99999999999999999999")


def files(directory: Path) -> dict[str, str]:
    """Files and bags that are not what a command expects."""
    made = {
        "not_there": directory / "not_there",
        "empty": directory / "empty.yaml",
        "not_utf8": directory / "not_utf8.yaml",
        "not_yaml": directory / "not_yaml.yaml",
        "list": directory / "list.yaml",
        "directory": directory / "directory",
        "no_bag": directory / "no_bag.mcap",
    }
    made["empty"].write_bytes(b"")
    made["not_utf8"].write_bytes(b"a: \xff\xfe\n")
    made["not_yaml"].write_text("a: [b\n\tc: }")
    made["list"].write_text("- 1\n- 2\n")
    made["directory"].mkdir()
    made["no_bag"].write_bytes(b"no bag at all")
    return {name: str(path) for name, path in made.items()}


def odd_bag(directory: Path, name: str, kind: str, data: bytes, topic: str = "/wheel_states") -> str:
    with BagWriter(directory / name) as writer:
        channel = writer.add_topic(Topic(topic, kind, "", ""))
        for stamp in range(1, 20):
            writer.write(channel, stamp, data)
    return str(directory / name)


def with_each(start: Sequence[str], option: str, values: Sequence[str]) -> Iterator[list[str]]:
    for value in values:
        yield [*start, option, value]


def bag_lines(directory: Path, given: dict[str, str]) -> Iterator[list[str]]:
    out = str(directory / "out")
    for name in ("info", "reindex", "play"):
        for bag in ("not_there", "empty", "not_utf8", "directory", "no_bag"):
            yield [name, given[bag]]
        yield [name]
    for bag in ("not_there", "empty", "directory", "no_bag"):
        yield ["process", given[bag], "--out", out]
        yield ["import", "bmw", given[bag], "--out", out]
        yield ["import", "iac", given[bag], "--out", out]
    for file in ("not_there", "empty", "not_utf8", "not_yaml", "list", "directory"):
        if file != "empty":
            yield ["process", DRY, "--out", out, "--params-file", given[file]]
        yield ["process", DRY, "--out", out, "--vehicle", given[file]]
        yield ["record", "--out", out, "--vehicle", given[file]]
    for bag in ("not_there", "empty", "not_utf8", "directory", "no_bag"):
        yield ["report", given[bag], "--out", out]
    for file in ("not_there", "empty", "not_utf8", "not_yaml", "list", "directory"):
        yield ["report", DRY, "--out", out, "--vehicle", given[file]]
        yield ["report", DRY, "--out", out, "--map", given[file]]
    yield ["report", DRY, "--out", out, "--params-file", given["list"]]
    yield ["report", DRY, "--out", out, "--namespace", "/nobody"]
    yield ["report", DRY, "--out", given["list"]]
    yield ["report", DRY, "--out", given["directory"]]
    yield ["report", DRY, "--out", given["no_bag"] + "/under_a_file"]
    yield ["report", DRY]
    yield ["report"]
    yield ["process", DRY]
    yield ["process", DRY, DRY, "--out", out]
    yield ["process", DRY, "--out", given["no_bag"] + "/under_a_file"]
    yield ["process", DRY, "--out", out, "--estimators", "none"]
    yield ["process", DRY, "--out", out, "--namespace", "/nobody"]
    yield ["import", "other", given["list"], "--out", out]
    yield ["library", "no_experiment", "--out", out]
    yield ["library", "dry", "--out", given["no_bag"]]
    yield ["record", "--out", given["directory"]]
    yield ["record", "--out", out, "--all", "--topics", "a"]
    yield ["record", "--out", out, "--compression", "rar"]
    yield ["nothing"]
    yield []
    yield from with_each(["process", DRY, "--out", out], "--jobs", COUNTS)
    yield from with_each(["record", "--out", out], "--duration", (*NUMBERS, "0"))
    for option in ("--rate", "--duration", "--clock"):
        yield from with_each(["play", DRY], option, (*NUMBERS, "0"))
    for option in ("--start-offset", "--wait", "--settle"):
        yield from with_each(["play", DRY], option, NUMBERS)
    for option in ("--ahead", "--subscribers"):
        yield from with_each(["play", DRY], option, COUNTS)
    yield from with_each(["play", DRY], "--subscribers", ("a=", "a=0", "=", "a=b=c"))


def other_lines(directory: Path, given: dict[str, str]) -> Iterator[tuple[Callable[[Sequence[str]], int], list[str]]]:
    for name in ("not_there", "empty", "directory", "no_bag"):
        yield bringup, ["demo", "--bag", given[name], "--out", str(directory / "out")]
    for name in ("not_there", "empty", "not_utf8", "not_yaml", "list", "directory"):
        yield bringup, ["demo", "--vehicle", given[name], "--out", str(directory / "out")]
    yield bringup, ["demo", "--surface", "ice", "--out", str(directory / "out")]
    yield bringup, ["demo", "--law", "none", "--out", str(directory / "out")]
    yield bringup, ["demo", "--out", given["no_bag"]]
    for name in ("not_there", "empty", "not_utf8", "not_yaml", "list", "directory"):
        yield bringup, ["policies", "--vehicle", given[name]]
    yield bringup, ["nothing"]
    yield bringup, []
    for part in STUDIES:
        yield benchmarks, [part, "--nothing"]
    for part in CAMPAIGNS:
        yield campaigns, [part, "--nothing"]
    yield book, ["--nothing"]
    for part in ("slope", "abs", "identification", "slip", "smart_tyre", "real_car"):
        for line in with_each([part], "--seeds", COUNTS):
            yield benchmarks, line
    for line in chain(with_each(["faults"], "--seeds", COUNTS), with_each(["fuzz"], "--messages", COUNTS)):
        yield campaigns, line
    for main, start, option in (
        (campaigns, ["live"], "--seconds"),
        (campaigns, ["faults"], "--demand"),
        (benchmarks, ["real_car"], "--hours"),
        (book, [], "--effort"),
    ):
        for line in with_each(start, option, (*NUMBERS, "0")):
            yield main, line
    yield campaigns, ["live", "--seconds", "1"]
    for main in (benchmarks, campaigns):
        yield main, ["nothing"]
        yield main, []
    for name in ("not_there", "empty", "directory", "no_bag"):
        bag = given[name]
        yield calibrate_smart_tyre, ["--quasi-static", bag, "--dynamic", bag, "--out", str(directory / "out")]
    for name in ("not_there", "not_utf8", "not_yaml", "list", "directory"):
        file = ["--params-file", given[name]]
        yield calibrate_smart_tyre, ["--quasi-static", DRY, "--dynamic", DRY, "--out", str(directory / "out"), *file]
    yield calibrate_smart_tyre, []


def test_a_wrong_command_line_is_one_line_and_exit_code_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    given = files(tmp_path)
    monkeypatch.chdir(tmp_path)
    count = 0
    failed = []
    for main, line in chain(((bags, line) for line in bag_lines(tmp_path, given)), other_lines(tmp_path, given)):
        for made in (tmp_path / "out", tmp_path / "bag"):
            shutil.rmtree(made, ignore_errors=True)
        count += 1
        code: object
        usage = False
        try:
            code = main(line)
        except SystemExit as ended:
            code, usage = ended.code, True
        except BaseException as error:
            failed.append((line, repr(error)))
            continue
        said = capsys.readouterr().err
        errors = [each for each in said.splitlines() if "error:" in each]
        if code != 2 or "Traceback" in said or len(errors) != 1 or not (usage or errors[0].startswith("error: ")):
            failed.append((line, f"{code}: {said}"))
    assert not failed, "\n".join(f"{line}: {text}" for line, text in failed)
    assert count >= 300


@pytest.mark.parametrize(
    "kind", ["a/b", "../../x/msg/Y", "os/msg/path", "no_package/msg/NoType", "sys", "", "a b/msg/C"]
)
def test_a_bag_of_an_odd_type_is_described_and_refused_by_what_needs_it(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bag = odd_bag(tmp_path, "odd", kind, b"\0\1\0\0")
    before = set(sys.modules)
    assert bags(["info", bag]) == 0
    for main, line in (
        (bags, ["process", bag, "--out", str(tmp_path / "out"), "--vehicle", "compact_car"]),
        (report, [bag, "--out", str(tmp_path / "page.html"), "--vehicle", "compact_car"]),
        (doctor, [bag, "--vehicle", "compact_car"]),
        (bringup, ["demo", "--bag", bag, "--out", str(tmp_path / "demo")]),
    ):
        assert main(line) in (1, 2), line
    assert "Traceback" not in capsys.readouterr().err
    assert not {name for name in set(sys.modules) - before if name.startswith(("os.msg", "antigravity"))}


def test_a_message_that_is_cut_off_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bag = odd_bag(tmp_path, "short", "sensor_msgs/msg/JointState", b"\0\1\0\0\1\2")
    out = str(tmp_path / "out")
    assert bags(["process", bag, "--out", out, "--vehicle", "compact_car"]) in (1, 2)
    assert report([bag, "--out", str(tmp_path / "page.html"), "--vehicle", "compact_car"]) in (1, 2)
    assert doctor([bag, "--vehicle", "compact_car"]) in (1, 2)
    assert "Traceback" not in capsys.readouterr().err


def test_where_security_is_demanded_and_absent_a_node_says_so_in_one_line(tmp_path: Path) -> None:
    demanded = {"ROS_SECURITY_ENABLE": "true", "ROS_SECURITY_STRATEGY": "Enforce", "ROS_SECURITY_KEYSTORE": "nowhere"}
    ended = subprocess.run(
        [sys.executable, "-m", "wheel_slip", "--ros-args", "-p", "vehicle_file:=compact_car"],
        cwd=tmp_path, env={**os.environ, **demanded}, capture_output=True, text=True, timeout=600, check=False,
    )  # fmt: skip
    assert ended.returncode == 2
    assert ended.stderr.startswith("error: ")
    assert "SECURITY" in ended.stderr
    assert len(ended.stderr.splitlines()) == 1


def test_an_interruption_is_one_word_and_exit_code_130(capsys: pytest.CaptureFixture[str]) -> None:
    def interrupted() -> int:
        raise KeyboardInterrupt

    assert command(interrupted) == 130
    assert capsys.readouterr().err == "interrupted\n"


@pytest.mark.parametrize(
    "line",
    [
        ["friction_bags", "play", DRY, "--ros-args", "-p", "a"],
        ["friction_bags", "play", DRY, "--ros-args", "--nothing"],
        ["friction_bags", "record", "--ros-args", "-r", "__ns:=1 2"],
        ["friction_bags", "play", DRY, "--start-offset", "100000"],
        ["friction_bags", "play", DRY, "--topics", "/nothing"],
        ["friction_bags", "play", DRY, "--ros-args", "-r", "/wheel_states:=/a b"],
        ["wheel_slip", "--ros-args", "--params-file", "not_there.yaml"],
        ["campaigns", "live", "--seconds", "-1"],
    ],
)
def test_a_process_with_a_wrong_command_line_ends_with_one_line(line: list[str], tmp_path: Path) -> None:
    paths = os.pathsep.join([str(Path(__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    ended = subprocess.run(
        [sys.executable, "-m", *line],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": paths},
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert ended.returncode == 2, ended.stderr
    assert "Traceback" not in ended.stderr
    assert len([each for each in ended.stderr.splitlines() if "error:" in each]) == 1
