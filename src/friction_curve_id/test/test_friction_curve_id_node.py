"""The node as a real process over DDS."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from friction_msgs.msg import FrictionCurve, FrictionCurveDebug, Validity, WheelSlip
from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from sensor_msgs.msg import FluidPressure, Imu, JointState
from std_msgs.msg import Header
from std_srvs.srv import Trigger

from friction_runtime import qos
from friction_runtime.messages import from_nanoseconds
from friction_test_support.dds_client import DdsClient, dds_client, output_of, stop
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.reason import Reason

Brake = Callable[..., Any]

TWO_WHEELS = """
name: two corners
mass: {value: 450.0, stddev: 0.0}
brake_pressure_delay: {value: 0.0, stddev: 0.0}
front_load_share: 0.5
wheelbase: 2.7
centre_of_gravity_height: 0.0
track: 1.5
all_wheels:
  radius: {value: 0.3, stddev: 0.0}
  inertia: {value: 1.0, stddev: 0.0}
  brake_gain: {value: 1.0e-4, stddev: 0.0}
wheels:
  front_left: {axle: front, side: left}
  rear_left: {axle: rear, side: left}
"""


@pytest.fixture
def client() -> Iterator[DdsClient]:
    with dds_client() as made:
        yield made


def start_node(client: DdsClient, *parameters: str) -> Any:
    """Start the node."""
    return client.start(
        "-m", "friction_curve_id", "--ros-args", *(word for each in parameters for word in ("-p", each))
    )


def test_node_identifies_two_wheels_and_begins_again_on_reset(client: DdsClient, clean: Brake, tmp_path: Path) -> None:
    wheels = ("front_left", "rear_left")
    car = tmp_path / "two_wheels.yaml"
    car.write_text(TWO_WHEELS)
    process = start_node(client, f"vehicle_file:={car}", "method:=rls")
    received: list[FrictionCurve] = []
    debug: list[FrictionCurveDebug] = []
    for wheel in wheels:
        qos.subscribe(client.node, FrictionCurve, f"{wheel}/friction_curve", received.append, qos.ESTIMATE)
        qos.subscribe(client.node, FrictionCurveDebug, f"{wheel}/friction_curve_debug", debug.append, qos.ESTIMATE)
    states = qos.publish(client.node, JointState, "wheel_states")
    pressures = [qos.publish(client.node, FluidPressure, f"{wheel}/brake_pressure") for wheel in wheels]
    slips = [qos.publish(client.node, WheelSlip, f"{wheel}/slip") for wheel in wheels]
    client.until(lambda: all(each.get_subscription_count() == 1 for each in (states, *pressures, *slips)))
    client.until(lambda: all(client.node.count_publishers(f"{wheel}/friction_curve") == 1 for wheel in wheels))

    # A publisher counts its reader before the reader counts it: best-effort samples sent in between are lost.
    warm_up = iter(range(1, 10_000))

    def hears_every_input() -> bool:
        header = Header(stamp=from_nanoseconds(NANOSECONDS + next(warm_up) * NANOSECONDS // 100))
        for pressure, slip in zip(pressures, slips, strict=True):
            pressure.publish(FluidPressure(header=header))
            slip.publish(WheelSlip(header=header, vehicle_speed=30.0, validity=Validity(valid=True)))
        states.publish(JointState(header=header, name=list(wheels), velocity=[100.0] * 2))
        last = {message.wheel: message.validity.reason for message in received}
        missing = {Reason.NO_PRESSURE, Reason.NO_SLIP}
        return set(last) == set(wheels) and missing.isdisjoint(last.values())

    client.until(hears_every_input)
    assert client.call(Trigger, "/friction_curve_id/reset", Trigger.Request()).success

    def brake(name: str, start: int) -> list[FrictionCurve]:
        def answers() -> list[FrictionCurve]:
            return [message for message in received if message.header.stamp.sec >= start]

        received.clear()
        debug.clear()
        for count, sample in enumerate(clean(name).samples, 1):
            header = Header(stamp=from_nanoseconds(start * NANOSECONDS + round(sample.time * NANOSECONDS)))
            states.publish(JointState(header=header, name=list(wheels), velocity=[sample.wheel_speed] * 2))
            for pressure, slip in zip(pressures, slips, strict=True):
                pressure.publish(FluidPressure(header=header, fluid_pressure=sample.brake_torque / 1e-4))
                slip.publish(
                    WheelSlip(header=header, vehicle_speed=sample.vehicle_speed, validity=Validity(valid=True))
                )

            # One sample at a time: the test must not outrun best-effort queues on a busy machine.
            def answered(expected: int = 2 * count) -> bool:
                return len(answers()) >= expected

            client.until(answered)
        return answers()

    for name, start, mu_max in (("wet", 100, 0.804), ("dry", 200, 1.170)):
        found = brake(name, start)
        assert {message.wheel for message in found} == set(wheels)
        for message in found[-2:]:
            assert message.validity.valid, message.validity.text
            assert message.mu_max == pytest.approx(mu_max, rel=0.02)
        assert client.call(Trigger, "/friction_curve_id/reset", Trigger.Request()).success
    assert {message.restart_cause for message in debug if message.restarted} == {FrictionCurveDebug.RESTART_REQUEST}
    output = stop(process)
    assert process.returncode == 0, output


def test_method_and_speed_source_change_live_and_the_topics_with_them(client: DdsClient, clean: Brake) -> None:
    process = start_node(client, "vehicle_file:=chapter_corner", "method:=rls")
    received: list[FrictionCurve] = []
    for name in ("front_left", "vehicle"):
        qos.subscribe(client.node, FrictionCurve, f"{name}/friction_curve", received.append, qos.ESTIMATE)
    states = qos.publish(client.node, JointState, "wheel_states")
    pressure = qos.publish(client.node, FluidPressure, "front_left/brake_pressure")
    slip = qos.publish(client.node, WheelSlip, "front_left/slip")
    imu = qos.publish(client.node, Imu, "imu/data")
    now = 100 * NANOSECONDS

    def send(wheel_speed: float, speed: float, torque: float, acceleration: float) -> None:
        """One sample on every topic, whether the method reads it or not."""
        header = Header(stamp=from_nanoseconds(now))
        pressure.publish(FluidPressure(header=header, fluid_pressure=torque / 1e-4))
        slip.publish(WheelSlip(header=header, vehicle_speed=speed, validity=Validity(valid=True)))
        reading = Imu(header=header)
        reading.linear_acceleration.x = acceleration
        imu.publish(reading)
        states.publish(JointState(header=header, name=["front_left"], velocity=[wheel_speed]))

    def hears_every_input(method: str, missing: set[Reason]) -> Callable[[], bool]:
        """Best-effort samples are lost until the node's new readers and the publishers here have found each other."""

        def heard() -> bool:
            nonlocal now
            now += NANOSECONDS // 100
            send(100.0, 30.0, 0.0, 0.0)
            return bool(received) and received[-1].method == method and received[-1].validity.reason not in missing

        return heard

    def brake(method: str) -> FrictionCurve:
        nonlocal now
        silent = {Reason.NO_PRESSURE, Reason.NO_SLIP, Reason.NO_ACCELERATION}
        client.until(hears_every_input(method, silent))
        assert client.call(Trigger, "/friction_curve_id/reset", Trigger.Request()).success
        begin, braked = now + NANOSECONDS, clean("wet")
        received.clear()
        for count, (sample, friction) in enumerate(zip(braked.samples, braked.friction, strict=True), 1):
            now = begin + round(sample.time * NANOSECONDS)
            send(sample.wheel_speed, sample.vehicle_speed, sample.brake_torque, -9.81 * float(friction))

            def answered(expected: int = count) -> bool:
                return sum(message.header.stamp.sec >= begin // NANOSECONDS for message in received) >= expected

            client.until(answered)
        assert {message.method for message in received} == {method}
        return received[-1]

    def set_parameter(name: str, value: Any) -> SetParametersResult:
        request = SetParameters.Request(parameters=[Parameter(name, value=value).to_parameter_msg()])
        return client.call(SetParameters, "/friction_curve_id/set_parameters", request).results[0]

    for method, name in (("rls", "front_left"), ("ml", "front_left"), ("vehicle", "vehicle"), ("rls", "front_left")):
        result = set_parameter("method", method)
        assert result.successful, result.reason
        last = brake(method)
        assert last.wheel == name
        assert last.mu_max == pytest.approx(0.804, rel=0.05)
        if method == "vehicle":
            refused = set_parameter("speed_source", "none")
            assert not refused.successful and "speed_source" in refused.reason
            assert set_parameter("noise.torque_variance", 20.0).successful
    refused = set_parameter("method", "magic")
    assert not refused.successful and "rml_ml" in refused.reason
    assert not set_parameter("vehicle_file", "bmw_m8").successful
    assert set_parameter("speed_source", "none").successful
    output = stop(process)
    assert process.returncode == 0, output
    assert output.count("noise.torque_variance: ignored, as 'method' is 'vehicle'") == 1, output


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (("vehicle_file:=chapter_corner", "method:=magic"), "method"),
        (("vehicle_file:=chapter_corner", "radii:=[0.3]"), "unknown parameter 'radii'"),
        (("method:=rls",), "chapter_corner"),
    ],
)
def test_node_refuses_a_bad_parameter_at_start(client: DdsClient, arguments: tuple[str, ...], named: str) -> None:
    process = start_node(client, *arguments)
    output = output_of(process)
    assert process.returncode != 0
    assert named in output
