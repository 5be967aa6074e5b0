"""The node as a real process over DDS: one message with all wheels for each sample, and a clean end."""

from friction_msgs.msg import FrictionState, Validity, WheelSlip
from sensor_msgs.msg import JointState

from friction_runtime import qos
from friction_runtime.messages import header_at
from friction_test_support.dds_client import dds_client, stop
from vehicle_models.vehicle_file import load_vehicle

WHEELS = load_vehicle("chapter_car").wheel_names
STEP = 5_000_000


def test_node_publishes_all_wheels_of_each_sample_and_ends_cleanly() -> None:
    received: list[FrictionState] = []
    with dds_client() as client:
        process = client.start("-m", "friction_state", "--ros-args", "-p", "vehicle_file:=chapter_car")
        states = qos.publish(client.node, JointState, "wheel_states")
        slips = [qos.publish(client.node, WheelSlip, f"{wheel}/slip") for wheel in WHEELS]
        qos.subscribe(client.node, FrictionState, "friction_state", received.append, qos.ESTIMATE)
        client.until(lambda: all(each.get_subscription_count() == 1 for each in (states, *slips)))
        client.until(lambda: client.node.count_publishers("friction_state") == 1)
        client.until_known_to("friction_state")
        k = 0

        def answered() -> bool:
            nonlocal k
            k += 1
            for wheel, publisher in zip(WHEELS, slips, strict=True):
                slip = WheelSlip(header=header_at(k * STEP, wheel), slip=0.1, validity=Validity(valid=True))
                publisher.publish(slip)
            states.publish(JointState(header=header_at(k * STEP, "")))
            client.executor.spin_once(timeout_sec=0.1)
            return bool(received) and all(wheel.slip_valid for wheel in received[-1].wheels)

        client.until(answered)
        output = stop(process)
    assert [wheel.wheel for wheel in received[-1].wheels] == list(WHEELS)
    assert process.returncode == 0, output
