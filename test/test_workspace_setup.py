"""Set-up and build on a bare or half-finished machine: what is missing is named, what was killed is repaired."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
CHECK = ROOT / "tools/check_machine.sh"


def path_with(directory: Path, *programs: str) -> str:
    """Make a search path that holds nothing but the named programs of this machine."""
    directory.mkdir()
    for program in programs:
        found = shutil.which(program)
        assert found is not None
        (directory / program).symlink_to(found)
    return str(directory)


def check(path: str, python: str = "python3") -> subprocess.CompletedProcess[str]:
    """Run the check of the machine with the given search path."""
    command = ["/bin/sh", str(CHECK), python]
    return subprocess.run(command, capture_output=True, text=True, env={"PATH": path}, check=False)


def test_bare_machine_is_told_everything_that_is_missing_in_one_line(tmp_path: Path) -> None:
    result = check(path_with(tmp_path / "bin", "uname"))
    assert result.returncode == 1
    assert "sudo apt-get install -y make g++ python3 python3-venv python3-dev" in result.stderr


def test_python_without_headers_and_venv_is_told_so(tmp_path: Path) -> None:
    path = path_with(tmp_path / "bin", "uname", "make", "g++", "env")
    python = tmp_path / "bin/python3.12"
    python.write_text(f'#!/bin/sh\ncase "$2" in *Python.h*|*ensurepip*) exit 1;; esac\nexec {sys.executable} "$@"\n')
    python.chmod(0o755)
    result = check(path, str(python))
    assert result.returncode == 1
    assert result.stderr.rstrip().endswith("sudo apt-get install -y python3.12-venv python3.12-dev")


def test_python_too_old_is_refused_with_what_to_type(tmp_path: Path) -> None:
    path = path_with(tmp_path / "bin", "uname", "make", "g++")
    python = tmp_path / "bin/python3"
    python.write_text('#!/bin/sh\n[ "$1" = --version ] && echo Python 3.9.2\nexit 1\n')
    python.chmod(0o755)
    result = check(path)
    assert result.returncode == 1
    assert "Python 3.9.2" in result.stderr
    assert "make PYTHON=" in result.stderr


def test_other_processor_is_sent_to_apt_but_not_where_ros_is_sourced(tmp_path: Path) -> None:
    path = path_with(tmp_path / "bin", "make", "g++", "python3")
    uname = tmp_path / "bin/uname"
    uname.write_text('#!/bin/sh\n[ "$1" = -m ] && echo aarch64 || echo Linux\n')
    uname.chmod(0o755)
    result = check(path)
    assert result.returncode == 1
    assert "Linux on aarch64" in result.stderr
    command = ["/bin/sh", str(CHECK), "python3", "--ros-sourced"]
    assert subprocess.run(command, env={"PATH": path}, check=False).returncode == 0


@pytest.fixture
def workspace(tmp_path: Path) -> Path:
    """Make an empty workspace with these tools and a lock that needs no network."""
    shutil.copytree(ROOT / "tools", tmp_path / "tools", ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("requirements.txt", "requirements-tools.in"):
        (tmp_path / "tools" / name).write_text("# nothing\n")
    (tmp_path / "src").mkdir()
    return tmp_path


def make_venv(workspace: Path) -> str:
    """Make the environment of a workspace as on a machine where ROS is sourced."""
    command = [sys.executable, str(workspace / "tools/make_venv.py"), "--ros-sourced"]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def test_set_up_that_was_killed_is_started_again_and_a_finished_one_is_left_alone(workspace: Path) -> None:
    venv = workspace / ".venv"
    (venv / "lib").mkdir(parents=True)
    (venv / "lib/half-a-package").touch()
    assert "starting again" in make_venv(workspace)
    assert not (venv / "lib/half-a-package").exists()
    assert subprocess.run([venv / "bin/python", "-m", "pip", "--version"], check=False).returncode == 0

    log = (venv / "pip.log").stat().st_mtime_ns
    assert make_venv(workspace) == ""
    assert (venv / "pip.log").stat().st_mtime_ns == log

    (venv / "kept").touch()
    (workspace / "tools/requirements.txt").write_text("# a newer lock\n")
    make_venv(workspace)
    assert (venv / "kept").exists()
    assert (venv / "pip.log").stat().st_mtime_ns > log

    stamp = json.loads((venv / ".complete").read_text())
    (venv / ".complete").write_text(json.dumps({**stamp, "python": "another"}))
    make_venv(workspace)
    assert not (venv / "kept").exists()


def add_package(workspace: Path, name: str, setup: str) -> Path:
    """Write a Python package of one file into the workspace."""
    package = workspace / "src" / name
    (package / name).mkdir(parents=True)
    (package / name / "__init__.py").touch()
    (package / "package.xml").write_text(
        f'<package format="3"><name>{name}</name><version>0.1.0</version><description>test</description>'
        '<maintainer email="developers@friction.example.org">friction developers</maintainer>'
        "<license>Apache-2.0</license><export><build_type>ament_python</build_type></export></package>"
    )
    (package / "setup.py").write_text(setup)
    return package


def build(workspace: Path) -> subprocess.CompletedProcess[str]:
    """Build a workspace in the environment of the tests."""
    command = [sys.executable, str(workspace / "tools/build.py")]
    return subprocess.run(command, check=False, capture_output=True, text=True)


def test_build_that_was_killed_is_repaired_and_a_finished_one_is_left_alone(workspace: Path) -> None:
    setup = "from setuptools import setup\nsetup(name='tiny', version='0.1.0', packages=['tiny'])\n"
    package = add_package(workspace, "tiny", setup)
    (workspace / "build/tiny").mkdir(parents=True)
    (workspace / "build/tiny/CMakeCache.txt").write_text("half a line")
    (workspace / "build/.friction_stamp").write_text('{"state": "building"}')
    first = build(workspace)
    assert first.returncode == 0, first.stdout + first.stderr
    assert not (workspace / "build/tiny/CMakeCache.txt").exists()
    source = f"source {workspace}/install/setup.bash && python -c 'import tiny; print(tiny.__file__)'"
    imported = subprocess.run(["bash", "-c", source], check=True, capture_output=True, text=True)
    assert imported.stdout.strip().endswith("tiny/__init__.py")

    assert build(workspace).stdout == ""
    (package / "test").mkdir()
    (package / "test/test_tiny.py").touch()
    assert build(workspace).stdout == ""
    (package / "tiny/parameters.yaml").write_text("a: 1\n")
    assert "Finished <<< tiny" in build(workspace).stdout


def test_changed_package_alone_is_built_again_and_what_it_lost_is_gone_from_install(workspace: Path) -> None:
    setup = "from setuptools import setup\nsetup(name='{0}', version='0.1.0', packages=['{0}'])\n"
    package = add_package(workspace, "first", setup.format("first"))
    add_package(workspace, "second", setup.format("second"))
    (package / "first/old.py").write_text("value = 1\n")
    assert build(workspace).returncode == 0
    kept = next(workspace.glob("install/second/**/second/__init__.py")).stat().st_mtime_ns
    (package / "first/old.py").rename(package / "first/new.py")
    assert build(workspace).returncode == 0
    assert [path.name for path in sorted(workspace.glob("install/first/**/first/*.py"))] == ["__init__.py", "new.py"]
    assert next(workspace.glob("install/second/**/second/__init__.py")).stat().st_mtime_ns == kept


def test_package_that_fails_to_build_is_named_with_the_end_of_its_log_and_built_once_mended(workspace: Path) -> None:
    setup = "from setuptools import setup\nsetup(name='broken', version='0.1.0', packages=['broken'])\n"
    package = add_package(workspace, "broken", setup + "raise SystemExit('the reason it fails')\n")
    result = build(workspace)
    assert result.returncode != 0
    assert "broken" in result.stdout
    assert "the reason it fails" in result.stderr
    (package / "setup.py").write_text(setup)
    assert build(workspace).returncode == 0


def test_ros_of_another_distribution_is_refused_with_the_way_out(tmp_path: Path) -> None:
    (tmp_path / "share/rclpy").mkdir(parents=True)
    env = {**os.environ, "AMENT_PREFIX_PATH": str(tmp_path), "ROS_DISTRO": "humble"}
    result = subprocess.run([ROOT / "tools/run.bash", "true"], env=env, check=False, capture_output=True, text=True)
    assert result.returncode == 1
    assert "humble" in result.stderr
