"""Messages in, messages out: the same whatever the order of arrival, refused with a reason, marked at ABS
activation."""

import math
import random
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from friction_msgs.msg import FrictionCurve, FrictionCurveDebug, TyreForce, Validity, WheelSlip
from geometry_msgs.msg import TwistWithCovarianceStamped
from rclpy.serialization import serialize_message
from sensor_msgs.msg import FluidPressure, Imu, JointState
from std_msgs.msg import Header

from friction_curve_id.activation import ActivationMark
from friction_curve_id.parameters import FrictionCurveParameters
from friction_curve_id.ros.car_processor import CarProcessor
from friction_curve_id.ros.processor import CurveProcessor, build
from friction_curve_id.sample_gate import GateParameters
from friction_parameters.parameter import ParameterError, from_mapping, ignored
from friction_parameters.parameter_file import load
from friction_runtime.messages import from_nanoseconds
from friction_runtime.processor import Level, Report, silent
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Accelerometer, Deviation, SharedBy, Vehicle
from vehicle_models.vehicle_file import load_vehicle

Brake = Callable[..., Any]
Stream = list[tuple[str, Any]]
PACKAGE = Path(__file__).parents[1]
CORNER, CAR = load_vehicle("chapter_corner"), load_vehicle("chapter_car")
GAIN = CORNER.wheels[0].brake_gain
START = 1_000 * NANOSECONDS
SLIP = "front_left/slip"


def header(time: float, start: int = START) -> Header:
    return Header(stamp=from_nanoseconds(start + round(time * NANOSECONDS)))


def braking(clean: Brake, name: str = "dry", start: int = START, wheel: str = "front_left", count: int = 100) -> Stream:
    """Messages of manoeuvre B in the order of their stamps."""
    stream: Stream = []
    for sample in clean(name, count).samples:
        at = header(sample.time, start)
        slip = 1.0 - sample.wheel_speed * 0.3 / sample.vehicle_speed
        stream += [
            ("wheel_states", JointState(header=at, name=["other", wheel], velocity=[1.0, sample.wheel_speed])),
            (f"{wheel}/brake_pressure", FluidPressure(header=at, fluid_pressure=sample.brake_torque / GAIN)),
            (
                f"{wheel}/slip",
                WheelSlip(
                    header=at, wheel=wheel, slip=slip, vehicle_speed=sample.vehicle_speed, validity=Validity(valid=True)
                ),
            ),
        ]
        speed = TwistWithCovarianceStamped(header=at)
        speed.twist.twist.linear.x = sample.vehicle_speed
        stream.append(("vehicle_velocity", speed))
    return stream


def made_by(values: dict[str, Any], vehicle: Vehicle = CORNER, report: Report = silent) -> list[CurveProcessor]:
    made = build(from_mapping(FrictionCurveParameters, values), vehicle, report)
    return [each for each in made if isinstance(each, CurveProcessor)]


def exact(vehicle: Vehicle, **changes: Any) -> Vehicle:
    """The vehicle with all that a wheel method takes for granted stated as exact."""
    zero = Deviation(0.0, SharedBy.ALL)
    changed = replace(vehicle, **changes)
    of_wheel = dict.fromkeys(("radius", "inertia", "brake_gain"), zero)
    of_car = dict.fromkeys(("mass", "brake_pressure_delay", "engine_drag_torque"), zero)
    wheels = tuple(replace(wheel, deviations=of_wheel) for wheel in changed.wheels)
    return replace(changed, wheels=wheels, deviations=of_car)


def processor(**values: Any) -> CurveProcessor:
    return made_by({"method": "rls"} | values)[0]


def outputs(made: CurveProcessor, stream: Stream, kind: type) -> list[Any]:
    topics = {**made.sensors, **made.estimates}
    answers = [each for topic, message in stream if topic in topics for _, each in made.process(topic, message)]
    return [each for each in answers if isinstance(each, kind)]


def drive(made: CurveProcessor, stream: Stream) -> list[FrictionCurve]:
    return outputs(made, stream, FrictionCurve)


def drive_debug(made: CurveProcessor, stream: Stream) -> list[FrictionCurveDebug]:
    return outputs(made, stream, FrictionCurveDebug)


METHODS = ("ml", "rml", "rml_ml", "ls", "rls")


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("speed_source", ["slip", "vehicle_velocity", "none"])
def test_every_method_finds_the_peak_from_every_source_of_speed(clean: Brake, method: str, speed_source: str) -> None:
    last = drive(processor(method=method, speed_source=speed_source), braking(clean))[-1]
    assert last.validity.valid, last.validity.text
    assert last.method == method
    assert last.wheel == "front_left"
    assert last.lambda_max == pytest.approx(0.17, rel=0.05)
    assert last.slip == pytest.approx(0.25, abs=0.02)
    assert math.isnan(last.theta_1) == (method in ("ls", "rls"))


