"""Bags to tables: rows with places, broken and equal bags, two runs, killed workers and drivers."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path
from shutil import copytree, rmtree
from typing import Any

import pytest

pytest.importorskip("distributed")
pytest.importorskip("pyarrow")
pytest.importorskip("h3")

from friction_fleet.__main__ import main
from friction_fleet.cells import cell_of
from friction_fleet.dataset import RUN_COLUMNS, Dataset
from friction_fleet.settings import Settings
from friction_fleet.simulation.town import ORIGIN
from friction_fleet.study.kill_study import content, kill, kill_with_all_below, processes_below
from friction_fleet.task import OtherCodeError, Task, content_key, process

PATIENCE = 300.0
SECONDS = 4.0
"""Length of the drives, as in conftest.py."""


@pytest.fixture(scope="module")
def quiet(bags: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Tables that one process has made, task by task."""
    out = tmp_path_factory.mktemp("quiet")
    settings = Settings()
    for bag in sorted(bags.iterdir()):
        process(Task(f"file://{bag}", "", str(out), settings, settings.digest()))
    return out


def tables(out: Path) -> dict[str, Any]:
    """All rows of a dataset, without what is of the run."""
    return content(out, (*RUN_COLUMNS, "file_stamp"))


def test_a_drive_has_rows_with_places(quiet: Path) -> None:
    made = tables(quiet)
    bounds = [row for row in made["bounds"] if row["cell"] is not None]
    assert {row["vehicle"] for row in bounds} == {"car000", "car001", "car002"}
    town = {cell_of(ORIGIN[0] + north, ORIGIN[1] + east) for north in (0.0, 0.0036) for east in (0.0, 0.0054)}
    assert all(len(f"{row['cell']:x}") == len(f"{next(iter(town)):x}") for row in bounds)
    assert all(0.0 < row["mu_used"] < 1.3 and row["mu_used_stddev"] > 0.0 for row in bounds)
    assert all(row["from_speed"] > row["to_speed"] for row in made["brakings"])


def test_every_bag_is_a_row_whatever_is_wrong_with_it(quiet: Path) -> None:
    rows = {row["path"].rpartition("/")[2]: row for row in tables(quiet)["bags"]}
    assert len(rows) == 8
    status = {name: row["status"] for name, row in rows.items()}
    assert status["again"] == "ok" and status["car000_drive000"] == "duplicate"  # of two that are equal, the first
    assert status["cut"] == "damaged" and rows["cut"]["problems"]
    assert {status[name] for name in ("empty", "noise", "strange")} == {"error"}
    assert "no_such_car" in rows["strange"]["error"]
    assert rows["car001_drive000"]["duration"] == pytest.approx(SECONDS, abs=0.05)


def test_the_key_is_of_content_notes_and_settings_and_not_of_the_name(bags: Path, tmp_path: Path) -> None:
    key, size = content_key(bags / "car000_drive000", "settings")
    assert content_key(bags / "again", "settings") == (key, size)
    assert content_key(bags / "car000_drive000", "others")[0] != key
    assert content_key(bags / "strange", "settings")[0] != content_key(bags / "car001_drive000", "settings")[0]
    assert Settings(vehicle="chapter_car").digest() != Settings().digest()
    file = tmp_path / "parameters.yaml"
    file.write_text("/**: {ros__parameters: {deadline: 0.1}}\n")
    first = Settings(parameter_files=(file,)).digest()
    file.write_text("/**: {ros__parameters: {deadline: 0.2}}\n")
    assert Settings(parameter_files=(file,)).digest() != first


def test_a_worker_with_other_code_refuses(bags: Path, tmp_path: Path) -> None:
    with pytest.raises(OtherCodeError):
        process(Task(f"file://{bags / 'again'}", "", str(tmp_path), Settings(), "of the driver"))
    assert Dataset(str(tmp_path)).bags() == []


