"""The node as a real process over DDS: commands on the wire, fail-safe on silence, brakings logged, clean end."""

import time

import pytest
from friction_msgs.msg import BrakeCommand, BrakeDemand, SlopeVote, SupervisorState, Validity, WheelSlip
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from rclpy.qos import ReliabilityPolicy
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Header
from std_srvs.srv import Trigger

from friction_runtime import qos
from friction_runtime.messages import from_nanoseconds
from friction_test_support.dds_client import DdsClient, dds_client, output_of, stop
from vehicle_models.vehicle_file import shipped_vehicles

CAR = ("-p", "vehicle_file:=chapter_corner")
STEP = 5_000_000
PRESSURE = 5e6
DIVED = 60
"""Samples until the wheel has dived."""
SPEED, SLIP = 20.0, 0.4
"""Of the car [m/s], and of its braked wheel: beyond every peak."""


class Inputs:
    """Publishers of what the supervisor of a wheel beyond the peak takes."""

    def __init__(self, client: DdsClient) -> None:
        kinds = {
            "wheel_states": JointState,
            "brake_demand": BrakeDemand,
            "front_left/brake_pressure": FluidPressure,
            "front_left/slip": WheelSlip,
            "front_left/slope_vote": SlopeVote,
        }
        self._publishers = {topic: qos.publish(client.node, kind, topic) for topic, kind in kinds.items()}
        client.until(lambda: all(each.get_subscription_count() == 1 for each in self._publishers.values()))

    def send(self, sample: int, indicator: float, share: float = 1.0) -> None:
        header = Header(stamp=from_nanoseconds(sample * STEP))
        rolling = SPEED * (1.0 - share * SLIP) / 0.3
        slip = WheelSlip(
            header=header, slip=share * SLIP, slip_stddev=0.00316, vehicle_speed=SPEED, validity=Validity(valid=True)
        )
        for topic, message in {
            # A sensor that works never reads the same twice.
            "wheel_states": JointState(header=header, name=["front_left"], velocity=[rolling + 1e-3 * (sample % 2)]),
            "brake_demand": BrakeDemand(header=header, pressure=PRESSURE),
            "front_left/brake_pressure": FluidPressure(header=header, fluid_pressure=PRESSURE),
            "front_left/slip": slip,
            "front_left/slope_vote": SlopeVote(
                header=header, h=indicator, indicator=indicator, validity=Validity(valid=True)
            ),
        }.items():
            self._publishers[topic].publish(message)


def test_node_commands_a_release_and_falls_back_when_the_votes_go_silent() -> None:
    states: list[SupervisorState] = []
    commands: list[BrakeCommand] = []
    arrived: list[float] = []
    stale_after = 3.0  # longer than a busy machine lets this process wait between two samples
    with dds_client() as client:
        arguments = (*CAR, "-p", "shadow:=false", "-p", "real_time:=false", "-p", f"stale_after:={stale_after}")
        process = client.start("-m", "abs_supervisor", "--ros-args", *arguments)
        qos.subscribe(client.node, SupervisorState, "front_left/abs_supervisor", states.append, qos.ESTIMATE)

        def on_command(message: BrakeCommand) -> None:
            commands.append(message)
            arrived.append(time.monotonic())

        qos.subscribe(client.node, BrakeCommand, "front_left/brake_command", on_command, qos.ESTIMATE)
        inputs = Inputs(client)
        client.until(lambda: client.node.count_publishers("front_left/brake_command") == 1)
        client.until_known_to("abs_supervisor")
        for k in range(1, DIVED + 11):
            last = time.monotonic()
            # It rolls, and dives: a wheel that does not fall is not released.
            inputs.send(k, 500.0 if k < DIVED + 6 else -5000.0, min(max(k - DIVED + 20, 0) / 15, 1.0))
            if k == DIVED + 8:
                refused = client.call(Trigger, "/abs_supervisor/reset", Trigger.Request())
        client.until(lambda: len(commands) >= DIVED + 11)
        client.until(lambda: len(states) >= DIVED + 11)
        output = stop(process)
    increase, decrease, none = BrakeCommand.INCREASE, BrakeCommand.DECREASE, BrakeCommand.NONE
    given = [message.command for message in commands]
    assert given[: DIVED - 20] == [increase] * (DIVED - 20)
    assert given[DIVED + 5 :] == [decrease] * 5 + [none]
    assert decrease not in given[: DIVED + 5]
    assert not refused.success, "in the middle of a braking nothing is forgotten"
    assert commands[-1].header.stamp == commands[-2].header.stamp
    assert arrived[-1] - last >= stale_after - 0.02
    assert states[-1].cause == SupervisorState.CAUSE_FAIL_SAFE
    for text in ("releases: 1, last cause: fail_safe", "front_left/slope_vote: no message for"):
        assert text in output
    assert "S1 -> S21" not in output, "transitions are for debugging"
    assert process.returncode == 0


def text(name: str, value: str) -> Parameter:
    return Parameter(name=name, value=ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=value))


def test_node_commands_nothing_unless_started_to_do_so() -> None:
    with dds_client() as client:
        process = client.start("-m", "abs_supervisor", "--ros-args", *CAR)
        client.until(lambda: client.node.count_publishers("front_left/abs_supervisor") == 1)
        assert client.node.count_publishers("front_left/brake_command") == 0
        false = ParameterValue(type=ParameterType.PARAMETER_BOOL, bool_value=False)
        request = SetParameters.Request(parameters=[Parameter(name="shadow", value=false)])
        answer = client.call(SetParameters, "/abs_supervisor/set_parameters", request)
        assert [result.successful for result in answer.results] == [False]
        # What a brake's safety hangs on is read at the start.
        wait = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=0.04)
        for name in ("tolerance", "actuator.delay", "deadline", "thresholds.wait"):
            request = SetParameters.Request(parameters=[Parameter(name=name, value=wait)])
            answer = client.call(SetParameters, "/abs_supervisor/set_parameters", request)
            assert [result.successful for result in answer.results] == [False]
        assert client.node.count_publishers("front_left/brake_command") == 0
        output = stop(process)
    assert process.returncode == 0
    assert "Traceback" not in output


@pytest.mark.parametrize(
    ("shadow", "real_time", "asked"),
    [
        ("false", "true", ReliabilityPolicy.BEST_EFFORT),
        ("false", "false", ReliabilityPolicy.RELIABLE),
        ("true", "true", ReliabilityPolicy.RELIABLE),
    ],
)
def test_only_a_node_that_commands_by_the_clock_gives_up_what_is_late(
    shadow: str, real_time: str, asked: ReliabilityPolicy
) -> None:
    estimates = ("brake_demand", "front_left/slope_vote", "front_left/slip", "front_left/friction_curve")
    with dds_client() as client:
        arguments = (*CAR, "-p", f"shadow:={shadow}", "-p", f"real_time:={real_time}")
        client.start("-m", "abs_supervisor", "--ros-args", *arguments)
        client.until(lambda: all(client.node.count_subscribers(topic) == 1 for topic in estimates))
        found = [client.node.get_subscriptions_info_by_topic(topic)[0] for topic in estimates]
    assert [each.qos_profile.reliability for each in found] == [asked] * len(estimates)


def test_node_without_a_car_ends_and_names_the_shipped_ones() -> None:
    with dds_client() as client:
        process = client.start("-m", "abs_supervisor")
        output = output_of(process)
    assert process.returncode == 2
    (line,) = output.splitlines()
    assert line.startswith("error: ")
    assert all(name in line for name in shipped_vehicles())
