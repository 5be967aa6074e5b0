"""Method car as messages: a curve for every wheel from one processor, and the reasons for missing inputs."""

import random
from functools import cache
from typing import Any

import pytest
from friction_msgs.msg import FrictionCurve, VehicleFit
from sensor_msgs.msg import FluidPressure, Imu, JointState
from std_msgs.msg import Header

from corner_sim.car.driving import SlipCycle
from corner_sim.car.random_car import random_car
from corner_sim.car.recording import Recording, record
from friction_curve_id.parameters import FrictionCurveParameters
from friction_curve_id.ros.car_processor import VEHICLE_FIT, CarProcessor
from friction_curve_id.ros.processor import build
from friction_parameters.parameter import from_mapping
from friction_runtime.messages import from_nanoseconds, to_nanoseconds
from friction_runtime.processor import Level
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.reason import Reason
from vehicle_models.vehicle_file import load_vehicle

CAR = load_vehicle("compact_car")
Stream = list[tuple[str, Any]]


@cache
def stop() -> Recording:
    car = random_car(70_001, "wet", "pacejka")
    return record(car.parameters, SlipCycle(car.parameters, car.cycling), 70_001, duration=2.0)


def stream(begin: int = 1_000 * NANOSECONDS) -> Stream:
    """Messages of the stop in the order of their stamps, from `begin` [ns] on."""
    run, messages = stop(), []
    for k, time in enumerate(run.time.tolist()):
        at = Header(stamp=from_nanoseconds(begin + round(time * NANOSECONDS)))
        names, speeds = list(CAR.joints), run.wheel_speed[k].tolist()
        messages.append(("wheel_states", JointState(header=at, name=names, velocity=speeds)))
        for wheel, pressure in zip(CAR.wheel_names, run.brake_pressure[k].tolist(), strict=True):
            messages.append((f"{wheel}/brake_pressure", FluidPressure(header=at, fluid_pressure=pressure)))
        imu = Imu(header=at)
        imu.linear_acceleration.x = float(run.acceleration[k])
        messages.append(("imu/data", imu))
    return messages


def made() -> CarProcessor:
    (processor,) = build(from_mapping(FrictionCurveParameters, {"method": "car"}), CAR)
    assert isinstance(processor, CarProcessor)
    return processor


def outputs(processor: CarProcessor, messages: Stream) -> list[tuple[str, Any]]:
    return [output for topic, message in messages for output in processor.process(topic, message)]


def drive(processor: CarProcessor, messages: Stream) -> list[tuple[str, FrictionCurve]]:
    return [output for output in outputs(processor, messages) if isinstance(output[1], FrictionCurve)]


def fits(processor: CarProcessor, messages: Stream) -> list[VehicleFit]:
    return [message for topic, message in outputs(processor, messages) if topic == VEHICLE_FIT]


def test_every_wheel_has_its_curve_from_one_processor() -> None:
    processor = made()
    found = drive(processor, stream())
    curves = {f"{wheel}/friction_curve" for wheel in CAR.wheel_names}
    assert {topic for topic, _ in found} == curves
    assert set(processor.outputs) == {VEHICLE_FIT, *curves, *(f"{curve}_debug" for curve in curves)}
    valid = [message for _, message in found if message.validity.valid]
    assert {message.wheel for message in valid} == set(CAR.wheel_names)
    assert {message.method for message in valid} == {"car"}
    last = valid[-1]
    assert abs(last.lambda_max - stop().lambda_max[0]) < 3.0 * last.lambda_max_stddev
    assert abs(last.mu_max - stop().mu_max[-1, 0]) < 3.0 * last.mu_max_stddev
    assert "brake gain over mass, front [N m/(Pa kg)]" in processor.health().values


def test_what_auto_stands_for_is_named_in_the_message() -> None:
    (processor,) = build(FrictionCurveParameters(), CAR)
    assert isinstance(processor, CarProcessor)
    assert {message.method for _, message in drive(processor, stream()[:600])} == {"car"}


def test_the_order_of_arrival_does_not_matter() -> None:
    messages = stream()[: 6 * 200]
    shuffled = messages.copy()
    random.Random(1).shuffle(shuffled)
    shuffled.sort(key=lambda each: (each[1].header.stamp.sec, each[1].header.stamp.nanosec))
    first, second = (
        [(topic, repr(message)) for topic, message in drive(made(), each)] for each in (messages, shuffled)
    )
    assert first == second


