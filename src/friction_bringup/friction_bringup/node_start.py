"""Start of the nodes of a graph, validated before anything runs, for the launch files and the demo."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from friction_adapter.map_file import map_reference
from friction_bringup import graph
from friction_parameters.parameter import ParameterError, from_mapping
from friction_parameters.parameter_file import NodeName, file_values, is_ros_own
from friction_runtime.installed import shipped_file
from vehicle_models.vehicle_file import load_vehicle, vehicle_reference

Decided = Mapping[str, Mapping[str, graph.ParameterValue]]
"""Parameters that override every file, by node."""
WATCHING: Decided = {graph.SUPERVISOR: {"shadow": True}}
"""The supervisor does not command a brake, whatever is in a file."""


def commanding(law: str) -> Decided:
    """Let the supervisor command the brake by a law: only in the demo, where the brake is simulated."""
    return {graph.SUPERVISOR: {"shadow": False, "law": law}}


def left_to_file(decided: Decided, node: str, name: str, params_file: str, namespace: str = "") -> Decided:
    """Leave a decided parameter to a parameter file that sets it.

    Args:
        decided: parameters that override every file, by node.
        node: the node.
        name: the parameter.
        params_file: parameter file; empty for none.
        namespace: namespace of the nodes.

    Raises:
        ParameterError: the file does not exist, or is bad for the node.
    """
    if not params_file or name not in decided.get(node, {}):
        return decided
    file = Path(params_file).absolute()
    if name not in file_values(graph.parameter_class(node), file, _full_name(node, namespace)):
        return decided
    return {**decided, node: {key: value for key, value in decided[node].items() if key != name}}


def with_adapter(nodes: Sequence[str], decided: Decided, map_file: str) -> tuple[Sequence[str], Decided]:
    """Put the adapter before some nodes where a signal map is given; return nodes and parameters.

    Raises:
        ParameterError: there is no such map.
    """
    if not map_file:
        return nodes, decided
    return (graph.ADAPTER, *nodes), {**decided, graph.ADAPTER: {"map_file": map_reference(map_file)}}


@dataclass(frozen=True)
class NodeStart:
    """How one node is started."""

    node: str
    files: tuple[Path, ...]
    """Parameter files; later ones override earlier ones."""
    decided: Mapping[str, graph.ParameterValue]
    """Parameters that override the files."""
    notes: tuple[str, ...]
    """Notes for the user: where a file is overridden."""


def node_starts(
    nodes: Sequence[str], decided: Decided, params_file: str = "", vehicle_file: str = "", namespace: str = ""
) -> list[NodeStart]:
    """Decide how nodes are started, and check their parameters.

    Args:
        nodes: names of the nodes.
        decided: parameters that override every file, by node.
        params_file: parameter file that overrides those of the packages; empty for none.
        vehicle_file: vehicle file for all of them: path, or name of a shipped one; empty: as in a parameter file.
        namespace: namespace of the nodes.

    Raises:
        ParameterError: a file does not exist, or is bad for one of the nodes; the text is one line.
    """
    path = Path(params_file).absolute() if params_file else None
    car: dict[str, graph.ParameterValue] = {}
    if vehicle_file:
        car["vehicle_file"] = vehicle_reference(vehicle_file)
    return [_checked(node, {**car, **decided.get(node, {})}, path, namespace) for node in nodes]


def composed_arguments(starts: Iterable[NodeStart]) -> list[str]:
    """Return the ROS arguments of the process that holds the nodes of graph.COMPOSED; other starts are ignored."""
    held = [start for start in starts if start.node in graph.COMPOSED]
    # the user's file, which all of them have, comes after all that the packages ship
    files = [*(start.files[0] for start in held), *(file for start in held for file in start.files[1:])]
    return graph.composed_arguments(files, {start.node: start.decided for start in held})


def _checked(
    node: str, decided: Mapping[str, graph.ParameterValue], params_file: Path | None, namespace: str
) -> NodeStart:
    files = graph.parameter_files(node, params_file)
    cls, name = graph.parameter_class(node), _full_name(node, namespace)
    found = [file_values(cls, file, name) for file in files]
    values = {key: value for each in (*found, decided) for key, value in each.items() if not is_ros_own(key)}
    try:
        parameters: Any = from_mapping(cls, values)
    except ParameterError as error:
        raise ParameterError(f"{node}: {error}") from error
    load_vehicle(parameters.vehicle_file)
    shipped = shipped_file("friction_bringup", "demo").parent
    users = found[1] if params_file and params_file.parent != shipped else {}  # what is shipped is no user's choice
    return NodeStart(node, tuple(files), decided, tuple(_notes(node, decided, users, params_file)))


def _full_name(node: str, namespace: str) -> NodeName:
    return NodeName(node, f"/{namespace.strip('/')}")


def _notes(
    node: str, decided: Mapping[str, graph.ParameterValue], users: Mapping[str, Any], params_file: Path | None
) -> Iterator[str]:
    """Yield notes where the supervisor only watches, and where the user's file is overridden."""
    if decided.get("shadow"):
        yield f"{node}: shadow mode, whatever is in a file: it publishes its state and never a {graph.COMMAND}"
    for key, value in decided.items():
        given = tuple(value) if isinstance(value, list) else value
        if key in users and users[key] != given:
            yield f"{node}: '{key}' is {value!r} here, not {users[key]!r} as in {params_file}"
