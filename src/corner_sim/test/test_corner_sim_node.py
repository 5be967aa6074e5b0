"""The plant as a real process over DDS."""

import signal
import subprocess
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from friction_msgs.msg import BrakeCommand, WheelSlip
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue, SetParametersResult
from rcl_interfaces.srv import SetParameters
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from corner_sim.parameters import SimParameters
from corner_sim.ros import messages
from corner_sim.ros.simulation import Simulation
from friction_runtime import qos
from friction_runtime.command_checksum import sealed
from friction_runtime.messages import to_nanoseconds
from friction_test_support.dds_client import DdsClient, dds_client, stop
from vehicle_models.vehicle_file import load_vehicle

DEEP = 10_000
"""Samples that queues hold here, those of the plant too: nothing is lost while the machine delays the test."""
EVERYTHING = QoSProfile(depth=DEEP, reliability=ReliabilityPolicy.RELIABLE)
START = 1_000_000_000
PERIOD = 5_000_000
TOPICS = messages.topics(["front_left"], vehicle_velocity=True, brake_demand=True, tyre_signals=False)


@pytest.fixture
def client() -> Iterator[DdsClient]:
    with dds_client() as made:
        yield made


def start(client: DdsClient, **parameters: object) -> subprocess.Popen[str]:
    """Start the node that waits for the client; a parameter is written as on the command line."""
    queues = {f"qos_overrides./{topic}.publisher.depth": DEEP for topic in (*TOPICS, "clock")}
    wanted = {"start_stamp": START, "wait_for_subscribers": 1, "settle_time": 0.2} | queues | parameters
    arguments = [part for name, value in wanted.items() for part in ("-p", f"{name}:={value}")]
    return client.start("-m", "corner_sim", "--ros-args", *arguments)


def start_when_matched(client: DdsClient, **parameters: object) -> subprocess.Popen[str]:
    """Start the node, and its run when every subscription of the client has its publisher: the first sample counts."""
    process = start(client, autostart="false", **parameters)
    client.until(lambda: all(each.get_publisher_count() for each in client.node.subscriptions))
    client.until_known_to("corner_sim")
    assert client.call(Trigger, "/corner_sim/start", Trigger.Request()).success
    return process


def record(client: DdsClient, topics: Sequence[str] = tuple(TOPICS)) -> dict[str, list[Any]]:
    """Collect messages by topic."""
    found: dict[str, list[Any]] = {topic: [] for topic in topics}
    for topic in topics:
        qos.subscribe(client.node, TOPICS[topic], topic, found[topic].append, EVERYTHING)
    return found


def stamps(received: Sequence[Any]) -> list[int]:
    return [to_nanoseconds(message.header.stamp) for message in received]


def supervise(client: DdsClient) -> list[JointState]:
    """Answer each wheel_states as a scripted supervisor, which looks at the measured speed, noise and all."""
    seen: list[JointState] = []
    publisher = qos.publish(client.node, BrakeCommand, "front_left/brake_command")

    def answer(message: JointState) -> None:
        seen.append(message)
        order = BrakeCommand.DECREASE if message.velocity[0] < 60.0 else BrakeCommand.INCREASE
        publisher.publish(
            sealed(
                BrakeCommand(header=message.header, wheel="front_left", command=order, counter=len(seen), valid_for=0.1)
            )
        )

    qos.subscribe(client.node, JointState, "wheel_states", answer, qos.SENSOR)
    return seen


def set_parameter(client: DdsClient, name: str, value: ParameterValue) -> SetParametersResult:
    request = SetParameters.Request(parameters=[Parameter(name=name, value=value)])
    return client.call(SetParameters, "/corner_sim/set_parameters", request).results[0]