def test_order_of_arrival_does_not_change_a_bit(clean: Brake) -> None:
    stream = braking(clean)
    expected = drive(processor(), stream)
    generator = random.Random(3)
    for _ in range(5):
        # Every topic keeps its order, the topics run up to some samples ahead of one another.
        queues: dict[str, Stream] = {}
        for entry in stream:
            queues.setdefault(entry[0], []).append(entry)
        shuffled: Stream = []
        while any(queues.values()):
            ready = [queue for queue in queues.values() if queue]
            behind = min(ready, key=lambda queue: message_time(queue[0][1]))
            chosen = generator.choice(ready)
            if message_time(chosen[0][1]) - message_time(behind[0][1]) > 0.03:
                chosen = behind
            shuffled.append(chosen.pop(0))
        found = drive(processor(), shuffled)
        assert len(found) == len(expected)
        assert str(found) == str(expected)


def message_time(message: Any) -> float:
    return message.header.stamp.sec + message.header.stamp.nanosec / NANOSECONDS


def stamp_of(message: Any) -> int:
    return message.header.stamp.sec * NANOSECONDS + message.header.stamp.nanosec


def test_a_looped_bag_gives_the_same_again_and_says_that_it_began_again(clean: Brake) -> None:
    made, stream = processor(), braking(clean)
    first = drive(made, stream)
    second = drive(made, stream)
    for old, new in zip(first[-20:], second[-20:], strict=True):
        assert new.lambda_max == old.lambda_max
        assert new.header.stamp == old.header.stamp
    assert second[-1].restarts == 1
    restarts = [message for message in drive_debug(made, stream) if message.restarted]
    assert [message.restart_cause for message in restarts] == [FrictionCurveDebug.RESTART_GAP]


def test_reset_begins_again_and_says_that_it_was_asked_to(clean: Brake) -> None:
    made = processor()
    drive(made, braking(clean, "wet"))
    made.reset()
    after = drive(made, braking(clean, "dry", start=START + 60 * NANOSECONDS))
    assert after[-1].mu_max == pytest.approx(1.17, rel=0.02)


def without(stream: Stream, topic: str) -> Stream:
    return [entry for entry in stream if entry[0] != topic]


@pytest.mark.parametrize("method", METHODS)
def test_missing_brake_pressure_is_said_not_guessed(clean: Brake, method: str) -> None:
    made = processor(method=method)
    found = drive(made, without(braking(clean), "front_left/brake_pressure"))
    assert len(found) > 80
    assert {message.validity.reason for message in found} == {Reason.NO_PRESSURE}
    assert not any(message.validity.valid for message in found)
    assert "front_left/brake_pressure" in found[-1].validity.text
    assert made.health().level is Level.ERROR


@pytest.mark.parametrize("method", ["rls", "vehicle"])
def test_a_wheel_that_is_not_among_the_joints_is_named(clean: Brake, method: str) -> None:
    reports: list[str] = []
    made = made_by({"method": method}, report=lambda severity, text: reports.append(f"{severity}: {text}"))[0]
    found = drive(made, braking(clean, wheel="another"))
    assert len(found) > 80
    assert not any(message.validity.valid for message in found)
    assert reports[0].startswith(
        "error: wheel_states: no velocity for wheel 'front_left', names are: \"other, another\""
    )


def test_messages_with_and_without_an_estimate_can_be_published(clean: Brake) -> None:
    found = drive(processor(), braking(clean))
    assert {message.samples > 0 for message in found} == {False, True}
    assert all(serialize_message(message) for message in found), "every field is set"


def test_missing_slip_does_not_stop_what_can_do_without(clean: Brake) -> None:
    found = drive(processor(), without(braking(clean), "front_left/slip"))
    assert found[-1].validity.valid
    needs_it = drive(
        processor(chapter={"friction_source": "wheel_equation"}), without(braking(clean), "front_left/slip")
    )
    assert {message.validity.reason for message in needs_it} == {Reason.NO_SLIP}


