"""The estimators in one process, as a real process over DDS: the messages, names and manners of separate nodes."""

from __future__ import annotations

import signal
import subprocess
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from ament_index_python.packages import get_package_share_directory
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rcl_interfaces.msg import Log
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from std_srvs.srv import Trigger

from corner_sim.parameters import SimParameters
from corner_sim.ros.simulation import Simulation
from friction_bags.bag_io.cdr import encode
from friction_bags.offline.estimators import make_processors, read_parameters
from friction_bringup import graph
from friction_parameters.parameter import from_mapping
from friction_runtime import qos
from friction_runtime.messages import to_nanoseconds
from friction_runtime.processor import Output, silent
from friction_test_support.dds_client import DdsClient, dds_client, output_of, stop
from vehicle_models.vehicle_file import load_vehicle

CAR = "smart_tyre_car"
CALIBRATION = Path(get_package_share_directory("smart_tyre_forces"), "calibration", "plant_tyres.yaml")
"""Of the tyres of the plant: without it the first revolutions are for learning the teeth."""
VEHICLE = load_vehicle(CAR)
DEFECTIVE = str(Path(__file__).with_name("defective_graph.py"))
COMPOSED = ("-m", "friction_bringup", "graph")
SAMPLES = 100
SENSORS = ("wheel_states", "imu/data", "vehicle_velocity", "brake_pressure", "tyre_signals")


@pytest.fixture
def client() -> Iterator[DdsClient]:
    with dds_client() as made:
        yield made


def braking() -> list[list[Output]]:
    """Sensor messages of a braking by sample, with those of the tyres."""
    values = {"model": "car", "tyre_signals": True, "demand_start": 0.1, "demand_level": 1.3, "demand_rise": 0.1}
    plant = Simulation(from_mapping(SimParameters, {"vehicle_file": CAR, **values}), VEHICLE, 1_000_000_000)
    samples = []
    for _ in range(SAMPLES):
        samples.append([(topic, each) for topic, each in plant.messages() if _is_sensor(topic)])
        plant.advance()
    return samples


def _is_sensor(topic: str) -> bool:
    return topic.endswith(SENSORS) and not topic.startswith("truth/")


def outputs_of(names: Sequence[str] = graph.COMPOSED) -> dict[str, type]:
    """Topics and types of some estimators for the car."""
    processors = make_processors(read_parameters(names, (), silent), VEHICLE, silent)
    return {topic: kind for processor in processors for topic, kind in processor.outputs.items()}


class Beside:
    """The test's side of the estimators in one namespace."""

    def __init__(self, client: DdsClient, namespace: str, samples: Sequence[Sequence[Output]]) -> None:
        self._client = client
        place = f"/{namespace}" if namespace else ""
        node = client.node
        first = {topic: type(message) for sample in samples[:2] for topic, message in sample}
        self._publishers = {topic: qos.publish(node, kind, f"{place}/{topic}") for topic, kind in first.items()}
        self.received: dict[str, list[Any]] = {topic: [] for topic in outputs_of()}
        for topic, kind in outputs_of().items():
            qos.subscribe(node, kind, f"{place}/{topic}", self.received[topic].append, qos.ESTIMATE)
        client.until(lambda: all(each.get_subscription_count() for each in self._publishers.values()))
        client.until(lambda: all(node.count_publishers(f"{place}/{topic}") == 1 for topic in self.received))
        for name in graph.COMPOSED:
            client.call(ListParameters, f"{place}/{name}/list_parameters", ListParameters.Request())

    def send(self, sample: Sequence[Output]) -> None:
        for topic, message in sample:
            self._publishers[topic].publish(message)

    def until_answers(self, count: int, *estimates: str) -> None:
        """Wait until all wheels have an answer to so many samples."""
        self._client.until(lambda: self.answers(*estimates) >= count)

    def answers(self, *estimates: str) -> int:
        """Return how many samples all wheels have an answer to."""
        return min(
            len({to_nanoseconds(message.header.stamp) for message in found})
            for topic, found in self.received.items()
            if topic.endswith(estimates)
        )