def test_two_workers_make_the_same_tables_and_a_second_run_does_nothing(
    bags: Path, quiet: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["process", f"{bags}/*", "--out", str(tmp_path), "--workers", "2"]
    assert main(command) == 1  # some bags are broken
    assert "dashboard" in capsys.readouterr().out
    assert tables(tmp_path) == tables(quiet)
    assert main(command) == 0
    assert "0 bags to process, 8 done before" in capsys.readouterr().out
    assert main(["status", str(tmp_path)]) == 1
    assert "8 bags: 1 damaged, 1 duplicate, 3 error, 3 ok" in " ".join(capsys.readouterr().out.split())


def test_a_changed_bag_is_processed_again(bags: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "bags").mkdir()
    copytree(bags / "noise", tmp_path / "bags/a")
    command = ["process", f"{tmp_path}/bags/*", "--out", str(tmp_path / "out"), "--workers", "1"]
    main(command)
    rmtree(tmp_path / "bags/a")
    copytree(bags / "empty", tmp_path / "bags/a")
    main(command)
    assert "1 bags to process" in capsys.readouterr().out.splitlines()[-3]


def test_a_bag_that_takes_three_workers_with_it_is_a_row(bags: Path, tmp_path: Path) -> None:
    command = ["process", f"{bags}/again", "--out", str(tmp_path), "--workers", "1", "--memory", "0.13"]
    assert main(command) == 1  # an estimator needs more memory than that
    (row,) = Dataset(str(tmp_path)).bags()
    assert row["status"] == "killed"
    assert main(command) == 0  # it is not tried again
    assert main([*command[:-1], "2", "--retry-errors"]) == 0
    (row,) = Dataset(str(tmp_path)).bags()
    assert row["status"] == "ok"


def test_a_log_of_another_car_goes_through_its_map(tmp_path: Path) -> None:
    (tmp_path / "map.yaml").write_text(
        """vehicle: compact_car
stamp: time
signals:
  wheel_speed: {from: {column: "{wheel}"}, unit: rad/s}
  acceleration: {from: {column: a}}
"""
    )
    wheels = ("front_left", "front_right", "rear_left", "rear_right")
    rows = [",".join(("time", *wheels, "a"))]
    for k in range(600):
        braked = max(min(0.01 * k - 2.0, 2.0), 0.0)
        speed = (20.0 - 3.0 * braked) / 0.3
        rows.append(",".join(f"{each:.4f}" for each in (0.01 * k, *[speed] * 4, -3.0 if 0.0 < braked < 2.0 else 0.0)))
    (tmp_path / "log.csv").write_text("\n".join(rows) + "\n")
    settings = Settings(map_file=str(tmp_path / "map.yaml"))
    row = process(Task(f"file://{tmp_path}/log.csv", "", str(tmp_path / "out"), settings, settings.digest()))
    assert (row["status"], row["vehicle"], row["brakings"]) == ("ok", "compact_car", 1), row["error"]
    (braking,) = (each for each in tables(tmp_path / "out")["brakings"] if each["of"] == "car")
    assert braking["mu_used"] == pytest.approx(3.0 / 9.81, abs=0.03)
    assert braking["cell"] is None


def test_killed_drivers_and_workers_lose_nothing(bags: Path, quiet: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "friction_fleet", "process", f"{bags}/*", "--out", str(tmp_path), "--workers", "2"]
    for victim in ("driver", "worker", ""):
        before, begun = len(Dataset(str(tmp_path)).bags()), time.monotonic()
        child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        while victim and len(Dataset(str(tmp_path)).bags()) == before and child.poll() is None:
            assert time.monotonic() - begun < PATIENCE
            time.sleep(0.1)
        if victim == "driver":
            kill_with_all_below(child)
        elif victim == "worker" and (below := list(processes_below(child.pid))):
            kill(max(below))
        child.wait(PATIENCE)
    assert tables(tmp_path) == tables(quiet)