def test_garbage_on_every_topic_costs_samples_and_never_the_estimate(clean: Brake) -> None:
    stream, generator = braking(clean), random.Random(7)
    bad: Stream = []
    for topic, message in stream:
        bad.append((topic, message))
        if generator.random() < 0.1:
            wrong = header(generator.choice([-1000.0, message_time(message) - START / NANOSECONDS + 0.001]))
            bad += [
                ("wheel_states", JointState(header=wrong, name=["front_left"], velocity=[math.nan])),
                ("wheel_states", JointState(header=message.header, name=["front_left"], velocity=[])),
                ("front_left/brake_pressure", FluidPressure(header=message.header, fluid_pressure=math.inf)),
                ("front_left/slip", WheelSlip(header=Header(), slip=math.nan, vehicle_speed=math.nan)),
            ]
    reports: list[str] = []
    made = made_by({"method": "rls"}, report=lambda severity, text: reports.append(text))[0]
    found = drive(made, bad)
    assert found
    assert any("refused" in text for text in reports)
    for message in found:
        assert message.validity.valid == (message.validity.reason == Reason.OK)
        assert math.isnan(message.lambda_max) or 0.0 < message.lambda_max < 1.0


def test_activation_of_the_abs_is_marked_once_with_the_estimate_at_that_sample(clean: Brake) -> None:
    curves = drive(processor(method="ml", abs_activation_slip=0.19), braking(clean))
    found = drive_debug(processor(method="ml", abs_activation_slip=0.19), braking(clean))
    assert [message.header.stamp for message in found] == [message.header.stamp for message in curves]
    marked = [message for message in found if message.at_activation]
    assert len(marked) == 1
    place = found.index(marked[0])
    assert curves[place].slip > 0.19 >= curves[place - 1].slip
    assert marked[0].lambda_max_at_activation == curves[place].lambda_max
    assert all(message.lambda_max_at_activation == marked[0].lambda_max_at_activation for message in found[place:])
    assert all(message.abs_active for message in found[place:])
    assert all(math.isnan(message.lambda_max_at_activation) for message in found[:place])


def test_an_activation_ends_with_the_braking() -> None:
    mark = ActivationMark(0.15)
    for k, slip in enumerate([0.1, 0.16, 0.2, 0.01, 0.18]):
        mark.update(0.1 * k, slip, 0.17)
        assert mark.active == (k >= 1)
        assert mark.at_activation == (k == 1)
    for k in range(8):
        mark.update(1.0 + 0.1 * k, 0.0, 0.17)
    assert not mark.active
    mark.update(2.0, 0.2, 0.1)
    assert mark.at_activation
    assert mark.lambda_max == 0.1


def test_wheels_have_parameters_of_their_own(clean: Brake) -> None:
    wheels = tuple(replace(each, brake_gain=2 * GAIN) if each.axle == "rear" else each for each in CAR.wheels)
    made = made_by({"method": "ml"}, exact(CAR, wheels=wheels, centre_of_gravity_height=0.0))
    left = drive(made[0], braking(clean, wheel="front_left"))[-1]
    rear = drive(made[2], braking(clean, wheel="rear_left"))[-1]
    assert left.validity.valid
    assert rear.mu > 1.5 * left.mu


def test_wheels_are_read_by_their_joints_and_published_by_their_names(clean: Brake) -> None:
    named = replace(CORNER, wheels=(replace(CORNER.wheels[0], joint="car::wheel_fl"),))
    stream = braking(clean)
    for topic, message in stream:
        if topic == "wheel_states":
            message.name[1] = "car::wheel_fl"
    last = drive(made_by({"method": "rls"}, named)[0], stream)[-1]
    assert last.validity.valid, last.validity.text
    assert last.wheel == "front_left"


def test_a_pressure_that_comes_late_counts_for_the_time_at_which_it_acted(clean: Brake) -> None:
    late = [
        (topic, FluidPressure(header=header(0.015, stamp_of(message)), fluid_pressure=message.fluid_pressure))
        if topic.endswith("brake_pressure")
        else (topic, message)
        for topic, message in braking(clean)
    ]
    found = drive(made_by({"method": "rls"}, replace(CORNER, brake_pressure_delay=0.015))[0], late)
    expected = drive(processor(), braking(clean))
    assert [str(message) for message in found] == [str(message) for message in expected[: len(found)]]
    assert len(found) == len(expected)


