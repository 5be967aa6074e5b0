"""The node as a real process over DDS: commands on the wire, fail-safe on silence, transitions logged, clean end."""

import time

from friction_msgs.msg import BrakeCommand, BrakeDemand, FrictionSlope, SupervisorState
from std_msgs.msg import Header

from dds_client import dds_client, stop
from friction_runtime import qos
from friction_runtime.stamps import from_nanoseconds

STEP = 5_000_000


def test_node_commands_a_release_and_falls_back_when_the_slope_goes_silent() -> None:
    states: list[SupervisorState] = []
    commands: list[BrakeCommand] = []
    arrived: list[float] = []
    stale_after = 1.0
    with dds_client(30) as client:
        arguments = ("-p", "shadow:=false", "-p", f"stale_after:={stale_after}")
        process = client.start("-m", "abs_supervisor", "--ros-args", *arguments)
        demands = qos.publish(client.node, BrakeDemand, "brake_demand")
        slopes = qos.publish(client.node, FrictionSlope, "front_left/friction_slope")
        qos.subscribe(client.node, SupervisorState, "front_left/abs_supervisor", states.append, qos.ESTIMATE)

        def on_command(message: BrakeCommand) -> None:
            commands.append(message)
            arrived.append(time.monotonic())

        qos.subscribe(client.node, BrakeCommand, "front_left/brake_command", on_command, qos.ESTIMATE)
        client.until(lambda: demands.get_subscription_count() == 1 and slopes.get_subscription_count() == 1)
        client.until(lambda: client.node.count_publishers("front_left/brake_command") == 1)
        for k in range(1, 11):
            header = Header(stamp=from_nanoseconds(k * STEP))
            indicator = 500.0 if k < 6 else -5000.0
            demands.publish(BrakeDemand(header=header, pressure=5e6))
            slopes.publish(FrictionSlope(header=header, h=indicator, indicator=indicator, sign=1, valid=True))
            last = time.monotonic()
        client.until(lambda: len(commands) >= 11)
        client.until(lambda: len(states) >= 11)
        output, _ = stop(process)
    increase, decrease, none = BrakeCommand.INCREASE, BrakeCommand.DECREASE, BrakeCommand.NONE
    assert [message.command for message in commands] == [increase] * 5 + [decrease] * 5 + [none]
    assert commands[-1].header.stamp == commands[-2].header.stamp
    assert arrived[-1] - last >= stale_after - 0.02
    assert states[-1].cause == SupervisorState.CAUSE_FAIL_SAFE
    assert states[-1].fail_safes == 1
    for text in ("cause braking", "S1 -> S21", "cause fail_safe", "front_left/friction_slope: silent"):
        assert text in output
    assert process.returncode == 0


def test_node_in_shadow_mode_offers_no_command_topic() -> None:
    with dds_client(31) as client:
        process = client.start("-m", "abs_supervisor")
        client.until(lambda: client.node.count_publishers("front_left/abs_supervisor") == 1)
        assert client.node.count_publishers("front_left/brake_command") == 0
        stop(process)
