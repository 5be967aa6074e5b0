"""The shared node as a real process over DDS: moves messages, takes and refuses parameters, resets, exits."""

import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from friction_msgs.msg import BrakeDemand, WheelSlip
from rcl_interfaces.msg import Log, SetParametersResult
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParameters
from rclpy.parameter import Parameter, parameter_value_to_python
from std_srvs.srv import Trigger

from friction_runtime import qos
from friction_runtime.reports import REPEAT_AFTER
from friction_test_support.dds_client import DdsClient, dds_client, output_of, stop

SCRIPT = str(Path(__file__).with_name("friction_runtime_echo_node.py"))


@pytest.fixture
def client() -> Iterator[DdsClient]:
    with dds_client() as made:
        yield made


@pytest.fixture
def echo(client: DdsClient) -> subprocess.Popen[str]:
    return client.start(SCRIPT)


class Link:
    """The test's side of one input and one output of the echo."""

    def __init__(self, client: DdsClient, prefix: str = "") -> None:
        self._client = client
        self._publisher = qos.publish(client.node, BrakeDemand, f"{prefix}brake_demand")
        self.received: list[WheelSlip] = []
        qos.subscribe(client.node, WheelSlip, f"front_left/{prefix}slip", self.received.append, qos.ESTIMATE)
        client.until(
            lambda: (
                self._publisher.get_subscription_count() == 1
                and client.node.count_publishers(f"front_left/{prefix}slip") == 1
            )
        )

    def send(self, pressure: float = 3.0) -> None:
        """Send a demand [Pa]."""
        self._publisher.publish(BrakeDemand(pressure=pressure))

    def send_until(self, condition: Callable[[], bool], pressure: float = 3.0) -> None:
        """Send demands [Pa] until the condition holds."""

        def holds() -> bool:
            self.send(pressure)
            self._client.executor.spin_once(timeout_sec=0.05)
            return condition()

        self._client.until(holds)

    def until_answer(self, expected: float, pressure: float = 3.0) -> None:
        """Send demands [Pa] until the answer is as expected."""
        self.send_until(lambda: bool(self.received) and self.received[-1].slip == expected, pressure)


def set_parameter(client: DdsClient, name: str, value: Any) -> SetParametersResult:
    message: ParameterMessage = Parameter(name, value=value).to_parameter_msg()
    return client.call(SetParameters, "/echo/set_parameters", SetParameters.Request(parameters=[message])).results[0]


def get_parameters(client: DdsClient, *names: str, node: str = "/echo") -> list[Any]:
    values = client.call(GetParameters, f"{node}/get_parameters", GetParameters.Request(names=names)).values
    return [parameter_value_to_python(value) for value in values]


def dump(client: DdsClient, node: str) -> str:
    """Parameters of a node as `ros2 param dump` writes them."""
    names = sorted(client.call(ListParameters, f"{node}/list_parameters", ListParameters.Request()).result.names)
    tree: dict[str, Any] = {}
    for name, value in zip(names, get_parameters(client, *names, node=node), strict=True):
        *outer, own = name.split(".")
        branch = tree
        for part in outer:
            branch = branch.setdefault(part, {})
        branch[own] = value if isinstance(value, (bool, int, float, str)) else list(value)
    return yaml.dump({node: {"ros__parameters": tree}}, default_flow_style=False)


def test_node_moves_messages_takes_parameters_resets_and_reports(
    echo: subprocess.Popen[str], client: DdsClient
) -> None:
    health: list[DiagnosticArray] = []
    client.node.create_subscription(DiagnosticArray, "/diagnostics", health.append, 10)
    link = Link(client)
    link.until_answer(6.0)
    assert set_parameter(client, "gain", 4.0).successful
    link.until_answer(12.0)
    assert set_parameter(client, "filter.offset", 1.0).successful
    link.until_answer(13.0)

    described = client.call(DescribeParameters, "/echo/describe_parameters", DescribeParameters.Request(names=["gain"]))
    assert described.descriptors[0].description == "factor"

    assert client.call(Trigger, "/echo/reset", Trigger.Request()).success
    client.until(lambda: bool(health))
    names = {status.name for array in health for status in array.status}
    assert names == {"/echo: echo", "/echo: inputs"}


def test_bytes_that_are_no_message_are_dropped_and_end_no_node(echo: subprocess.Popen[str], client: DdsClient) -> None:
    link = Link(client)
    link.until_answer(6.0)
    garbage = client.node.create_publisher(BrakeDemand, "brake_demand", qos.ESTIMATE)
    client.until(lambda: garbage.get_subscription_count() > 0)
    client.until_known_to("echo")
    for _ in range(20):
        garbage.publish(b"\0\1\0\0garbage")
        client.executor.spin_once(timeout_sec=0.01)
    link.received.clear()
    link.until_answer(6.0)
    assert echo.poll() is None


