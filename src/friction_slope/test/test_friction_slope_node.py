"""The node as a real process over DDS: its messages are those of the processor, and it ends cleanly."""

from functools import partial
from pathlib import Path

import pytest
from friction_msgs.msg import FrictionSlope
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Header

from friction_parameters.parameter import changed
from friction_parameters.parameter_file import load
from friction_runtime import qos
from friction_runtime.messages import from_nanoseconds
from friction_slope.parameters import FrictionSlopeParameters
from friction_slope.ros.processor import WheelProcessor
from friction_test_support.dds_client import dds_client, output_of, stop
from vehicle_models.vehicle_file import load_vehicle, shipped_vehicles

CONFIG = Path(__file__).parents[1] / "config" / "friction_slope.yaml"
STEP = 5_000_000
PRESSURE = "front_left/brake_pressure"
SLIP = "front_left/slip"
SLOPE = "front_left/friction_slope"


def sample(k: int) -> tuple[FluidPressure, JointState]:
    header = Header(stamp=from_nanoseconds(k * STEP))
    time = 0.005 * k
    return (
        FluidPressure(header=header, fluid_pressure=(200.0 + 1000.0 * time) / 1e-4),
        JointState(header=header, name=["front_left"], velocity=[95.0 - 40.0 * time - 300.0 * time**2]),
    )


def test_node_says_what_the_processor_says_and_ends_cleanly() -> None:
    alone = {"method": "no_slip", "no_slip.slip_at_crossing": False}
    parameters = changed(load(FrictionSlopeParameters, CONFIG, "friction_slope"), alone)
    processor = WheelProcessor("front_left", load_vehicle("chapter_corner"), parameters)
    expected: list[FrictionSlope] = []
    for k in range(1, 61):
        pressure, speed = sample(k)
        processor.process(PRESSURE, pressure)
        expected += [message for topic, message in processor.process("wheel_states", speed) if topic == SLOPE]
    received: list[FrictionSlope] = []
    with dds_client() as client:
        arguments = (
            *("--params-file", str(CONFIG)),
            *("-p", "vehicle_file:=chapter_corner", "-p", "method:=no_slip", "-p", "no_slip.slip_at_crossing:=false"),
        )
        process = client.start("-m", "friction_slope", "--ros-args", *arguments)
        pressures = qos.publish(client.node, FluidPressure, PRESSURE)
        speeds = qos.publish(client.node, JointState, "wheel_states")
        qos.subscribe(client.node, FrictionSlope, SLOPE, received.append, qos.ESTIMATE)
        client.until(lambda: pressures.get_subscription_count() == 1 and speeds.get_subscription_count() == 1)
        client.until(lambda: client.node.count_publishers(SLOPE) == 1)
        client.until_known_to("friction_slope")

        def answered(k: int) -> bool:
            """Sensors are best effort: what was lost is sent again, what was not is refused as a repeat."""
            for publisher, message in zip((pressures, speeds), sample(k), strict=True):
                publisher.publish(message)
            client.executor.spin_once(timeout_sec=0.1)
            return len(received) >= k

        for k in range(1, 61):
            client.until(partial(answered, k))
        output = stop(process)
    assert repr(received) == repr(expected)
    assert received[-1].h == pytest.approx(-600.0 + 1000.0, rel=1e-3)
    assert process.returncode == 0
    assert "Traceback" not in output


def test_method_can_be_changed_while_the_node_runs() -> None:
    with dds_client() as client:
        arguments = ("vehicle_file:=chapter_corner", "method:=no_slip", "no_slip.slip_at_crossing:=false")
        process = client.start("-m", "friction_slope", "--ros-args", *(word for a in arguments for word in ("-p", a)))
        client.until(lambda: client.node.count_publishers(SLOPE) == 1)
        assert client.node.count_subscribers(SLIP) == 0
        value = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value="slip")
        request = SetParameters.Request(parameters=[Parameter(name="method", value=value)])
        answer = client.call(SetParameters, "/friction_slope/set_parameters", request)
        assert [result.successful for result in answer.results] == [True]
        client.until(lambda: client.node.count_subscribers(SLIP) == 1)
        output = stop(process)
    assert process.returncode == 0
    assert "Traceback" not in output


def test_node_without_a_car_ends_and_names_the_shipped_ones() -> None:
    with dds_client() as client:
        process = client.start("-m", "friction_slope")
        output = output_of(process)
    assert process.returncode == 2
    (line,) = output.splitlines()
    assert line.startswith("error: ")
    assert all(name in line for name in shipped_vehicles())
