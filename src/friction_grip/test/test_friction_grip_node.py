"""The node as a real process over DDS: a valid word on friction, and a clean end."""

from friction_msgs.msg import Grip
from sensor_msgs.msg import Imu, JointState

from friction_runtime import qos
from friction_runtime.messages import header_at
from friction_test_support.dds_client import dds_client, stop
from vehicle_models.vehicle_file import load_vehicle

CAR = load_vehicle("compact_car")
STEP = 5_000_000


def test_node_has_a_valid_word_from_wheels_and_accelerometer_alone_and_ends_cleanly() -> None:
    received: list[Grip] = []
    with dds_client() as client:
        process = client.start("-m", "friction_grip", "--ros-args", "-p", "vehicle_file:=compact_car")
        states = qos.publish(client.node, JointState, "wheel_states")
        accelerations = qos.publish(client.node, Imu, "imu/data")
        qos.subscribe(client.node, Grip, "grip", received.append, qos.ESTIMATE)
        client.until(lambda: all(each.get_subscription_count() == 1 for each in (states, accelerations)))
        client.until(lambda: client.node.count_publishers("grip") == 1)
        client.until_known_to("friction_grip")
        k = 0

        def answered() -> bool:
            nonlocal k
            k += 1
            imu = Imu(header=header_at(k * STEP, ""))
            imu.linear_acceleration.x = -3.0
            accelerations.publish(imu)
            velocity = [10.0 / radius for radius in CAR.radii]
            states.publish(JointState(header=header_at(k * STEP, ""), name=list(CAR.joints), velocity=velocity))
            client.executor.spin_once(timeout_sec=0.1)
            return any(message.validity.valid and message.mu_proven > 0.2 for message in received)

        client.until(answered)
        output = stop(process)
    assert process.returncode == 0, output
