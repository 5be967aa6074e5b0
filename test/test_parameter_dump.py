"""Parameters of running nodes: each starts again from its `ros2 param dump`; shadow mode stays on."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from rclpy.parameter import Parameter, parameter_value_to_python

from friction_bringup import graph
from friction_test_support.dds_client import DdsClient, dds_client, stop

NAMESPACE = "/my_car"
CAR: dict[str, graph.ParameterValue] = {"vehicle_file": "compact_car"}


def parameters_of(client: DdsClient, name: str) -> dict[str, Any]:
    """Every parameter of a node, those of ROS too."""
    listed = client.call(ListParameters, f"{name}/list_parameters", ListParameters.Request())
    names = sorted(listed.result.names)
    given = client.call(GetParameters, f"{name}/get_parameters", GetParameters.Request(names=names))
    return dict(zip(names, map(parameter_value_to_python, given.values), strict=True))


def dumped(path: Path, name: str, values: dict[str, Any]) -> Path:
    """Write a file as `ros2 param dump` does: nested at each point of a name, below the full name of the node."""
    nested: dict[str, Any] = {}
    for key, value in values.items():
        *groups, own = key.split(".")
        inner = nested
        for group in groups:
            inner = inner.setdefault(group, {})
        inner[own] = value if isinstance(value, (bool, int, float, str)) else list(value)
    path.write_text(yaml.dump({name: {"ros__parameters": nested}}, default_flow_style=False))
    return path


def test_dump_of_a_node_given_back_starts_it_with_the_same_parameters(tmp_path: Path) -> None:
    with dds_client() as client:
        first = {node: client.start(*graph.command(node, [], CAR, NAMESPACE)[1:]) for node in graph.NODES}
        values = {node: parameters_of(client, f"{NAMESPACE}/{node}") for node in graph.NODES}
        for node, process in first.items():
            assert "start_type_description_service" in values[node]
            assert any(name.startswith("qos_overrides.") for name in values[node])
            stop(process)
    with dds_client() as client:
        for node in graph.NODES:
            file = dumped(tmp_path / f"{node}.yaml", f"{NAMESPACE}/{node}", values[node])
            client.start(*graph.command(node, [file], {}, NAMESPACE)[1:])
        for node in graph.NODES:
            assert parameters_of(client, f"{NAMESPACE}/{node}") == values[node]


def test_supervisor_that_runs_takes_no_command_to_command() -> None:
    with dds_client() as client:
        client.start(*graph.command(graph.SUPERVISOR, [], CAR)[1:])
        change = Parameter("shadow", value=False).to_parameter_msg()
        request = SetParameters.Request(parameters=[change])
        (result,) = client.call(SetParameters, f"/{graph.SUPERVISOR}/set_parameters", request).results
        assert not result.successful
        assert not [name for name, _ in client.node.get_topic_names_and_types() if graph.COMMAND in name]
