"""The nodes of the friction graph and how each is started: one list for the launch files and for the demo."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from friction_bags.offline.estimators import ESTIMATORS
from friction_runtime.shipped_files import shipped_file, shipped_parameters

PLANT = "corner_sim"
SUPERVISOR = "abs_supervisor"
NODES = (PLANT, *ESTIMATORS)
"""In the order in which data flows. Package, module, node and parameter file of a node have one name."""
ESTIMATES = ("slip", "friction_slope", "friction_curve", "abs_supervisor", "contact_patch", "tyre_force")
"""What the estimators publish below each wheel."""
COMMAND = "brake_command"
"""What the supervisor publishes below each wheel unless it is in shadow mode."""
INPUTS = (
    *("wheel_states", "imu/data", "vehicle_velocity", "brake_demand"),
    *("*/brake_pressure", "*/tyre_signals", "truth/*"),
)
"""What is replayed from a bag; the estimates in it are made anew."""
VEHICLE = "vehicle"
"""Stands for the wheel where an estimate is of the whole vehicle."""
DEMO_VEHICLE = "chapter_corner"
"""The car of the demo unless another one is asked for."""
SURFACES = ("dry", "wet", "cobblestone", "snow")
QUIET_LOG = ("--ros-args", "--disable-external-lib-logs")
"""Arguments for processes whose output goes to a file already."""

ParameterValue = bool | int | float | str | Sequence[float] | Sequence[str]


def parameter_class(node: str) -> type:
    """Dataclass of the parameters of a node: that of the file its package ships."""
    return type(shipped_parameters(node))


def parameter_files(node: str, params_file: Path | None) -> list[Path]:
    """Name the parameter files of a node: what its package ships, then what decides over it."""
    return [shipped_file(node), *([params_file] if params_file else [])]


def executable(node: str) -> str:
    """Name of a node's program for ``ros2 run``."""
    return f"{node}_node"


def command(
    node: str, params_files: Sequence[Path], overrides: Mapping[str, ParameterValue], namespace: str = ""
) -> list[str]:
    """Command line that starts a node with this python, without ros2cli.

    Args:
        node: name of the node.
        params_files: parameter files, the later decides.
        overrides: parameters that decide over the files.
        namespace: of the node and its relative topics; empty for none.
    """
    arguments = [sys.executable, "-m", node, "--ros-args"]
    for path in params_files:
        arguments += ["--params-file", str(path)]
    for name, value in overrides.items():
        arguments += ["-p", f"{name}:={json.dumps(value)}"]
    if namespace:
        arguments += ["-r", f"__ns:=/{namespace.strip('/')}"]
    return arguments
