"""The node as a real process over DDS: what it says is what the processor says; bad parameters are refused."""

from functools import partial
from pathlib import Path

from friction_msgs.msg import WheelSlip
from geometry_msgs.msg import TwistWithCovarianceStamped
from sensor_msgs.msg import Imu, JointState
from std_srvs.srv import Trigger

from dds_client import dds_client, stop
from friction_runtime import qos
from friction_runtime.parameters import load
from friction_runtime.stamps import from_nanoseconds
from wheel_slip.parameters import WheelSlipParameters
from wheel_slip.processor import CarProcessor

CONFIG = Path(__file__).parents[1] / "config" / "wheel_slip.yaml"
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
    processor = CarProcessor(load(WheelSlipParameters, CONFIG, "wheel_slip"))
    expected = [
        out
        for k in range(1, 61)
        for topic, message in sample(k).items()
        for _, out in processor.process(topic, message)
    ]
    received: list[WheelSlip] = []
    with dds_client(50) as client:
        process = client.start("-m", "wheel_slip", "--ros-args", "--params-file", str(CONFIG))
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
        output, seconds = stop(process)
    assert repr(received) == repr(expected)
    assert received[-1].valid
    assert process.returncode == 0
    assert "Traceback" not in output
    assert seconds < 5.0


def test_node_refuses_a_bad_parameter_at_start() -> None:
    with dds_client(51) as client:
        process = client.start("-m", "wheel_slip", "--ros-args", "-p", "radii:=[0.0]")
        output, _ = process.communicate(timeout=60)
    assert process.returncode == 2
    assert "radii" in output