EVERY_SAMPLE = ("/slip", "/friction_slope", "/slope_vote", "/friction_curve")


def test_outputs_of_one_process_are_those_of_separate_nodes_to_the_last_bit(client: DdsClient) -> None:
    car = ("-p", f"vehicle_file:={CAR}", "-p", f"smart_tyre_forces:calibration_file:={CALIBRATION}")
    client.start(*COMPOSED, "--ros-args", "-r", "__ns:=/one", *car)
    for name in graph.COMPOSED:
        client.start("-m", name, "--ros-args", "-r", "__ns:=/many", *car)
    samples = braking()
    one, many = (Beside(client, namespace, samples) for namespace in ("one", "many"))
    for number, sample in enumerate(samples, start=1):
        for each in (one, many):
            each.send(sample)
        for each in (one, many):
            each.until_answers(number, *EVERY_SAMPLE)
    client.until(lambda: all(len(one.received[topic]) == len(found) for topic, found in many.received.items()))
    for topic, found in many.received.items():
        assert len(found) >= (SAMPLES if topic.endswith(EVERY_SAMPLE) else 0), topic
        assert [encode(message) for message in one.received[topic]] == [encode(message) for message in found], topic
    assert all(many.received[f"{wheel}/contact_patch"] for wheel in VEHICLE.wheel_names)
    assert any(message.validity.valid for message in many.received["front_left/slip"])


def test_what_is_made_inside_is_not_read_back_and_sensors_are_subscribed_to_once(client: DdsClient) -> None:
    client.start(*COMPOSED, "--ros-args", "-p", f"vehicle_file:={CAR}")
    Beside(client, "", braking()[:2])
    node = client.node

    def readers(topic: str) -> list[str]:
        return [each.node_name for each in node.get_subscriptions_info_by_topic(f"/{topic}")]

    client.until(lambda: readers("wheel_states") == ["wheel_slip"])
    client.until(lambda: readers("front_left/brake_pressure") == ["wheel_slip"])
    client.until(lambda: readers("front_left/tyre_signals") == ["smart_tyre_forces"])
    client.until(lambda: readers("front_left/slip") == ["test_client"])


@pytest.fixture
def statuses(client: DdsClient) -> dict[str, DiagnosticStatus]:
    """Newest entry of /diagnostics by name."""
    found: dict[str, DiagnosticStatus] = {}

    def note(array: DiagnosticArray) -> None:
        found.update((status.name, status) for status in array.status)

    client.node.create_subscription(DiagnosticArray, "/diagnostics", note, 10)
    return found


