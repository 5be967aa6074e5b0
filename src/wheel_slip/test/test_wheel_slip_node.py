"""The node as a real process over DDS: its messages are those of the processor; bad parameters are refused."""

from functools import partial
from pathlib import Path

import pytest
from friction_msgs.msg import WheelSlip
from geometry_msgs.msg import TwistWithCovarianceStamped
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from sensor_msgs.msg import Imu, JointState
from std_srvs.srv import Trigger

from friction_parameters.parameter_file import load
from friction_runtime import qos
from friction_runtime.messages import from_nanoseconds
from friction_test_support.dds_client import dds_client, output_of, stop
from vehicle_models.vehicle_file import load_vehicle
from wheel_slip.parameters import WheelSlipParameters
from wheel_slip.ros.processor import CarProcessor

CONFIG = Path(__file__).parents[1] / "config" / "wheel_slip.yaml"
CAR = "chapter_corner"
SLIP = "front_left/slip"


def sample(k: int) -> dict[str, JointState | Imu | TwistWithCovarianceStamped]:
    stamp = from_nanoseconds(k * 5_000_000)
    wheels, imu, speed = JointState(name=["front_left"], velocity=[60.0 - 0.1 * k]), Imu(), TwistWithCovarianceStamped()
    imu.linear_acceleration.x = -2.0
    speed.twist.twist.linear.x = 20.0 - 0.01 * k
    speed.twist.covariance[0] = 0.01
    for message in (wheels, imu, speed):
        message.header.stamp = stamp
    return {"vehicle_velocity": speed, "imu/data": imu, "wheel_states": wheels}


def answered(received: list[WheelSlip], k: int) -> bool:
    return len(received) >= k


def test_node_says_what_the_processor_says_and_ends_cleanly() -> None:
    processor = CarProcessor(load_vehicle(CAR), load(WheelSlipParameters, CONFIG, "wheel_slip"))
    expected = [
        out
        for k in range(1, 61)
        for topic, message in sample(k).items()
        for name, out in processor.process(topic, message)
        if name == SLIP
    ]
    received: list[WheelSlip] = []
    with dds_client() as client:
        given = ("--params-file", str(CONFIG), "-p", f"vehicle_file:={CAR}")
        process = client.start("-m", "wheel_slip", "--ros-args", *given)
        publishers = {topic: qos.publish(client.node, type(message), topic) for topic, message in sample(1).items()}
        qos.subscribe(client.node, WheelSlip, SLIP, received.append, qos.ESTIMATE)
        client.until(lambda: all(publisher.get_subscription_count() == 1 for publisher in publishers.values()))
        client.until(lambda: client.node.count_publishers(SLIP) == 1)
        assert client.call(Trigger, "/wheel_slip/reset", Trigger.Request()).success
        for k in range(1, 61):
            for topic, message in sample(k).items():
                publishers[topic].publish(message)
            # A sample is answered before the next is sent: nothing is lost to a full queue.
            client.until(partial(answered, received, k))
        output = stop(process)
    assert repr(received) == repr(expected)
    assert received[-1].validity.valid
    assert process.returncode == 0
    assert "Traceback" not in output


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (("vehicle_file:=chapter_corner", "deadline:=0.0"), "deadline"),
        (("vehicle_file:=chapter_corner", "radii:=[0.3]"), "unknown parameter 'radii'"),
        (("use_imu:=true",), "chapter_corner"),
    ],
    ids=["bad value", "unknown name", "no car"],
)
def test_node_refuses_bad_parameters_at_start(given: tuple[str, ...], said: str) -> None:
    with dds_client() as client:
        arguments = [word for each in given for word in ("-p", each)]
        process = client.start("-m", "wheel_slip", "--ros-args", *arguments)
        output = output_of(process)
    assert process.returncode == 2
    assert said in output


def test_accelerometer_is_left_out_and_taken_again_while_the_node_runs() -> None:
    received: list[WheelSlip] = []
    with dds_client() as client:
        process = client.start("-m", "wheel_slip", "--ros-args", "-p", f"vehicle_file:={CAR}")
        publisher = qos.publish(client.node, JointState, "wheel_states")
        accelerations = qos.publish(client.node, Imu, "imu/data")
        qos.subscribe(client.node, WheelSlip, SLIP, received.append, qos.ESTIMATE)
        client.until(lambda: publisher.get_subscription_count() == accelerations.get_subscription_count() == 1)
        client.until(lambda: client.node.count_publishers(SLIP) == 1)
        client.until_known_to("wheel_slip")

        def sets(use_imu: bool) -> bool:
            wanted = ParameterValue(type=ParameterType.PARAMETER_BOOL, bool_value=use_imu)
            request = SetParameters.Request(parameters=[Parameter(name="use_imu", value=wanted)])
            return bool(client.call(SetParameters, "/wheel_slip/set_parameters", request).results[0].successful)

        def speaks_from_sample(k: int) -> bool:
            publisher.publish(sample(k)["wheel_states"])
            client.executor.spin_once(timeout_sec=0.1)
            return bool(received)

        # A sample of the wheels waits for the accelerometer, which is silent, until others have come for the deadline.
        assert not speaks_from_sample(1)
        assert sets(False)
        client.until(partial(speaks_from_sample, 2))
        assert sets(True)
        received.clear()
        assert not speaks_from_sample(3)

        def speaks_with_acceleration() -> bool:
            accelerations.publish(sample(3)["imu/data"])
            return speaks_from_sample(3)

        client.until(speaks_with_acceleration)
        output = stop(process)
    assert process.returncode == 0, output