def test_a_pressure_is_not_interpolated_across_max_gap(clean: Brake) -> None:
    sparse = [
        (topic, message)
        for k, (topic, message) in enumerate(braking(clean))
        if not topic.endswith("brake_pressure") or (k // 4) % 8 == 0
    ]
    assert Reason.NO_PRESSURE in {message.validity.reason for message in drive(processor(), sparse)}
    wider = FrictionCurveParameters(method="rls", gate=GateParameters(max_gap=0.05))
    (patient,) = (each for each in build(wider, CORNER) if isinstance(each, CurveProcessor))
    bridged = drive(patient, sparse)
    assert Reason.NO_PRESSURE not in {message.validity.reason for message in bridged[:80]}


def tyre_forces(clean: Brake) -> Stream:
    stream: Stream = []
    braked = clean("dry")
    for k, (friction, slip) in enumerate(zip(braked.friction, braked.slip, strict=True)):
        at = header(0.05 * k)
        stream += [
            (
                "front_left/slip",
                WheelSlip(header=at, slip=float(slip), vehicle_speed=20.0, validity=Validity(valid=True)),
            ),
            (
                "front_left/tyre_force",
                TyreForce(header=at, fx=-3000.0 * float(friction), fz=3000.0, validity=Validity(valid=k != 50)),
            ),
        ]
    return stream


def test_tyre_forces_give_a_curve_and_invalid_ones_do_not(clean: Brake) -> None:
    found = drive(processor(method="tyre_force"), tyre_forces(clean))
    assert found[-1].lambda_max == pytest.approx(0.17, rel=0.02)
    assert found[-1].validity.valid
    assert [message.validity.reason for message in found].count(Reason.BAD_INPUT) == 1


def vehicle_stream(clean: Brake, accelerometer: bool = True) -> Stream:
    """One corner four times over: a car whose wheels do the same."""
    stream: Stream = []
    braked = clean("dry")
    for sample, friction in zip(braked.samples, braked.friction, strict=True):
        at = header(sample.time)
        names = ["front_left", "front_right", "rear_left", "rear_right"]
        stream.append(("wheel_states", JointState(header=at, name=names, velocity=[sample.wheel_speed] * 4)))
        speed = TwistWithCovarianceStamped(header=at)
        speed.twist.twist.linear.x = sample.vehicle_speed
        stream.append(("vehicle_velocity", speed))
        if accelerometer:
            imu = Imu(header=at)
            imu.linear_acceleration.y = 9.81 * float(friction)
            stream.append(("imu/data", imu))
    return stream


VEHICLE = {"method": "vehicle", "speed_source": "vehicle_velocity"}
RIGID_CAR = replace(
    CAR,
    wheels=tuple(replace(each, relaxation_length=0.001) for each in CAR.wheels),
    centre_of_gravity_height=0.0,
    drag_area=0.0,
    rolling_resistance=0.0,
    accelerometer=Accelerometer(axis="y", sign=-1.0),
)


def test_the_vehicle_has_one_curve_for_all_wheels(clean: Brake) -> None:
    made = made_by(VEHICLE, RIGID_CAR)
    assert len(made) == 1
    found = drive(made[0], vehicle_stream(clean))
    assert found[-1].wheel == "vehicle"
    assert found[-1].mu_max == pytest.approx(1.17, rel=0.03)
    assert abs(found[-1].lambda_max - 0.17) < 2.0 * found[-1].lambda_max_stddev


def test_the_vehicle_without_accelerometer_says_so(clean: Brake) -> None:
    found = drive(made_by(VEHICLE, RIGID_CAR)[0], vehicle_stream(clean, accelerometer=False))
    assert {message.validity.reason for message in found} == {Reason.NO_ACCELERATION}
    assert "imu/data" in found[0].validity.text


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ({"method": "magic"}, "method"),
        ({"method": "vehicle", "speed_source": "none"}, "speed_source"),
        ({"chapter": {"initial_samples": 2}}, "chapter.initial_samples"),
        ({"chapter": {"friction_source": "magic"}}, "chapter.friction_source"),
        ({"noise": {"torque_variance": math.nan}}, "noise.torque_variance"),
        ({"gate": {"minimum_speed": 0.0}}, "gate.minimum_speed"),
        ({"vehicle": {"timing_stddev": 0.0}}, "vehicle.timing_stddev"),
        ({"gate": {"max_gap": 0.1}}, "unknown parameter 'gate.max_gap'"),
        ({"wheels": ["front_left"]}, "unknown parameter 'wheels'"),
    ],
)
def test_a_bad_parameter_is_refused_by_name(values: dict[str, Any], named: str) -> None:
    with pytest.raises(ParameterError, match=named):
        from_mapping(FrictionCurveParameters, values)


@pytest.mark.parametrize(("method", "used"), [("rls", "chapter gate"), ("vehicle", "vehicle"), ("tyre_force", "")])
def test_parameters_of_other_methods_are_ignored_and_named(method: str, used: str) -> None:
    values = {
        "gate.minimum_speed": 4.0,
        "chapter.lambda_init": 0.07,
        "vehicle.timing_stddev": 0.02,
    }
    named = {line.split(":")[0] for line in ignored(from_mapping(FrictionCurveParameters, {"method": method} | values))}
    assert named == {name for name in values if name.split(".")[0] not in used.split()}