def test_every_topic_comes_at_200_hz_with_the_stamps_of_the_schedule(client: DdsClient) -> None:
    found = record(client)
    published: list[int] = []

    def note(message: Clock, info: dict[str, int]) -> None:
        published.append(info["source_timestamp"])

    client.node.create_subscription(Clock, "/clock", note, EVERYTHING)
    process = start_when_matched(client, end_time=2.0, exit_when_done="true", publish_clock="true")
    client.until(lambda: all(len(received) >= 401 for received in found.values()))
    for topic, received in found.items():
        assert stamps(received) == [START + k * PERIOD for k in range(401)], topic
    client.until(lambda: len(published) >= 401)
    # 2 s of message time take 2 s, less what the first sample was late (0.5 s at most); a busy machine may take longer
    assert published[-1] - published[0] > 1.5e9
    client.until(lambda: process.poll() is not None)
    assert process.returncode == 0


def test_what_goes_over_dds_is_the_simulation_bit_for_bit(client: DdsClient) -> None:
    found = record(client)
    run = {"end_time": 1.0, "seed": 5, "demand_start": 0.2, "exit_when_done": "true"}
    start_when_matched(client, vehicle_file="chapter_corner", **run)
    client.until(lambda: all(len(received) >= 201 for received in found.values()))
    simulation = Simulation(SimParameters(seed=5, demand_start=0.2), load_vehicle("chapter_corner"), START)
    for k in range(201):
        for topic, message in simulation.messages():
            assert repr(found[topic][k]) == repr(message), (topic, k)
        simulation.advance()


RECORDED = ("wheel_states", "imu/data", "front_left/brake_pressure", "truth/front_left/slip")


def closed_loop() -> tuple[dict[str, list[Any]], subprocess.Popen[str]]:
    """Messages of one lock-step run with a supervisor of its own."""
    with dds_client() as client:
        found = record(client, RECORDED)
        supervise(client)
        process = start(
            client, lock_step="true", real_time_factor=0.0, wait_for_subscribers=2, end_time=1.5,
            exit_when_done="true", demand_start=0.1, lock_step_timeout=60.0,
        )  # fmt: skip
        client.until(lambda: all(len(received) >= 301 for received in found.values()))
        client.until(lambda: process.poll() is not None)
        return found, process


def test_a_lock_step_closed_loop_over_dds_repeats_bit_for_bit() -> None:
    (first, process), (second, _) = closed_loop(), closed_loop()
    assert process.returncode == 0
    for topic in RECORDED:
        assert len(first[topic]) == 301
        assert repr(first[topic]) == repr(second[topic]), topic
    slips = [message.slip for message in first["truth/front_left/slip"]]
    assert max(slips) > 0.3
    assert slips[-1] < max(slips)  # the commands were obeyed


def test_lock_step_names_the_wheel_that_is_silent_and_holds_still(client: DdsClient) -> None:
    found = record(client, ["wheel_states"])
    qos.publish(client.node, BrakeCommand, "front_left/brake_command")
    process = start_when_matched(client, lock_step="true", lock_step_timeout=2.0, exit_when_done="true")
    client.until(lambda: process.poll() is not None)
    assert process.stdout is not None
    assert f"no brake_command with stamp {START} ns within 2.0 s from front_left" in process.stdout.read()
    assert process.returncode == 1
    assert stamps(found["wheel_states"]) == [START]


def test_a_missing_supervisor_is_named_before_the_start(client: DdsClient) -> None:
    process = start(client, lock_step="true", lock_step_timeout=0.5, exit_when_done="true", wait_for_subscribers=0)
    client.until(lambda: process.poll() is not None)
    assert process.stdout is not None
    assert "front_left/brake_command" in process.stdout.read()
    assert process.returncode == 1


def test_reset_rewinds_stamps_and_noise_and_takes_changed_parameters(client: DdsClient) -> None:
    found = record(client, ["wheel_states", "truth/front_left/friction_curve"])
    wheel_states, curves = found["wheel_states"], found["truth/front_left/friction_curve"]
    start(client)
    client.until(lambda: len(wheel_states) > 50)
    snow = ParameterValue(type=ParameterType.PARAMETER_STRING_ARRAY, string_array_value=["snow"])
    assert set_parameter(client, "surfaces", snow).successful
    assert client.call(Trigger, "/corner_sim/reset", Trigger.Request()).success
    client.until(lambda: stamps(wheel_states).count(START) == 2)
    jump = stamps(wheel_states).index(START, 1)
    client.until(lambda: len(wheel_states) > jump + 50 and len(curves) > jump + 50)
    assert stamps(wheel_states[jump : jump + 50]) == stamps(wheel_states[:50])
    assert wheel_states[jump].velocity == wheel_states[0].velocity
    thetas = {stamp: curve.theta_2 for stamp, curve in zip(stamps(curves), curves, strict=True) if stamp == START}
    assert thetas[START] == 94.13