def test_an_exception_of_a_processor_ends_no_node_and_is_an_error_until_a_reset(
    echo: subprocess.Popen[str], client: DdsClient
) -> None:
    health: list[DiagnosticStatus] = []
    client.node.create_subscription(DiagnosticArray, "/diagnostics", lambda array: health.extend(array.status), 10)
    logged: list[str] = []
    client.node.create_subscription(Log, "/rosout", lambda line: logged.append(line.msg), 10)
    link = Link(client)
    link.until_answer(6.0)

    def told() -> bool:
        link.send(1e300)
        return any("brake_demand" in line and "OverflowError" in line for line in logged)

    client.until(told)
    client.until(
        lambda: any(status.level == DiagnosticStatus.ERROR and "too much" in status.message for status in health)
    )
    link.until_answer(6.0)
    assert echo.poll() is None
    assert client.call(Trigger, "/echo/reset", Trigger.Request()).success
    health.clear()
    client.until(lambda: any(status.name == "/echo: echo" and status.level == DiagnosticStatus.OK for status in health))


def test_an_integer_is_taken_for_a_float_of_a_running_node(echo: subprocess.Popen[str], client: DdsClient) -> None:
    link = Link(client)
    assert set_parameter(client, "gain", 4).successful
    assert set_parameter(client, "filter.weights", [0, 1]).successful
    link.until_answer(12.0)
    gain, weights = get_parameters(client, "gain", "filter.weights")
    assert (gain, type(gain), list(weights)) == (4.0, float, [0.0, 1.0])


@pytest.mark.parametrize("value", [11.0, 11, "much", True])
def test_a_bad_change_is_refused_and_changes_nothing(
    value: Any, echo: subprocess.Popen[str], client: DdsClient
) -> None:
    link = Link(client)
    refused = set_parameter(client, "gain", value)
    assert not refused.successful
    assert "gain" in refused.reason or "type" in refused.reason
    link.until_answer(6.0)
    assert get_parameters(client, "gain") == [2.0]


def test_what_can_be_set_at_start_only_is_refused_later(echo: subprocess.Popen[str], client: DdsClient) -> None:
    assert not set_parameter(client, "vehicle_file", "compact_car").successful
    assert get_parameters(client, "vehicle_file") == ["chapter_corner"]


def test_a_change_of_method_adds_topics_and_a_refused_one_leaves_all_as_it_is(
    echo: subprocess.Popen[str], client: DdsClient
) -> None:
    health: list[DiagnosticArray] = []
    client.node.create_subscription(DiagnosticArray, "/diagnostics", health.append, 10)

    def counts() -> list[int]:
        values = [each.values for array in health for each in array.status if each.name == "/echo: echo"]
        return [int(value.value) for each in values for value in each if value.key == "count"]

    link = Link(client)
    assert set_parameter(client, "method", "mirror").successful
    mirrored = Link(client, "mirrored_")
    mirrored.until_answer(-6.0)
    link.until_answer(6.0)

    received = len(link.received) + len(mirrored.received)
    refused = set_parameter(client, "gain", 9.5)
    assert not refused.successful
    assert refused.reason == "parameter 'gain' is too much for a mirror"
    health.clear()
    client.until(lambda: bool(counts()))
    assert counts()[-1] >= received, "the processor was built again"
    mirrored.until_answer(-6.0)
    assert set_parameter(client, "gain", 5.0).successful
    mirrored.until_answer(-15.0)

    assert set_parameter(client, "method", "plain").successful
    link.until_answer(15.0)
    received = len(mirrored.received)
    mirrored.send()
    assert set_parameter(client, "gain", 6.0).successful
    link.until_answer(18.0)
    assert len(mirrored.received) == received
    assert set_parameter(client, "method", "mirror").successful
    mirrored.until_answer(-18.0)


def test_an_input_that_may_never_come_is_no_fault_until_it_has_come(client: DdsClient) -> None:
    health: list[DiagnosticArray] = []
    client.node.create_subscription(DiagnosticArray, "/diagnostics", health.append, 10)

    def says(text: str) -> bool:
        messages = [each.message for array in health for each in array.status if each.name == "/echo: inputs"]
        return bool(messages) and messages[-1] == text

    client.start(SCRIPT, "--ros-args", "-p", "method:=mirror")
    link = Link(client)
    link.send_until(lambda: says("ok"))
    Link(client, "mirrored_").until_answer(-6.0)
    link.send_until(lambda: says("no message within 1 s on mirrored_brake_demand"))