def test_the_date_does_not_matter() -> None:
    """Seconds since 1970 are coarse: whether a sample is 0.4 s old then depended on the date, and with it the fit."""

    def curves(begin: int) -> list[tuple[float, ...]]:
        found = drive(made(), stream(begin)[: 6 * 300])
        return [(each.lambda_max, each.lambda_max_stddev, each.slip, each.mu) for _, each in found]

    today, earlier = curves(1_795_906_106_524_246_398), curves(1_000 * NANOSECONDS)
    assert sum(each[0] > 0.0 for each in earlier) > 400
    assert repr(today) == repr(earlier)


def test_a_missing_pressure_is_named_for_its_wheel_and_the_others_go_on() -> None:
    messages = [each for each in stream() if each[0] != "rear_left/brake_pressure"]
    processor = made()
    found = drive(processor, messages)
    lost = [message for topic, message in found if topic.startswith("rear_left")]
    assert {message.validity.reason for message in lost} == {Reason.NO_PRESSURE}
    assert "rear_left/brake_pressure" in lost[-1].validity.text
    assert processor.health().level is Level.ERROR
    assert any(message.samples > 0 for topic, message in found if topic.startswith("front_left"))


def test_a_car_without_accelerometer_is_served() -> None:
    messages = [each for each in stream() if each[0] != "imu/data"]
    last = [message for topic, message in drive(made(), messages) if message.samples > 0][-1]
    assert abs(last.mu_max - stop().mu_max[-1, 0]) < 1.96 * last.mu_max_stddev


def test_a_reset_starts_again() -> None:
    processor = made()
    drive(processor, stream()[: 6 * 150])
    processor.reset()
    assert processor.process(*stream()[0]) == []


@pytest.mark.parametrize("pressure", [float("nan"), 1e12])
def test_an_impossible_pressure_is_refused(pressure: float) -> None:
    processor = made()
    processor.process("wheel_states", stream()[0][1])
    at = stream()[0][1].header
    assert processor.process("front_left/brake_pressure", FluidPressure(header=at, fluid_pressure=pressure)) == []


def released() -> Stream:
    """Messages of the stop and of 1.3 s after it without brakes."""
    messages = stream()
    first = to_nanoseconds(messages[-1][1].header.stamp)
    speeds = messages[-2 - len(CAR.wheels)][1].velocity
    for k in range(1, 261):
        at = Header(stamp=from_nanoseconds(first + 5_000_000 * k))
        messages.append(("wheel_states", JointState(header=at, name=list(CAR.joints), velocity=speeds)))
        messages += [(f"{wheel}/brake_pressure", FluidPressure(header=at)) for wheel in CAR.wheel_names]
        messages.append(("imu/data", Imu(header=at)))
    return messages


def test_what_was_learned_is_told_once_a_second_and_after_a_braking() -> None:
    found = fits(made(), released())
    assert [message.brakings for message in found] == [0, 0, 0, 1, 1]
    assert [message.validity.valid for message in found] == [False, False, False, True, True]
    assert "waiting for a braking" in found[0].validity.text and found[0].gain_over_mass_front > 0.0
    assert found[3].gain_over_mass_front_stddev < 0.5 * found[0].gain_over_mass_front_stddev
    car = random_car(70_001, "wet", "pacejka").parameters
    truth = car.brake_gain[0] / car.mass * CAR.wheels[0].radius / car.radius[0]
    assert abs(found[3].gain_over_mass_front - truth) < 3.0 * found[3].gain_over_mass_front_stddev


def test_a_reset_forgets_what_was_learned() -> None:
    processor = made()
    assert fits(processor, released())[-1].validity.valid
    processor.reset()
    assert not fits(processor, released()[:100])[0].validity.valid


@pytest.mark.parametrize(
    ("kind", "factor", "named"),
    [
        (FluidPressure, 1e-5, "in bar"),
        (FluidPressure, 1e5, "converted from bar"),
        (Imu, 1.0 / 9.81, "in g"),
        (Imu, -1.0, "wrong sign"),
    ],
)
def test_a_pressure_or_an_acceleration_in_another_unit_is_named_and_gives_no_curve(
    kind: type, factor: float, named: str
) -> None:
    messages = stream()
    for _, message in messages:
        if isinstance(message, FluidPressure) and kind is FluidPressure:
            message.fluid_pressure *= factor
        elif isinstance(message, Imu) and kind is Imu:
            message.linear_acceleration.x *= factor
    curves = [curve for _, curve in drive(made(), messages)]
    assert not any(curve.validity.valid for curve in curves)
    assert all(curve.validity.reason == Reason.BAD_INPUT and named in curve.validity.text for curve in curves[-400:])


def test_no_unit_of_a_car_that_is_only_not_known_exactly_is_suspected() -> None:
    assert not [curve.validity.text for _, curve in drive(made(), stream()) if curve.validity.text.endswith("?")]