def test_start_waits_for_its_service(client: DdsClient) -> None:
    found = record(client, ["wheel_states"])
    start(client, autostart="false")
    client.until(lambda: client.node.count_publishers("wheel_states") == 1)
    client.until_known_to("corner_sim")
    assert found["wheel_states"] == []
    assert client.call(Trigger, "/corner_sim/start", Trigger.Request()).success
    client.until(lambda: len(found["wheel_states"]) > 5)
    assert not client.call(Trigger, "/corner_sim/start", Trigger.Request()).success
    assert stamps(found["wheel_states"])[0] == START
    assert client.call(Trigger, "/corner_sim/reset", Trigger.Request()).success
    assert stamps(found["wheel_states"]).count(START) == 1
    assert client.call(Trigger, "/corner_sim/start", Trigger.Request()).success  # it waited for its service again
    client.until(lambda: stamps(found["wheel_states"]).count(START) == 2)


def test_a_start_by_its_service_waits_for_subscribers_and_loses_no_sample(client: DdsClient) -> None:
    start(client, autostart="false", wait_for_subscribers=2, settle_time=2.0)
    answer = client.call(Trigger, "/corner_sim/start", Trigger.Request())
    assert answer.success
    assert "2 of 2 wheel_states subscribers" in answer.message
    founds = [record(client, ["wheel_states"])["wheel_states"] for _ in range(2)]
    client.until(lambda: all(founds))
    assert [stamps(found)[0] for found in founds] == [START, START]


def test_a_bad_value_is_refused_live_by_name_and_the_plant_goes_on(client: DdsClient) -> None:
    found = record(client, ["wheel_states"])
    start(client)
    client.until(lambda: len(found["wheel_states"]) > 5)
    for name, value in {
        "initial_speed": ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=-1.0),
        "actuator.apply_rate": ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=0.0),
        "surfaces": ParameterValue(type=ParameterType.PARAMETER_STRING_ARRAY, string_array_value=["ice"]),
        "surface_distances": ParameterValue(type=ParameterType.PARAMETER_DOUBLE_ARRAY, double_array_value=[0.0, 1.0]),
        "vehicle_file": ParameterValue(type=ParameterType.PARAMETER_STRING, string_value="chapter_car"),
    }.items():
        result = set_parameter(client, name, value)
        assert not result.successful
        assert name in result.reason
    count = len(found["wheel_states"])
    client.until(lambda: len(found["wheel_states"]) > count + 5)


@pytest.mark.parametrize(
    "given",
    [
        {"initial_speed": -1.0},
        {"surfaces": "[ice]"},
        {"surface_distances": "[0.0, 1.0]"},
        {"real_time_factor": 0.0},
        {"mass": 300.0},
        {"model": "car"},
    ],
)
def test_a_bad_value_at_start_ends_the_process_with_the_name(client: DdsClient, given: dict[str, object]) -> None:
    process = start(client, **given)
    client.until(lambda: process.poll() is not None)
    assert process.returncode == 2
    assert process.stdout is not None
    output = process.stdout.read()
    assert next(iter(given)) in output
    assert "Traceback" not in output


def test_an_unknown_vehicle_ends_the_process_with_those_that_are_shipped(client: DdsClient) -> None:
    process = start(client, vehicle_file="chapter_croner")
    client.until(lambda: process.poll() is not None)
    assert process.returncode == 2
    assert process.stdout is not None
    output = process.stdout.read()
    assert "'chapter_croner'" in output
    assert "chapter_corner, compact_car" in output
    assert "Traceback" not in output


