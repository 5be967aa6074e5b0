"""The live node over DDS: blocks in, patches and forces out, services, bad parameters."""

from array import array
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from friction_msgs.msg import ContactPatch, TyreForce, TyreSignals
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from std_msgs.msg import Header
from std_srvs.srv import Trigger

from friction_runtime import qos
from friction_runtime.messages import from_nanoseconds
from friction_runtime.processor import Level
from friction_test_support.dds_client import dds_client, output_of, stop
from vehicle_models.reason import Reason

CAR = ("--ros-args", "-p", "vehicle_file:=smart_tyre_car")


def test_node_turns_blocks_into_patches_and_serves_new_zeros(simulate: Any) -> None:
    block = simulate(10.0, seconds=14.0)
    patches: list[ContactPatch] = []
    forces: list[TyreForce] = []
    with dds_client() as client:
        process = client.start("-m", "smart_tyre_forces", *CAR)
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
        client.until_known_to("smart_tyre_forces")
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
        client.until(lambda: bool(patches) and patches[-1].validity.reason == Reason.NOT_CALIBRATED)
        client.until(lambda: len(forces) == len(patches))
        assert forces[-1].validity.reason == Reason.NOT_CALIBRATED
        for name in ("zero_shift", "zero_length", "reset"):
            assert client.call(Trigger, f"/smart_tyre_forces/{name}", Trigger.Request()).success
        output = stop(process)
        assert process.returncode == 0, output


def test_node_refuses_a_missing_calibration_file_at_start() -> None:
    with dds_client() as client:
        process = client.start("-m", "smart_tyre_forces", *CAR, "-p", "calibration_file:=/nowhere.yaml")
        output = output_of(process)
        assert process.returncode == 2
        assert "calibration_file" in output


def test_node_is_quiet_without_tyre_signals_and_takes_a_wrench_while_it_runs() -> None:
    told: list[DiagnosticArray] = []
    with dds_client() as client:
        process = client.start("-m", "smart_tyre_forces", *CAR)
        client.node.create_subscription(DiagnosticArray, "/diagnostics", told.append, 10)
        client.until(lambda: len(told) >= 2)
        levels = {(each.name.split(": ")[1], each.level, each.message) for array in told for each in array.status}
        wheels = ("front_left", "front_right", "rear_left", "rear_right")
        ok = bytes([Level.OK])
        assert levels == {*((wheel, ok, "no tyre signals") for wheel in wheels), ("inputs", ok, "ok")}

        assert client.node.count_publishers("front_left/tyre_wrench") == 0
        wanted = ParameterValue(type=ParameterType.PARAMETER_BOOL, bool_value=True)
        request = SetParameters.Request(parameters=[Parameter(name="publish_wrench", value=wanted)])
        assert client.call(SetParameters, "/smart_tyre_forces/set_parameters", request).results[0].successful
        client.until(lambda: client.node.count_publishers("front_left/tyre_wrench") == 1)
        output = stop(process)
    assert output == ""
    assert process.returncode == 0


def test_signals_that_end_are_an_error_and_a_warning_of_the_inputs() -> None:
    told: list[DiagnosticArray] = []
    with dds_client() as client:
        process = client.start("-m", "smart_tyre_forces", *CAR)
        client.node.create_subscription(DiagnosticArray, "/diagnostics", told.append, 10)
        publisher = qos.publish(client.node, TyreSignals, "front_left/tyre_signals")
        client.until(lambda: publisher.get_subscription_count() == 1)
        client.until_known_to("smart_tyre_forces")
        publisher.publish(
            TyreSignals(
                header=Header(stamp=from_nanoseconds(1_000_000_000)),
                wheel="front_left",
                sample_rate=1e4,
                encoder_voltage=array("f", [0.0] * 50),
                radial_acceleration=array("f", [0.0] * 50),
            )
        )

        def faults() -> dict[str, str]:
            return {each.name.split(": ")[1]: each.message for each in told[-1].status if each.level > bytes([0])}

        client.until(lambda: bool(told) and "inputs" in faults())
        assert set(faults()) == {"front_left", "inputs"}
        assert "front_left/tyre_signals: no message for" in faults()["front_left"]
        assert faults()["inputs"].endswith(" on front_left/tyre_signals")
        stop(process)
