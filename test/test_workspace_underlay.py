"""The virtual environment as a colcon underlay: what sourcing gives, and that making it twice changes nothing."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

import make_venv

ROOT = Path(__file__).resolve().parents[1]

pytestmark = pytest.mark.skipif(
    not (ROOT / ".venv/local_setup.sh").exists(), reason="ROS 2 is sourced here: there is no underlay of wheels"
)


def clean_shell(script: str, shell: str = "bash") -> str:
    """Run a script in a shell that inherits nothing but a home and the system's search path."""
    command = ["env", "-i", f"HOME={os.environ['HOME']}", "PATH=/usr/bin:/bin", shell, "-c", script]
    return subprocess.run(command, check=True, capture_output=True, text=True, cwd="/").stdout


def test_sourcing_the_workspace_in_a_clean_shell_gives_ros_and_every_package() -> None:
    found = clean_shell(
        f"source {ROOT}/install/setup.bash && command -v python && echo $ROS_DISTRO && "
        "python -c 'import rclpy, friction_msgs.msg, vehicle_models; print(rclpy.__file__)'"
    ).split()
    assert found[0] == str(ROOT / ".venv/bin/python")
    assert found[1] == "jazzy"
    assert found[2].startswith(str(ROOT / ".venv"))


@pytest.mark.parametrize("shell", ["bash", "sh"])
def test_underlay_alone_runs_python_without_the_second_start(shell: str) -> None:
    script = f". {ROOT}/.venv/local_setup.sh; python -c 'import os, rclpy; print(os.getpid())' & echo $!; wait"
    started, running = clean_shell(script, shell).split()
    assert started == running
    assert str(ROOT / ".venv/lib") in clean_shell(f". {ROOT}/.venv/local_setup.sh; echo $LD_LIBRARY_PATH", shell)


def test_sourcing_twice_adds_nothing_and_keeps_what_was_there() -> None:
    source = f"source {ROOT}/.venv/setup.bash"
    variables = "PATH AMENT_PREFIX_PATH CMAKE_PREFIX_PATH PYTHONPATH LD_LIBRARY_PATH"
    show = f"for name in {variables}; do echo ${{!name}}; done"
    once = clean_shell(f"set -u; export PYTHONPATH='/a b:/c'; {source}; {show}")
    twice = clean_shell(f"set -u; export PYTHONPATH='/a b:/c'; {source}; {source}; {show}")
    assert once == twice
    assert once.splitlines()[3].endswith(":/a b:/c")


def test_include_directories_of_the_wheels_builder_are_repointed_once(tmp_path: Path) -> None:
    export = tmp_path / "share/std_msgs/cmake/export_std_msgs__rosidl_generator_pyExport.cmake"
    export.parent.mkdir(parents=True)
    built = "/opt/python/cp312-cp312"
    export.write_text(
        f'  INTERFACE_INCLUDE_DIRECTORIES "{built}/include/python3.12;'
        f'{built}/lib/python3.12/site-packages/numpy/_core/include"\n  INTERFACE_LINK_LIBRARIES "rmw"\n'
    )
    assert make_venv.repoint_include_directories(tmp_path, "/my/python", "/my/numpy") == 1
    assert export.read_text() == (
        '  INTERFACE_INCLUDE_DIRECTORIES "/my/python;/my/numpy"\n  INTERFACE_LINK_LIBRARIES "rmw"\n'
    )
    assert make_venv.repoint_include_directories(tmp_path, "/my/python", "/my/numpy") == 0


def test_no_exported_target_names_a_directory_of_another_machine() -> None:
    for export in ROOT.glob(".venv/share/*/cmake/*Export.cmake"):
        assert "/opt/python" not in export.read_text(), export


def test_setup_scripts_are_written_once_and_survive_a_blank_in_the_path(tmp_path: Path) -> None:
    prefix = tmp_path / "my workspace/.venv"
    (prefix / "bin").mkdir(parents=True)
    packages = prefix / "lib/python3.12/site-packages"
    (packages / "ros_rclpy.libs").mkdir(parents=True)
    assert make_venv.write_setup_scripts(prefix, packages) == 6
    assert make_venv.write_setup_scripts(prefix, packages) == 0
    shown = clean_shell(f"source '{prefix}/setup.bash'; echo $LD_LIBRARY_PATH; echo $AMENT_PREFIX_PATH")
    assert shown.splitlines() == [f"{prefix}/lib:{packages}/ros_rclpy.libs", str(prefix)]


@pytest.mark.skipif(shutil.which("zsh") is None, reason="zsh is not installed")
def test_zsh_can_source_the_underlay() -> None:
    assert clean_shell(f". {ROOT}/.venv/setup.zsh; command -v python", "zsh").strip().startswith(str(ROOT))