def test_topics_bear_the_names_of_the_wheels_of_the_vehicle_file(client: DdsClient, tmp_path: Path) -> None:
    file = tmp_path / "my_car.yaml"
    file.write_text(
        "name: my car\nmass: 500.0\nall_wheels: {radius: 0.3, inertia: 1.0, brake_gain: 1.0e-4}\n"
        "wheels:\n  FL: {axle: front, side: left, joint: 'car::wheel-fl'}\n  FR: {axle: front, side: right}\n"
    )
    wheel_states: list[JointState] = []
    slips: list[WheelSlip] = []
    qos.subscribe(client.node, JointState, "wheel_states", wheel_states.append, qos.ESTIMATE)
    qos.subscribe(client.node, WheelSlip, "truth/FR/slip", slips.append, qos.ESTIMATE)
    start(client, vehicle_file=file)
    client.until(lambda: bool(wheel_states and slips))
    assert list(wheel_states[0].name) == ["car::wheel-fl", "FR"]
    assert slips[0].wheel == "FR"
    client.until(lambda: client.node.count_subscribers("FL/brake_command") == 1)


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_process_cleanly_and_soon(client: DdsClient, how: signal.Signals) -> None:
    found = record(client, ["wheel_states"])
    process = start(client)
    client.until(lambda: len(found["wheel_states"]) > 20)
    output = stop(process, how)
    assert process.returncode == 0
    assert "Traceback" not in output


def plant_status(health: Sequence[DiagnosticArray]) -> DiagnosticStatus:
    """Newest status of the plant; an empty one before the first."""
    return health[-1].status[0] if health else DiagnosticStatus()


def test_diagnostics_say_when_a_supervisor_falls_silent(client: DdsClient) -> None:
    health: list[DiagnosticArray] = []
    client.node.create_subscription(DiagnosticArray, "/diagnostics", health.append, 10)
    publisher = qos.publish(client.node, BrakeCommand, "front_left/brake_command", qos.command(1.0))
    answered: list[JointState] = []

    def answer(message: JointState) -> None:
        if len(answered) < 100:
            answered.append(message)
            command = BrakeCommand.DECREASE
            publisher.publish(
                sealed(
                    BrakeCommand(
                        header=message.header, wheel="front_left", command=command, counter=len(answered), valid_for=1.0
                    )
                )
            )

    qos.subscribe(client.node, JointState, "wheel_states", answer, qos.SENSOR)
    start(client, end_speed=-1.0)
    client.until(lambda: "silent, taken as NONE: front_left" in plant_status(health).message)
    assert len(answered) == 100
    client.until(lambda: "front_left/brake_command: deadline of 0.05 s missed" in plant_status(health).message)
    assert plant_status(health).level == DiagnosticStatus.WARN
    assert plant_status(health).name == "/corner_sim: plant"
    client.node.destroy_publisher(publisher)
    client.until(lambda: "front_left/brake_command: its supervisor has left" in plant_status(health).message)


def test_a_sender_that_promises_neither_deadline_nor_liveliness_is_not_obeyed_and_is_named(client: DdsClient) -> None:
    health: list[DiagnosticArray] = []
    client.node.create_subscription(DiagnosticArray, "/diagnostics", health.append, 10)
    publisher = qos.publish(client.node, BrakeCommand, "front_left/brake_command")
    start(client, end_speed=-1.0, wait_for_subscribers=0)
    client.until(lambda: "a publisher is not obeyed, it does not offer" in plant_status(health).message)
    assert publisher.get_subscription_count() == 0


def test_two_supervisors_of_one_wheel_are_named(client: DdsClient) -> None:
    health: list[DiagnosticArray] = []
    client.node.create_subscription(DiagnosticArray, "/diagnostics", health.append, 10)
    for _ in range(2):
        qos.publish(client.node, BrakeCommand, "front_left/brake_command", qos.command(0.1))
    start(client, end_speed=-1.0, wait_for_subscribers=0)
    client.until(lambda: "front_left/brake_command: 2 supervisors command" in plant_status(health).message)
