"""The node as a real process over DDS."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from friction_msgs.msg import FrictionCurve, WheelSlip
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Header
from std_srvs.srv import Trigger

from dds_client import DdsClient, dds_client, stop
from friction_runtime import qos
from friction_runtime.stamps import NANOSECONDS, from_nanoseconds

Brake = Callable[..., Any]


@pytest.fixture
def client() -> Iterator[DdsClient]:
    with dds_client(60) as made:
        yield made


def test_node_identifies_two_wheels_and_begins_anew_on_reset(client: DdsClient, clean: Brake) -> None:
    wheels = ("front_left", "rear_left")
    process = client.start(
        "-m", "friction_curve_id", "--ros-args", "-p", f"wheels:=[{', '.join(wheels)}]", "-p", "method:=rls"
    )
    received: list[FrictionCurve] = []
    for wheel in wheels:
        qos.subscribe(client.node, FrictionCurve, f"{wheel}/friction_curve", received.append, qos.ESTIMATE)
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
            slip.publish(WheelSlip(header=header, vehicle_speed=30.0, valid=True))
        states.publish(JointState(header=header, name=list(wheels), velocity=[100.0] * 2))
        last = {message.wheel: message.reason for message in received}
        missing = {FrictionCurve.NO_TORQUE, FrictionCurve.NO_SLIP}
        return set(last) == set(wheels) and missing.isdisjoint(last.values())

    client.until(hears_every_input)
    assert client.call(Trigger, "/friction_curve_id/reset", Trigger.Request()).success

    def brake(name: str, start: int) -> list[FrictionCurve]:
        def answers() -> list[FrictionCurve]:
            return [message for message in received if message.header.stamp.sec >= start]

        received.clear()
        for count, sample in enumerate(clean(name).samples, 1):
            header = Header(stamp=from_nanoseconds(start * NANOSECONDS + round(sample.time * NANOSECONDS)))
            states.publish(JointState(header=header, name=list(wheels), velocity=[sample.wheel_speed] * 2))
            for pressure, slip in zip(pressures, slips, strict=True):
                pressure.publish(FluidPressure(header=header, fluid_pressure=sample.brake_torque / 1e-4))
                slip.publish(WheelSlip(header=header, vehicle_speed=sample.vehicle_speed, valid=True))

            # One sample at a time: the test must not outrun best-effort queues on a busy machine.
            def answered(expected: int = 2 * count) -> bool:
                return len(answers()) >= expected

            client.until(answered)
        return answers()

    for name, start, mu_max in (("wet", 100, 0.804), ("dry", 200, 1.170)):
        found = brake(name, start)
        assert {message.wheel for message in found} == set(wheels)
        for message in found[-2:]:
            assert message.valid, message.reason_text
            assert message.mu_max == pytest.approx(mu_max, rel=0.02)
        assert client.call(Trigger, "/friction_curve_id/reset", Trigger.Request()).success
    causes = {message.restart_cause for message in found if message.restarted}
    assert causes == {FrictionCurve.RESTART_REQUEST}
    output, seconds = stop(process)
    assert process.returncode == 0, output
    assert seconds < 5.0


@pytest.mark.parametrize(("argument", "named"), [("method:=magic", "method"), ("radii:=[-1.0]", "radii")])
def test_node_refuses_a_bad_parameter_at_start(client: DdsClient, argument: str, named: str) -> None:
    process = client.start("-m", "friction_curve_id", "--ros-args", "-p", argument)
    output, _ = process.communicate(timeout=60)
    assert process.returncode != 0
    assert named in output