def test_what_is_set_for_another_method_is_said_once(client: DdsClient) -> None:
    process = client.start(SCRIPT, "--ros-args", "-p", "mirror.factor:=3")
    Link(client).until_answer(6.0)
    assert set_parameter(client, "gain", 4.0).successful
    output = stop(process)
    assert output.count("mirror.factor: ignored, as 'method' is 'plain', not mirror") == 1


def test_warnings_that_differ_in_a_value_only_are_logged_once_in_a_while(
    echo: subprocess.Popen[str], client: DdsClient
) -> None:
    link = Link(client)
    link.until_answer(6.0)
    begin = time.monotonic()
    for k in range(50):
        link.send(-1.0 - 0.01 * k)
    link.until_answer(8.0, 4.0)  # so the node has read what was sent before
    passed = time.monotonic() - begin
    output = stop(echo)
    assert 1 <= output.count(" Pa is negative: refused") <= 1 + passed / REPEAT_AFTER


def test_an_answer_does_not_wait_for_what_is_logged_of_it(echo: subprocess.Popen[str], client: DdsClient) -> None:
    link = Link(client)
    answers: dict[float, int] = {}
    logged: list[int] = []

    def note(message: Any, info: dict[str, int]) -> None:
        if not isinstance(message, Log):
            answers[message.slip] = info["source_timestamp"]
        elif message.msg.endswith("is much"):
            logged.append(info["source_timestamp"])

    client.node.create_subscription(Log, "/rosout", note, 100)
    client.until(lambda: client.node.count_publishers("/rosout") > 1)
    client.node.create_subscription(WheelSlip, "front_left/slip", note, qos.ESTIMATE)
    link.send_until(lambda: 6.0 in answers)  # the link may have its answer before this subscription is matched
    link.send(1e7)
    client.until(lambda: 2e7 in answers and bool(logged))
    assert answers[2e7] < logged[0]


@pytest.mark.parametrize("namespace", ["", "/my_car"])
def test_a_dump_given_back_starts_the_node_with_the_same_parameters(
    namespace: str, client: DdsClient, tmp_path: Path
) -> None:
    node = f"{namespace}/echo"
    place = ["-r", f"__ns:={namespace}"] if namespace else []
    values = ["-p", "filter.offset:=1", "-p", "filter.weights:=[0, 40.5]", "-p", "use_sim_time:=True"]
    first = client.start(SCRIPT, "--ros-args", *place, *values)
    text = dump(client, node)
    stop(first)
    for name in ("use_sim_time: true", "start_type_description_service: true", "qos_overrides:", "  filter:\n"):
        assert name in text
    file = tmp_path / "dump.yaml"
    file.write_text(text)
    client.until(lambda: client.node.count_publishers(f"{namespace}/front_left/slip") == 0)
    again = client.start(SCRIPT, "--ros-args", *place, "--params-file", str(file))
    assert dump(client, node) == text
    output = stop(again)
    assert again.returncode == 0, output


def test_of_files_and_arguments_the_last_decides(client: DdsClient, tmp_path: Path) -> None:
    for name, gain in (("first", 3), ("second", 5)):
        (tmp_path / f"{name}.yaml").write_text(
            f"/**/echo: {{ros__parameters: {{gain: {gain}, filter: {{offset: {gain}}}, use_sim_time: no}}}}\n"
            f"/**/other: {{ros__parameters: {{gain: nonsense}}}}\n"
            f"/**: {{ros__parameters: {{of_others: 1}}}}\n"
        )
    files = [word for name in ("first", "second") for word in ("--params-file", str(tmp_path / f"{name}.yaml"))]
    client.start(SCRIPT, "--ros-args", *files, "-p", "echo:gain:=7", "-p", "other:gain:=nonsense", "--", "-p", "user")
    Link(client).until_answer(26.0)


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_node_exits_cleanly_on_a_signal(how: signal.Signals, echo: subprocess.Popen[str], client: DdsClient) -> None:
    client.until(lambda: client.node.count_publishers("front_left/slip") == 1)
    output = stop(echo, how)
    assert echo.returncode == 0
    assert "Traceback" not in output


def ends_with(client: DdsClient, *arguments: str) -> str:
    """Start the node with arguments that must end it; return its output, one line."""
    process = client.start(SCRIPT, "--ros-args", *arguments)
    output = output_of(process)
    assert process.returncode == 2, output
    lines = [line for line in output.splitlines() if "] [rcl]: " not in line]
    assert len(lines) == 1, output
    assert lines[0].startswith("error: ")
    return lines[0].removeprefix("error: ")


