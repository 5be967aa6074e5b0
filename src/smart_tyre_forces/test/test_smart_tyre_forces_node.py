"""The live node over DDS: blocks in, patches and forces out, services, bad parameters."""

from array import array
from typing import Any

from friction_msgs.msg import ContactPatch, TyreForce, TyreSignals
from std_msgs.msg import Header
from std_srvs.srv import Trigger

from dds_client import dds_client, stop
from friction_runtime import qos
from friction_runtime.stamps import from_nanoseconds


def test_node_turns_blocks_into_patches_and_serves_new_zeros(simulate: Any) -> None:
    block = simulate(10.0, seconds=14.0)
    patches: list[ContactPatch] = []
    forces: list[TyreForce] = []
    with dds_client(72) as client:
        process = client.start("-m", "smart_tyre_forces")
        publisher = qos.publish(client.node, TyreSignals, "front_left/tyre_signals")
        qos.subscribe(client.node, ContactPatch, "front_left/contact_patch", patches.append, qos.ESTIMATE)
        qos.subscribe(client.node, TyreForce, "front_left/tyre_force", forces.append, qos.ESTIMATE)
        client.until(
            lambda: (
                publisher.get_subscription_count() == 1
                and client.node.count_publishers("front_left/contact_patch") == 1
                and client.node.count_publishers("front_left/tyre_force") == 1
            )
        )
        for first in range(0, len(block.encoder_voltage), 2000):
            part = slice(first, first + 2000)
            publisher.publish(
                TyreSignals(
                    header=Header(stamp=from_nanoseconds(1_000_000_000 + first * 100_000), frame_id="wheel"),
                    wheel="front_left",
                    sample_rate=1e4,
                    first_sample=first,
                    encoder_voltage=array("f", block.encoder_voltage[part].tobytes()),
                    radial_acceleration=array("f", block.radial_acceleration[part].tobytes()),
                )
            )
            client.executor.spin_once(timeout_sec=0.01)
        client.until(lambda: bool(patches) and patches[-1].reason == ContactPatch.NOT_CALIBRATED)
        client.until(lambda: len(forces) == len(patches))
        assert forces[-1].reason == TyreForce.NOT_CALIBRATED
        for name in ("zero_shift", "zero_length", "reset"):
            assert client.call(Trigger, f"/smart_tyre_forces/{name}", Trigger.Request()).success
        output, seconds = stop(process)
        assert process.returncode == 0, output
        assert seconds < 5.0


def test_node_refuses_a_missing_calibration_file_at_start() -> None:
    with dds_client(73) as client:
        process = client.start("-m", "smart_tyre_forces", "--ros-args", "-p", "calibration_file:=/nowhere.yaml")
        output, _ = process.communicate(timeout=20)
        assert process.returncode == 2
        assert "calibration_file" in output
