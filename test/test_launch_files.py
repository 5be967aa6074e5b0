"""Launch files and their parameters: files are checked before anything starts, only the demo commands a brake."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest
import yaml
from ament_index_python.packages import get_package_share_directory

from friction_bags.offline.estimators import ESTIMATORS, SMART_TYRE, make_processors, read_parameters
from friction_bringup import graph
from friction_bringup.demo_drive import CALIBRATION, WAITED_FOR, plant_of_demo
from friction_bringup.node_start import (
    WATCHING,
    Decided,
    commanding,
    composed_arguments,
    left_to_file,
    node_starts,
    with_adapter,
)
from friction_parameters.parameter import ParameterError
from friction_parameters.parameter_file import NodeName, file_values
from friction_runtime.installed import shipped_file
from friction_runtime.processor import silent
from vehicle_models.vehicle_file import load_vehicle, shipped_vehicles

ROOT = Path(__file__).resolve().parents[1]
FILES = sorted(ROOT.glob("src/*/config/*.yaml"))
LAUNCH_FILES = Path(get_package_share_directory("friction_bringup"), "launch")
CAR = "compact_car"


def write(directory: Path, sections: Mapping[str, Mapping[str, Any]]) -> str:
    """Write a parameter file: parameters by section."""
    path = directory / "my_car.yaml"
    path.write_text(yaml.safe_dump({name: {"ros__parameters": dict(values)} for name, values in sections.items()}))
    return str(path)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_shipped_parameter_file_is_for_our_nodes_in_any_namespace_and_passes_their_checks(path: Path) -> None:
    sections = set(yaml.safe_load(path.read_text()))
    assert sections <= {f"/**/{node}" for node in (*graph.NODES, graph.ADAPTER)}
    for node in graph.NODES:
        found = file_values(graph.parameter_class(node), path, NodeName(node, "/my_car"))
        assert bool(found) == (f"/**/{node}" in sections), node


def test_a_signal_map_puts_the_adapter_before_the_estimators(tmp_path: Path) -> None:
    assert with_adapter(ESTIMATORS, WATCHING, "") == (ESTIMATORS, WATCHING)
    nodes, decided = with_adapter(ESTIMATORS, WATCHING, "bmw")
    assert nodes == (graph.ADAPTER, *ESTIMATORS)
    first, *rest = node_starts(nodes, decided, "", CAR)
    assert dict(first.decided) == {"vehicle_file": CAR, "map_file": "bmw"}
    assert rest == node_starts(ESTIMATORS, WATCHING, "", CAR)
    with pytest.raises(ParameterError, match="there is no signal map"):
        with_adapter(ESTIMATORS, WATCHING, str(tmp_path / "nowhere.yaml"))


@pytest.mark.parametrize("name", ["demo", "bmw_m8"])
def test_shipped_parameter_file_starts_every_node(name: str) -> None:
    starts = node_starts(graph.NODES, WATCHING, str(shipped_file("friction_bringup", name)), CAR)
    assert [start.node for start in starts] == list(graph.NODES)


@pytest.mark.parametrize(("section", "theirs"), [("/**/smart_tyre_forces", True), ("/**/wheel_slip", False)])
def test_calibration_in_the_users_file_is_not_overridden_by_that_of_the_demo(
    section: str, theirs: bool, tmp_path: Path
) -> None:
    calibration = str(graph.plant_calibration())
    file = write(tmp_path, {section: {"calibration_file": calibration} if theirs else {"deadline": 0.1}})
    of_demo = plant_of_demo("dry", CAR)
    decided = left_to_file(of_demo, SMART_TYRE, CALIBRATION, file, "my_car")
    assert (CALIBRATION in decided[SMART_TYRE]) is not theirs
    assert decided[graph.PLANT] == of_demo[graph.PLANT]
    assert left_to_file(of_demo, SMART_TYRE, CALIBRATION, "") == of_demo


def test_no_shipped_file_lets_the_supervisor_command() -> None:
    for path in FILES:
        values = file_values(graph.parameter_class(graph.SUPERVISOR), path, NodeName(graph.SUPERVISOR))
        assert values.get("shadow", True) is True, path
    assert graph.PLANT not in ESTIMATORS
    assert graph.SUPERVISOR in ESTIMATORS


@pytest.mark.parametrize("said", [False, True])
def test_supervisor_only_watches_whatever_a_file_says_and_that_is_said(said: bool, tmp_path: Path) -> None:
    file = write(tmp_path, {"/**/abs_supervisor": {"shadow": said}})
    (start,) = node_starts([graph.SUPERVISOR], WATCHING, file, CAR)
    assert start.decided["shadow"] is True
    assert "never a brake_command" in start.notes[0]
    assert any(f"not False as in {file}" in note for note in start.notes) != said


def test_nothing_in_a_file_for_every_node_lets_the_supervisor_command(tmp_path: Path) -> None:
    file = write(tmp_path, {"/**": {"shadow": False}, "/**/abs_supervisor": {"tolerance": 0.1}})
    (start,) = node_starts([graph.SUPERVISOR], WATCHING, file, CAR)
    made = graph.command(start.node, start.files, start.decided)
    assert made.index("shadow:=true") > made.index(file)


def test_estimator_without_a_car_is_refused_with_the_cars_there_are() -> None:
    for node in ESTIMATORS:
        with pytest.raises(ParameterError, match="'vehicle_file'") as refused:
            node_starts([node], WATCHING)
        assert all(name in str(refused.value) for name in shipped_vehicles())
        assert "\n" not in str(refused.value)


def test_plant_alone_needs_no_car() -> None:
    (start,) = node_starts([graph.PLANT], WATCHING)
    assert "vehicle_file" not in start.decided


def test_car_may_stand_in_the_parameter_file_and_the_argument_decides_and_says_so(tmp_path: Path) -> None:
    file = write(tmp_path, {"/**/wheel_slip": {"vehicle_file": "indy_av21"}})
    (start,) = node_starts(["wheel_slip"], WATCHING, file)
    assert "vehicle_file" not in start.decided
    (start,) = node_starts(["wheel_slip"], WATCHING, file, CAR)
    assert start.decided["vehicle_file"] == CAR
    assert any("indy_av21" in note and CAR in note for note in start.notes)


def test_files_are_found_from_the_directory_of_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path, {"/**/wheel_slip": {"deadline": 0.1}})
    car = ROOT / "src/vehicle_models/vehicle_models/vehicles/compact_car.yaml"
    (tmp_path / "car.yaml").write_text(car.read_text())
    monkeypatch.chdir(tmp_path)
    (start,) = node_starts(["wheel_slip"], WATCHING, "my_car.yaml", "car.yaml")
    assert start.files[-1] == tmp_path / "my_car.yaml"
    assert start.decided["vehicle_file"] == str(tmp_path / "car.yaml")


@pytest.mark.parametrize("vehicle", ["no_such_car", "no/such/car.yaml"])
def test_vehicle_file_that_does_not_exist_is_refused_with_its_name(vehicle: str) -> None:
    with pytest.raises(ParameterError, match=vehicle):
        node_starts(ESTIMATORS, WATCHING, "", vehicle)


def test_parameter_file_that_does_not_exist_is_refused_with_its_name(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match=r"no\.yaml: No such file"):
        node_starts(ESTIMATORS, WATCHING, str(tmp_path / "no.yaml"), CAR)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("/**/friction_slop: {ros__parameters: {method: slip}}", "is '/\\*\\*/friction_slope' meant"),
        ("/**/friction_slope: {ros__parameters: {metod: slip}}", "unknown parameter 'metod'"),
        ("/**/abs_supervisor: {ros__parameters: {wheels: [a]}}", "unknown parameter 'wheels'"),
        ("/**/abs_supervisor: {ros__parameters: {tolerance: 7.0}}", "'tolerance' = 7.0 s is outside"),
        ("friction_slope: {ros__parameters: {method: slip}}", "is not for the node /my_car/friction_slope"),
        ("/other/friction_slope: {ros__parameters: {method: slip}}", "is not for the node /my_car/friction_slope"),
        ("/**/wheel_slip: {ros__parameters: {}}\n/**/wheel_slip: {ros__parameters: {}}", "line 2.*line 1"),
        ("/**/wheel_slip: {ros__parameters: {deadline: 0.1, deadline: 0.2}}", "'deadline' is repeated here"),
        ("/**/wheel_slip: [", "not YAML: "),
    ],
)
def test_parameter_file_that_is_bad_for_a_node_is_refused_in_one_line(text: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.yaml"
    path.write_text(text)
    with pytest.raises(ParameterError, match=said) as refused:
        node_starts(ESTIMATORS, WATCHING, str(path), CAR, "my_car")
    assert "\n" not in str(refused.value)
    assert str(path) in str(refused.value)


@pytest.mark.parametrize("namespace", ["my_car", "/my_car", "/my_car/"])
def test_full_names_and_other_nodes_in_a_file_are_fine(namespace: str, tmp_path: Path) -> None:
    sections: dict[str, dict[str, Any]] = {
        "/my_car/wheel_slip": {"use_sim_time": False, "start_type_description_service": True, "deadline": 0.1},
        "/camera": {"anything": 1},
        "/**": {"use_sim_time": False, "of_others": 1},
    }
    node_starts(ESTIMATORS, WATCHING, write(tmp_path, sections), CAR, namespace)


def test_combination_that_a_node_refuses_is_refused_before_it_starts(tmp_path: Path) -> None:
    file = write(tmp_path, {"/**/corner_sim": {"real_time_factor": 0.0}})
    with pytest.raises(ParameterError, match=r"corner_sim: .*lock_step"):
        node_starts(graph.NODES, commanding("curve"), file, CAR)


def test_command_line_quotes_every_kind_of_parameter() -> None:
    overrides: dict[str, graph.ParameterValue] = {
        "surfaces": ["snow"],
        "shadow": True,
        "surface_distances": [0.345, 0.3465],
        "level": 1,
    }
    made = graph.command("corner_sim", [Path("/a/b.yaml")], overrides, namespace="/car/")
    assert made[1:] == [
        *("-m", "corner_sim", "--ros-args", "--params-file", "/a/b.yaml"),
        *("-p", 'surfaces:=["snow"]', "-p", "shadow:=true", "-p", "surface_distances:=[0.345, 0.3465]"),
        *("-p", "level:=1", "-r", "__ns:=/car"),
    ]


def test_one_process_takes_what_is_decided_for_each_of_its_nodes(tmp_path: Path) -> None:
    file = write(tmp_path, {"/**/wheel_slip": {"deadline": 0.1}})
    decided: Decided = {**commanding("curve"), "friction_curve_id": {"method": "ml"}}
    starts = node_starts(graph.NODES, decided, file, CAR)
    made = composed_arguments(starts)
    files = [made[place + 1] for place, flag in enumerate(made) if flag == "--params-file"]
    assert files == [*(str(shipped_file(node)) for node in ESTIMATORS if node in graph.COMPOSED), file]
    assert made[made.index('friction_curve_id:method:="ml"') - 1] == "-p"
    assert {word.split(":")[0] for word in made if ":=" in word} == set(graph.COMPOSED)


def test_the_plant_waits_for_each_subscription_to_wheel_states_that_there_will_be() -> None:
    car = load_vehicle(CAR)
    made = {node: make_processors(read_parameters([node], (), silent), car, silent) for node in ESTIMATORS}
    readers = {node for node in made if any("wheel_states" in each.sensors for each in made[node])}
    assert readers == set(graph.WHEEL_STATES_READERS)
    assert graph.wheel_states_subscriptions(composed=False) == len(readers)
    assert graph.wheel_states_subscriptions(composed=True) == 1 + len(readers - set(graph.COMPOSED))


SHARED = ["friction_bringup", *(node for node in graph.NODES if node not in graph.COMPOSED)]
"""Packages of the processes where the estimators share one."""
needs_launch = pytest.mark.skipif(
    importlib.util.find_spec("launch_ros") is None, reason="launch_ros is not installed here"
)


def launched(name: str, **arguments: str) -> list[Any]:
    """Return the actions of a launch file, with launch_ros."""
    from launch import LaunchContext, LaunchService
    from launch.launch_description_sources import get_launch_description_from_python_launch_file

    description = get_launch_description_from_python_launch_file(str(LAUNCH_FILES / f"{name}.launch.py"))
    context: LaunchContext = LaunchService().context
    context.launch_configurations.update(arguments)
    return [made for entity in description.entities for made in entity.visit(context) or []]


@needs_launch
@pytest.mark.parametrize(
    ("name", "nodes", "arguments"),
    [
        ("demo", graph.NODES, {"surface": "snow", "composed": "false"}),
        ("demo", SHARED, {"use_sim_time": "True", "vehicle_file": CAR}),
        ("graph", ESTIMATORS, {"vehicle_file": CAR}),
        ("graph", ["friction_bringup", graph.SUPERVISOR], {"vehicle_file": CAR, "composed": "true"}),
        ("alongside", ESTIMATORS, {"vehicle_file": CAR, "namespace": "my_car"}),
        ("alongside", [graph.ADAPTER, *ESTIMATORS], {"vehicle_file": CAR, "map_file": "bmw"}),
        ("node", [graph.PLANT], {"node": graph.PLANT}),
        ("node", [graph.SUPERVISOR], {"node": graph.SUPERVISOR, "vehicle_file": CAR}),
    ],
)
def test_launch_file_starts_nodes_of_the_one_list(name: str, nodes: list[str], arguments: dict[str, str]) -> None:
    from launch.actions import LogInfo
    from launch_ros.actions import Node

    actions = launched(name, **arguments)
    assert [made.node_package for made in actions if isinstance(made, Node)] == list(nodes)
    watches = name != "demo" and graph.SUPERVISOR in nodes
    notes = [part.text for made in actions if isinstance(made, LogInfo) for part in made.msg]
    assert any("shadow mode" in note for note in notes) == watches


@needs_launch
@pytest.mark.parametrize("composed", ["false", "true"])
def test_launched_demo_starts_its_plant_when_all_are_there(composed: str, tmp_path: Path) -> None:
    from launch import LaunchContext
    from launch_ros.actions import Node
    from launch_ros.utilities import evaluate_parameters

    def waited_for(**more: str) -> Any:
        (plant,) = (
            made
            for made in launched("demo", composed=composed, **more)
            if isinstance(made, Node) and made.node_package == graph.PLANT
        )
        given = evaluate_parameters(LaunchContext(), plant._Node__parameters)
        return next((each[WAITED_FOR] for each in given if isinstance(each, dict) and WAITED_FOR in each), None)

    assert waited_for() == graph.wheel_states_subscriptions(composed == "true")
    assert waited_for(params_file=write(tmp_path, {"/**/corner_sim": {WAITED_FOR: 7}})) is None


@needs_launch
@pytest.mark.parametrize("name", ["alongside", "node"])
def test_launch_file_without_a_car_starts_nothing(name: str) -> None:
    with pytest.raises(ParameterError, match="compact_car"):
        launched(name, node="wheel_slip")


@needs_launch
@pytest.mark.parametrize("name", ["alongside", "node", "demo"])
def test_launch_file_with_a_parameter_file_that_does_not_exist_starts_nothing(name: str) -> None:
    with pytest.raises(ParameterError, match=r"my_cra\.yaml"):
        launched(name, node="wheel_slip", vehicle_file=CAR, params_file="my_cra.yaml")


def executed(entity: Any, context: Any) -> Iterator[Any]:
    """Yield what an entity leads to, in the order in which launch executes it."""
    from launch_ros.actions import Node

    yield entity
    if not isinstance(entity, Node):
        for made in entity.visit(context) or []:
            yield from executed(made, context)


@needs_launch
def test_example_with_other_names_starts_the_estimators_with_every_input_remapped() -> None:
    from launch import LaunchContext, LaunchService
    from launch.launch_description_sources import get_launch_description_from_python_launch_file
    from launch_ros.actions import Node

    file = str(LAUNCH_FILES / "other_names.launch.py")
    context: LaunchContext = LaunchService().context
    context.launch_configurations["vehicle_file"] = CAR
    remapped: dict[str, dict[str, str]] = {}
    for entity in get_launch_description_from_python_launch_file(file).entities:
        for made in executed(entity, context):
            if isinstance(made, Node):
                remapped[str(made.node_package)] = dict(context.launch_configurations["ros_remaps"])
    assert tuple(remapped) == ESTIMATORS
    processors = make_processors(read_parameters(ESTIMATORS, (), silent), load_vehicle(CAR), silent)
    made_here = {topic for each in processors for topic in each.outputs}
    inputs = {topic for each in processors for topics in (each.sensors, each.estimates) for topic in topics} - made_here
    for names in remapped.values():
        assert names.keys() == {topic for topic in inputs if not topic.endswith("/tyre_signals")}
        assert all(name.startswith("/") for name in names.values())


@needs_launch
@pytest.mark.parametrize(
    ("name", "ends_with", "launch_ends_with"),
    [
        ("corner_sim_node", "exit 0", 0),  # the run is over
        ("corner_sim_node", "exit 3", 1),
        ("wheel_slip_node", "exit 0", 1),
        ("wheel_slip_node", "kill -KILL $$", 1),
    ],
)
def test_process_that_ends_by_itself_ends_its_launch(name: str, ends_with: str, launch_ends_with: int) -> None:
    from launch import LaunchDescription, LaunchService
    from launch.actions import ExecuteProcess

    from friction_bringup.launching import end_launch

    commands = {name: ["sh", "-c", ends_with], "other": ["sleep", "600"]}
    service = LaunchService(noninteractive=True)
    service.include_launch_description(
        LaunchDescription(
            [ExecuteProcess(name=name, cmd=command, on_exit=end_launch) for name, command in commands.items()]
        )
    )
    assert service.run() == launch_ends_with
