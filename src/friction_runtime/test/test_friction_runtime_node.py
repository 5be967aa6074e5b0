"""The shared node as a real process over DDS: moves messages, takes and refuses parameters, resets, exits."""

import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from friction_msgs.msg import BrakeDemand, WheelSlip
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue, SetParametersResult
from rcl_interfaces.srv import DescribeParameters, SetParameters
from std_srvs.srv import Trigger

from dds_client import DdsClient, dds_client, stop
from friction_runtime import qos

SCRIPT = str(Path(__file__).with_name("friction_runtime_echo_node.py"))


@pytest.fixture
def client() -> Iterator[DdsClient]:
    with dds_client(81) as made:
        yield made


@pytest.fixture
def echo(client: DdsClient) -> subprocess.Popen[str]:
    return client.start(SCRIPT)


def set_gain(client: DdsClient, value: float) -> SetParametersResult:
    wanted = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=value)
    request = SetParameters.Request(parameters=[Parameter(name="gain", value=wanted)])
    return client.call(SetParameters, "/echo/set_parameters", request).results[0]


def test_node_moves_messages_takes_parameters_resets_and_reports(
    echo: subprocess.Popen[str], client: DdsClient
) -> None:
    received: list[WheelSlip] = []
    health: list[DiagnosticArray] = []
    publisher = qos.publish(client.node, BrakeDemand, "brake_demand")
    qos.subscribe(client.node, WheelSlip, "front_left/slip", received.append, qos.ESTIMATE)
    client.node.create_subscription(DiagnosticArray, "/diagnostics", health.append, 10)
    client.until(
        lambda: publisher.get_subscription_count() == 1 and client.node.count_publishers("front_left/slip") == 1
    )

    def doubled(expected: float) -> bool:
        publisher.publish(BrakeDemand(pressure=3.0))
        client.executor.spin_once(timeout_sec=0.05)
        return bool(received) and received[-1].slip == expected

    client.until(lambda: doubled(6.0))
    assert set_gain(client, 4.0).successful
    client.until(lambda: doubled(12.0))

    refused = set_gain(client, 11.0)
    assert not refused.successful
    assert "gain" in refused.reason
    client.until(lambda: doubled(12.0))

    described = client.call(DescribeParameters, "/echo/describe_parameters", DescribeParameters.Request(names=["gain"]))
    assert described.descriptors[0].description == "factor"

    assert client.call(Trigger, "/echo/reset", Trigger.Request()).success
    client.until(lambda: bool(health))
    names = {status.name for array in health for status in array.status}
    assert names == {"/echo: echo", "/echo: inputs"}


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_node_exits_cleanly_on_a_signal(how: signal.Signals, echo: subprocess.Popen[str], client: DdsClient) -> None:
    client.until(lambda: client.node.count_publishers("front_left/slip") == 1)
    output, seconds = stop(echo, how)
    assert seconds < 2.0
    assert echo.returncode == 0
    assert "Traceback" not in output


@pytest.mark.parametrize(
    ("argument", "text"),
    [("gain:=11.0", "gain"), ("gain:=nonsense", "gain"), ("gian:=1.0", "unknown parameter 'gian' for node echo")],
)
def test_bad_parameter_at_start_ends_the_process_and_is_named(argument: str, text: str, client: DdsClient) -> None:
    process = client.start(SCRIPT, "--ros-args", "-p", argument)
    output, _ = process.communicate(timeout=30)
    assert process.returncode == 2
    assert text in output
    assert "Traceback" not in output


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
    node.destroy_node = lambda: time.sleep(60.0)
take_down(node, executor)
threads = [open(f"/proc/self/task/{task}/comm").read() for task in os.listdir("/proc/self/task")]
print("left:", [name for name in threads if name.startswith(("dds.ev", "dds.udp"))])
"""


def test_nothing_of_the_middleware_is_left_once_a_node_is_taken_down() -> None:
    done = subprocess.run([sys.executable, "-c", TAKE_DOWN], capture_output=True, text=True, timeout=30, check=False)
    assert (done.returncode, done.stdout) == (0, "left: []\n"), done.stderr


def test_a_middleware_that_hangs_while_it_is_taken_down_is_said_and_left() -> None:
    command = [sys.executable, "-c", TAKE_DOWN, "stuck"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=30, check=False)
    assert done.returncode == 1
    assert "take_down" in done.stderr
    assert done.stdout == ""