def test_the_shipped_parameter_file_holds_the_defaults() -> None:
    shipped = PACKAGE / "config" / "friction_curve_id.yaml"
    assert load(FrictionCurveParameters, shipped, "friction_curve_id") == FrictionCurveParameters()


def test_silence_is_an_error_in_the_diagnostics(clean: Brake) -> None:
    made = processor()
    assert made.health().level is Level.ERROR
    drive(made, braking(clean))
    assert made.health().level is Level.OK
    made.watch({"wheel_states": 1.0}, 0.0)
    assert made.health().level is Level.ERROR
    assert "wheel_states" in made.health().message


@pytest.mark.parametrize("method", METHODS)
def test_a_dead_wheel_slip_is_named_in_the_diagnostics_and_delays_no_answer_for_ever(clean: Brake, method: str) -> None:
    made = processor(method=method)
    stream = braking(clean, count=150)
    ends = message_time(stream[len(stream) // 2][1])
    delays = []
    for topic, message in stream:
        if topic in {**made.sensors, **made.estimates} and (topic != SLIP or message_time(message) < ends):
            delays += [message_time(message) - message_time(answer) for _, answer in made.process(topic, message)]
    assert max(delays) == pytest.approx(FrictionCurveParameters().deadline)
    assert delays[-1] == 0.0
    assert made.health().level >= Level.WARN
    assert f"{SLIP}: silent" in made.health().message
    silent_slip = {topic: 0.0 for topic in made.sensors} | {SLIP: 0.3}
    made.watch(silent_slip, 0.0)
    assert made.health().message.count(SLIP) == 1


def test_a_slip_that_is_not_valid_is_named_in_the_diagnostics_with_its_reason(clean: Brake) -> None:
    made = processor()
    stream = braking(clean)
    for topic, message in stream[len(stream) // 2 :]:
        if topic == SLIP:
            message.validity.valid, message.validity.reason, message.validity.text = (
                False,
                Reason.NO_SPEED,
                "front_left: no vehicle speed",
            )
            message.slip = message.vehicle_speed = math.nan
    drive(made, stream)
    assert made.health().level >= Level.WARN
    assert f"{SLIP}: no vehicle speed" in made.health().message


def test_a_changed_parameter_makes_processors_on_the_same_topics() -> None:
    def topics(values: dict[str, Any]) -> Sequence[set[str]]:
        return [{*each.sensors, *each.estimates, *each.outputs} for each in made_by(values)]

    assert topics({}) == topics({"chapter.friction_source": "slip_equation", "gate.minimum_speed": 4.0})


def test_every_car_gets_the_method_that_counts_what_is_not_known_of_it() -> None:
    for vehicle in (CORNER, exact(CAR), load_vehicle("compact_car")):
        (made,) = build(FrictionCurveParameters(), vehicle)
        assert isinstance(made, CarProcessor)


@pytest.mark.parametrize("method", METHODS)
def test_a_wheel_method_is_never_valid_on_a_car_that_is_not_known_exactly(method: str, clean: Brake) -> None:
    unsure = {"mass": Deviation(10.0, SharedBy.ALL), "brake_pressure_delay": Deviation(0.0, SharedBy.ALL)}
    known, unknown = (
        drive(made_by({"method": method}, vehicle)[0], braking(clean))
        for vehicle in (CORNER, replace(CORNER, deviations=unsure))
    )
    assert known[-1].validity.valid
    assert not any(message.validity.valid for message in unknown)
    assert unknown[-1].lambda_max == known[-1].lambda_max
    assert unknown[-1].validity.reason == Reason.UNKNOWN_CAR
    assert "'mass' has the stddev 10" in unknown[-1].validity.text and "'car'" in unknown[-1].validity.text


@pytest.mark.parametrize(("factor", "named"), [(1e-5, "in bar"), (1e5, "converted from bar")])
def test_a_pressure_in_another_unit_is_named_and_gives_no_curve(clean: Brake, factor: float, named: str) -> None:
    (processor,) = build(FrictionCurveParameters(method="ml"), CORNER)
    curves = []
    for topic, message in braking(clean):
        if isinstance(message, FluidPressure):
            message.fluid_pressure *= factor
        if topic != "vehicle_velocity":
            curves += [each for _, each in processor.process(topic, message) if isinstance(each, FrictionCurve)]
    assert len(curves) > 80
    assert not any(curve.validity.valid for curve in curves)
    assert curves[-1].validity.reason == Reason.BAD_INPUT
    assert curves[-1].validity.text.startswith("front_left/brake_pressure: ")
    assert named in curves[-1].validity.text