def test_an_exception_of_one_estimator_is_told_once_and_leaves_the_others_alone(
    client: DdsClient, statuses: dict[str, DiagnosticStatus]
) -> None:
    logged: list[str] = []
    client.node.create_subscription(Log, "/rosout", lambda line: logged.append(line.msg), 100)
    process = client.start(DEFECTIVE, "raising", "--ros-args", "-p", f"vehicle_file:={CAR}")
    samples = braking()
    beside = Beside(client, "", samples)
    for number, sample in enumerate(samples, start=1):
        beside.send(sample)
        beside.until_answers(number, "/slip")
    defective = ("front_left/slope_vote", "front_left/friction_slope")
    every = [topic for topic in beside.received if topic.endswith(EVERY_SAMPLE) and topic not in defective]
    client.until(lambda: all(len(beside.received[topic]) == SAMPLES for topic in every))
    client.until(lambda: all(len(beside.received[topic]) > SAMPLES // 2 for topic in defective))
    name = "/friction_slope: front_left"
    client.until(lambda: name in statuses and int(dict(values(statuses[name])).get("exceptions", 0)) == 3)
    assert statuses[name].level == DiagnosticStatus.ERROR
    assert "starts again" in statuses[name].message
    assert statuses["/friction_slope: front_right"].message.find("defect") < 0
    assert len([line for line in logged if "defect" in line]) == 1
    assert client.call(Trigger, "/friction_slope/reset", Trigger.Request()).success
    client.until(lambda: "defect" not in statuses[name].message)
    assert process.poll() is None


def values(status: DiagnosticStatus) -> Iterator[tuple[str, str]]:
    return ((each.key, each.value) for each in status.values)


def test_a_curve_that_takes_long_holds_back_neither_slip_nor_slope(client: DdsClient) -> None:
    """The curves of a sample take 0.8 s: in the order of arrival the slips would come after nearly all of them."""
    client.start(DEFECTIVE, "slow", "--ros-args", "-p", f"vehicle_file:={CAR}")
    samples = braking()[:50]
    beside = Beside(client, "", samples)
    for sample in samples:
        beside.send([(topic, message) for topic, message in sample if not topic.endswith("tyre_signals")])
    client.until(lambda: beside.answers("/slip", "/friction_slope") == 50)
    assert beside.answers("/friction_curve") < 40
    client.until(lambda: beside.answers("/friction_curve") >= 2)


def test_each_node_has_its_own_parameters_reset_and_diagnostics(
    client: DdsClient, statuses: dict[str, DiagnosticStatus], tmp_path: Path
) -> None:
    file = tmp_path / "parameters.yaml"
    file.write_text(
        "/**/friction_slope: {ros__parameters: {deadline: 0.06}}\n"
        "/my_car/wheel_slip: {ros__parameters: {deadline: 0.07}}\n"
    )
    arguments = ("-r", "__ns:=/my_car", "--params-file", str(file), "-p", f"vehicle_file:={CAR}")
    client.start(*COMPOSED, "--ros-args", *arguments, "-p", "friction_curve_id:deadline:=0.08")

    def deadline(name: str) -> float:
        request = GetParameters.Request(names=["deadline"])
        (value,) = client.call(GetParameters, f"/my_car/{name}/get_parameters", request).values
        return float(parameter_value_to_python(value))

    assert [deadline(name) for name in ("wheel_slip", "friction_slope", "friction_curve_id")] == [0.07, 0.06, 0.08]
    refused = set_parameter(client, "/my_car/friction_slope", "deadline", -1.0)
    assert not refused.successful
    assert "deadline" in refused.reason
    assert set_parameter(client, "/my_car/friction_slope", "deadline", 0.09).successful
    assert [deadline(name) for name in ("wheel_slip", "friction_slope", "friction_curve_id")] == [0.07, 0.09, 0.08]
    samples = braking()[:5]
    beside = Beside(client, "my_car", samples)
    for sample in samples:
        beside.send(sample)
    beside.until_answers(5, *EVERY_SAMPLE)
    for name in graph.COMPOSED:
        client.until(partial(statuses.__contains__, f"/my_car/{name}: inputs"))
        answer = client.call(Trigger, f"/my_car/{name}/reset", Trigger.Request())
        assert answer.message == f"{name}: started again"
    for service in ("zero_shift", "zero_length"):
        assert client.call(Trigger, f"/my_car/smart_tyre_forces/{service}", Trigger.Request()).success


def set_parameter(client: DdsClient, node: str, name: str, value: Any) -> Any:
    message: ParameterMessage = Parameter(name, value=value).to_parameter_msg()
    return client.call(SetParameters, f"{node}/set_parameters", SetParameters.Request(parameters=[message])).results[0]


def test_a_change_of_method_connects_what_the_new_one_takes(client: DdsClient) -> None:
    calibrated = ("-p", f"smart_tyre_forces:calibration_file:={CALIBRATION}")
    client.start(*COMPOSED, "--ros-args", "-p", f"vehicle_file:={CAR}", *calibrated)
    samples = braking()
    beside = Beside(client, "", samples)
    assert set_parameter(client, "/friction_curve_id", "method", "tyre_force").successful
    for number, sample in enumerate(samples, start=1):
        beside.send(sample)
        beside.until_answers(number, "/slip")
    client.until(lambda: any(each.method == "tyre_force" for each in beside.received["front_left/friction_curve"]))
    assert [each.node_name for each in client.node.get_subscriptions_info_by_topic("/front_left/tyre_force")] == [
        "test_client"
    ]


def test_remapping_connects_the_nodes_as_the_middleware_does(
    client: DdsClient, statuses: dict[str, DiagnosticStatus]
) -> None:
    """The slip of one wheel has another name for all nodes, that of another wheel for the one that makes it."""
    nodes = ("wheel_slip", "friction_slope", "friction_state")
    all_of_them = [word for name in nodes for word in ("-r", f"{name}:front_left/slip:=my_slip")]
    one = ("-r", "wheel_slip:front_right/slip:=elsewhere")
    renamed = ("-r", "smart_tyre_forces:__node:=tyres")
    client.start(*COMPOSED, "--ros-args", *all_of_them, *one, *renamed, "-p", f"vehicle_file:={CAR}")
    node = client.node
    client.until(lambda: node.count_publishers("/my_slip") == node.count_publishers("/elsewhere") == 1)
    client.until(lambda: subscribed(node, "/front_right/slip") == ["friction_slope"])
    client.until(lambda: subscribed(node, "/front_left/tyre_signals") == ["tyres"])
    assert not [name for name in ("my_slip", "elsewhere", "front_left/slip") if subscribed(node, f"/{name}")]
    samples = braking()
    publishers = {topic: qos.publish(node, type(message), topic) for topic, message in samples[0]}
    client.until(lambda: all(each.get_subscription_count() for each in publishers.values()))
    left, right = "/friction_slope: front_left", "/friction_slope: front_right"

    def told() -> bool:
        for topic, message in next(upcoming, []):
            if topic in publishers:
                publishers[topic].publish(message)
        client.executor.spin_once(timeout_sec=0.05)
        return right in statuses and "front_right/slip: no message yet" in statuses[right].message

    upcoming = iter(samples)
    client.until(told)
    assert "/slip" not in statuses[left].message


def subscribed(node: Node, topic: str) -> list[str]:
    return [each.node_name for each in node.get_subscriptions_info_by_topic(topic)]


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_signal_ends_the_process_with_code_0(client: DdsClient, how: signal.Signals) -> None:
    process = client.start(*COMPOSED, "--ros-args", "-p", f"vehicle_file:={CAR}")
    client.until(lambda: all(client.node.count_publishers(f"/{topic}") for topic in outputs_of()))
    assert stop(process, how) == ""
    assert process.returncode == 0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["-p", "friction_slope:deadline:=-1"], "'deadline' = -1.0 s"),
        (["-p", "friction_slope:metod:=slip"], "node /friction_slope: unknown parameter 'metod'"),
        (["-p", "noise:=1"], "node /wheel_slip: unknown parameter 'noise'"),
        (
            ["-r", "__node:=mine"],
            "wheel_slip, friction_slope, smart_tyre_forces, friction_state, friction_grip, friction_curve_id are given "
            "one name",
        ),
        (["-p", "smart_tyre_forces:calibration_file:=/no/such/file"], "/no/such/file"),
        (["-p", "vehicle_file:=no_such_car"], "no_such_car"),
    ],
)
def test_a_bad_parameter_is_refused_by_name(client: DdsClient, arguments: Sequence[str], said: str) -> None:
    process: subprocess.Popen[str] = client.start(*COMPOSED, "--ros-args", "-p", f"vehicle_file:={CAR}", *arguments)
    output = output_of(process)
    assert process.returncode == 2
    assert said in output
    assert len(output.splitlines()) == 1, output