@pytest.mark.parametrize(
    ("argument", "text"),
    [
        ("gain:=11.0", "parameter 'gain' = 11.0 is outside [0.0, 10.0]"),
        ("gain:=nonsense", "parameter 'gain' = 'nonsense' must be of type float"),
        ("gian:=1.0", "node /echo: unknown parameter 'gian': known are vehicle_file, gain, "),
        ("offset:=1.0", "node /echo: unknown parameter 'offset', perhaps filter.offset: known are "),
        ("filter.weights:=[1, two]", "parameter 'filter.weights' = 'two' must be of type float"),
        ("filter.weights:=[1", "-p filter.weights:=[1: line 1: not YAML: "),
        ("filter.weights:=[]", "parameter 'filter.weights' is empty"),
        ("gain", "-p gain: it must be name:=value"),
        ("gain:=", "parameter 'gain' = None must be of type float"),
        ("use_sim_time:=maybe", "parameter 'use_sim_time' = 'maybe' has the wrong type"),
        ("vehicle_file:=", "parameter 'vehicle_file' = None must be of type str"),
        ("vehicle_file:=''", "no vehicle file is given ('vehicle_file'): give a path, or one of those shipped: "),
        ("vehicle_file:=/no/car.yaml", "there is no vehicle file '/no/car.yaml': "),
    ],
)
def test_a_bad_parameter_at_start_ends_the_process_and_is_named(argument: str, text: str, client: DdsClient) -> None:
    assert ends_with(client, "-p", argument).startswith(text)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (("--no-such-argument",), "no-such-argument"),
        (("--params-file",), "--params-file"),
        (("-r", "__node:=a-b"), "'a-b' is not a valid node name"),
        (("-r", "__ns:=/my_car/"), "'/my_car/' is not a valid namespace"),
        (("-r", "__ns:=my_car"), "'my_car' is not a valid namespace"),
        (("-r", "nonsense"), "nonsense"),
    ],
)
def test_arguments_that_ros_refuses_end_the_process_in_one_line(
    arguments: tuple[str, ...], text: str, client: DdsClient
) -> None:
    assert text in ends_with(client, *arguments)


@pytest.mark.parametrize(
    ("content", "text"),
    [
        ("echo: {ros__parameters: {gain: 11}}", "line 1: parameter 'gain' = 11.0 is outside [0.0, 10.0]"),
        ("echo: {ros__parameters: {gain: 1}}\necho: {ros__parameters: {}}", "line 2: 'echo' is repeated here"),
        ("/**/ecko: {ros__parameters: {}}\n/**/echos: {ros__parameters: {}}", "line 2: section '/**/echos'"),
        ("/**: {ros__parameters: {use_sim_time: 3}}", "line 1: parameter 'use_sim_time' = 3 has the wrong type"),
        ("echo: [", "line 1: not YAML"),
    ],
)
def test_a_bad_file_ends_the_process_and_its_line_is_named(
    content: str, text: str, client: DdsClient, tmp_path: Path
) -> None:
    file = tmp_path / "p.yaml"
    file.write_text(content)
    assert ends_with(client, "--params-file", str(file)).startswith(f"{file}: {text}")


def test_a_section_for_the_root_is_refused_in_a_namespace(client: DdsClient, tmp_path: Path) -> None:
    file = tmp_path / "p.yaml"
    file.write_text("echo: {ros__parameters: {gain: 1}}")
    text = ends_with(client, "-r", "__ns:=/my_car", "--params-file", str(file))
    assert text == (
        f"{file}: line 1: section '/echo' is not for the node /my_car/echo: name it '/**/echo' or '/my_car/echo'"
    )


def test_a_missing_file_ends_the_process(client: DdsClient, tmp_path: Path) -> None:
    missing = tmp_path / "missing.yaml"
    text = ends_with(client, "--params-file", str(missing))
    assert text == f"parameter file {missing}: No such file or directory"


TAKE_DOWN = """
import os, sys, time
import rclpy
from rclpy.experimental.events_executor import EventsExecutor
from friction_runtime.spin import take_down
rclpy.init()
executor, node = EventsExecutor(), rclpy.create_node("short_lived")
executor.add_node(node)
executor.spin_once(timeout_sec=0.1)
if "stuck" in sys.argv:
    node.destroy_node = lambda: time.sleep(600.0)
take_down(node, executor)
threads = [open(f"/proc/self/task/{task}/comm").read() for task in os.listdir("/proc/self/task")]
print("left:", [name for name in threads if name.startswith(("dds.ev", "dds.udp"))])
"""


def test_nothing_of_the_middleware_is_left_once_a_node_is_taken_down() -> None:
    done = subprocess.run([sys.executable, "-c", TAKE_DOWN], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "left: []\n"), done.stderr


def test_a_middleware_that_hangs_while_it_is_taken_down_is_said_and_left() -> None:
    command = [sys.executable, "-c", TAKE_DOWN, "stuck"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "take_down" in done.stderr
    assert done.stdout == ""
