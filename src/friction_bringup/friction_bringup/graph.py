"""The nodes of the friction graph and how each is started, for the launch files and the demo."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from ament_index_python.packages import get_package_share_directory

from friction_bags.offline.estimators import ESTIMATORS, SMART_TYRE
from friction_runtime.installed import shipped_file, shipped_parameters

PLANT = "corner_sim"
SUPERVISOR = "abs_supervisor"
NODES = (PLANT, *ESTIMATORS)
"""In the order in which data flows. Package, module, node and parameter file of a node have one name."""
ADAPTER = "friction_adapter"
"""Stands before the estimators where a car has other topics: it takes part in no demo."""
COMPOSED = (
    *("wheel_slip", "friction_slope", "smart_tyre_forces", "friction_state", "friction_grip", "friction_curve_id"),
)
"""Estimators that may share a process, in the order in which they are served: the last one when nothing else waits."""
COMPOSED_PROCESS = "estimators"
"""Name of the process of these."""
WHEEL_STATES_READERS = (
    *("wheel_slip", "friction_slope", "friction_state", "friction_grip", "friction_curve_id", SUPERVISOR),
)
"""Nodes that take wheel_states."""
ESTIMATES = (
    *("slip", "friction_slope", "slope_vote", "friction_curve", "friction_curve_debug"),
    *("abs_supervisor", "abs_supervisor_debug", "contact_patch", "tyre_force", "grip"),
)
"""Topics of the estimators below each wheel."""
COMMAND = "brake_command"
"""Topic of the supervisor below each wheel, unless it is in shadow mode."""
INPUTS = (
    *("wheel_states", "imu/data", "vehicle_velocity", "brake_demand"),
    *("*/brake_pressure", "*/tyre_signals", "truth/*"),
)
"""Topics that are replayed from a bag; the estimates in it are made again."""
VEHICLE = "vehicle"
"""Used in place of a wheel for an estimate of the whole vehicle."""
LAWS = ("curve", "slope_sign")
"""Laws of the supervisor, that of the demo first."""
QUIET_LOG = ("--ros-args", "--disable-external-lib-logs")
"""Arguments for processes whose output already goes to a file."""

ParameterValue = bool | int | float | str | Sequence[float] | Sequence[str]


def plant_calibration() -> Path:
    """Return the path of the calibration of the smart tyres that the plant has."""
    return Path(get_package_share_directory(SMART_TYRE), "calibration", "plant_tyres.yaml")


def parameter_class(node: str) -> type:
    """Return the dataclass of the parameters of a node: that of the file its package ships."""
    return type(shipped_parameters(node))


def parameter_files(node: str, params_file: Path | None) -> list[Path]:
    """Return the parameter files of a node: the shipped one, then the one that overrides it."""
    return [shipped_file(node), *([params_file] if params_file else [])]


def wheel_states_subscriptions(composed: bool) -> int:
    """Return how many subscribe to wheel_states when all nodes are there: those that share a process do once.

    Args:
        composed: whether those of COMPOSED share a process.
    """
    shared = sum(node in COMPOSED for node in WHEEL_STATES_READERS) if composed else 1
    return len(WHEEL_STATES_READERS) - shared + 1


def executable(node: str) -> str:
    """Return the name of a node's program for ``ros2 run``."""
    return f"{node}_node"


def command(
    node: str, params_files: Sequence[Path], overrides: Mapping[str, ParameterValue], namespace: str = ""
) -> list[str]:
    """Return the command line that starts a node with this Python, without ros2cli.

    Args:
        node: name of the node.
        params_files: parameter files; later ones override earlier ones.
        overrides: parameters that override the files.
        namespace: namespace of the node and its relative topics; empty for none.
    """
    arguments = [sys.executable, "-m", node, "--ros-args", *_parameter_arguments(params_files, overrides)]
    if namespace:
        arguments += ["-r", f"__ns:=/{namespace.strip('/')}"]
    return arguments


def composed_arguments(
    params_files: Iterable[Path], overrides: Mapping[str, Mapping[str, ParameterValue]]
) -> list[str]:
    """Return the ROS arguments of the process that holds several nodes.

    Args:
        params_files: parameter files; later ones override earlier ones.
        overrides: parameters that override the files, by node.
    """
    addressed = {f"{node}:{name}": value for node, values in overrides.items() for name, value in values.items()}
    return _parameter_arguments(dict.fromkeys(params_files), addressed)


def _parameter_arguments(params_files: Iterable[Path], overrides: Mapping[str, ParameterValue]) -> list[str]:
    arguments: list[str] = []
    for path in params_files:
        arguments += ["--params-file", str(path)]
    for name, value in overrides.items():
        arguments += ["-p", f"{name}:={json.dumps(value)}"]
    return arguments
