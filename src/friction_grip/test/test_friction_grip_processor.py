"""Messages in, grip out: friction in use of car and axles, what is missing, and the same answers in any order."""

import random
from math import isnan, nan
from typing import Any

import pytest
from friction_msgs.msg import FrictionCurve, Grip, TyreForce, Validity, WheelGrip
from geometry_msgs.msg import TwistWithCovarianceStamped
from sensor_msgs.msg import FluidPressure, Imu, JointState

from friction_grip.parameters import FrictionGripParameters
from friction_grip.ros.processor import GRIP, GripProcessor, build
from friction_runtime.messages import header_at, to_nanoseconds
from friction_runtime.processor import Level
from vehicle_models.constants import GRAVITY
from vehicle_models.reason import Reason
from vehicle_models.vehicle_file import load_vehicle

CAR = load_vehicle("compact_car")
STEP = 5_000_000
Stream = list[tuple[str, Any]]


def made() -> GripProcessor:
    (processor,) = build(FrictionGripParameters(), CAR)
    return processor


def imu(k: int, forward: float, leftward: float = 0.0) -> tuple[str, Imu]:
    message = Imu(header=header_at(k * STEP, ""))
    message.linear_acceleration.x = CAR.accelerometer.reading(forward)
    message.linear_acceleration.y = leftward
    return "imu/data", message


def wheels(k: int, speed: float) -> tuple[str, JointState]:
    velocity = [speed / radius for radius in CAR.radii]
    return "wheel_states", JointState(header=header_at(k * STEP, ""), name=list(CAR.joints), velocity=velocity)


def pressures(k: int, pascal: float) -> Stream:
    return [
        (f"{name}/brake_pressure", FluidPressure(header=header_at(k * STEP, name), fluid_pressure=pascal))
        for name in CAR.wheel_names
    ]


def told(processor: GripProcessor, stream: Stream) -> list[Grip]:
    return [answer for topic, message in stream for name, answer in processor.process(topic, message) if name == GRIP]


def of_wheel(processor: GripProcessor, stream: Stream, wheel: int = 0) -> list[WheelGrip]:
    name = f"{CAR.wheel_names[wheel]}/grip"
    return [answer for topic, message in stream for to, answer in processor.process(topic, message) if to == name]


def steady(forward: float, leftward: float = 0.0, pascal: float | None = None, count: int = 200) -> Stream:
    stream: Stream = []
    for k in range(1, count):
        stream += [imu(k, forward, leftward), wheels(k, 10.0)]
        stream += [] if pascal is None else pressures(k, pascal)
    return stream


def test_the_car_uses_what_the_accelerometer_feels_less_drag_and_rolling_resistance() -> None:
    message = told(made(), steady(-3.0))[-1]
    drag = 0.5 * 1.2 * CAR.drag_area * 100.0 / CAR.mass
    assert message.validity.valid
    slip_alone = (3.0 - drag) / GRAVITY - CAR.rolling_resistance
    assert message.vehicle.mu_x == pytest.approx(slip_alone, abs=0.005)
    assert isnan(message.vehicle.mu_y)
    assert abs(message.vehicle.mu_used - 0.3) < 2.0 * message.vehicle.mu_used_stddev
    assert 0.0 < message.mu_proven < message.vehicle.mu_used
    assert message.mu_lower > message.mu_proven
    assert message.evidence == Grip.FORCE


def test_both_directions_are_used_at_once() -> None:
    message = told(made(), steady(-3.0, leftward=4.2))[-1]
    assert message.vehicle.mu_y == pytest.approx(4.0 / GRAVITY, abs=0.01)
    assert message.vehicle.mu_used == pytest.approx((message.vehicle.mu_x**2 + message.vehicle.mu_y**2) ** 0.5)


def test_brake_torques_share_the_force_between_the_axles() -> None:
    known, unknown = told(made(), steady(-3.0, pascal=4e6))[-1], told(made(), steady(-3.0))[-1]
    for message in (known, unknown):
        assert message.front.mu_used == pytest.approx(0.32, abs=0.08)
        assert message.rear.mu_used == pytest.approx(0.27, abs=0.12)
    assert known.front.mu_used_stddev < unknown.front.mu_used_stddev
    assert known.rear.mu_used_stddev < unknown.rear.mu_used_stddev


def test_driven_wheels_drive() -> None:
    message = told(made(), steady(2.0))[-1]
    assert message.rear.mu_used > 2.0 * message.front.mu_used


def test_a_proof_has_its_age_and_distance() -> None:
    stream = steady(-5.0, count=100)
    stream += [each for k in range(100, 500) for each in (imu(k, -0.5), wheels(k, 10.0))]
    message = told(made(), stream)[-1]
    assert message.mu_proven > 0.4
    assert message.mu_proven_age == pytest.approx(2.0, abs=0.3)
    assert message.mu_proven_distance == pytest.approx(20.0, abs=3.0)
    assert message.distance == pytest.approx(25.0, abs=2.0)


def test_without_an_accelerometer_nothing_is_said_and_the_reason_named() -> None:
    messages = told(made(), [wheels(k, 10.0) for k in range(1, 200)])
    assert messages
    assert all(message.validity.reason == Reason.NO_ACCELERATION for message in messages)
    assert all(isnan(message.mu_lower) and isnan(message.vehicle.mu_used) for message in messages)


def test_what_is_no_acceleration_is_refused() -> None:
    stream = [each for k in range(1, 200) for each in (imu(k, nan), wheels(k, 10.0))]
    assert all(not message.validity.valid for message in told(made(), stream))


def test_a_valid_curve_bounds_above_and_one_that_is_not_does_nothing() -> None:
    for valid, mu_max, reason in (
        (True, 0.9, Reason.OK),
        (True, 0.9, Reason.UNCERTAIN),  # of lambda_max alone
        (True, 0.9, Reason.NO_EXCITATION),  # by driven wheels that spin
        (False, nan, Reason.UNCERTAIN),
        (False, 0.9, Reason.PEAK_NOT_PASSED),
    ):
        stream: Stream = []
        for k in range(1, 400):
            curve = FrictionCurve(header=header_at(k * STEP, "vehicle"), mu_max=mu_max, mu_max_stddev=0.02)
            curve.validity = Validity(valid=reason == Reason.OK, reason=int(reason))
            stream += [imu(k, -3.0), ("vehicle/friction_curve", curve), wheels(k, 10.0)]
        message = told(made(), stream)[-1]
        assert (message.evidence == Grip.CURVE) == valid
        assert isnan(message.mu_upper) != valid


def test_a_tyre_that_measures_its_force_proves_too() -> None:
    stream: Stream = []
    for k in range(1, 400):
        stream += [imu(k, -1.0), wheels(k, 10.0)]
        if k % 40 == 0:
            force = TyreForce(header=header_at(k * STEP, "front_left"), fx=-2400.0, fz=4000.0)
            force.fx_stddev, force.fz_stddev, force.validity = 100.0, 100.0, Validity(valid=True)
            stream.append((f"{CAR.wheel_names[0]}/tyre_force", force))
    message = told(made(), stream)[-1]
    wheel = [each for each in of_wheel(made(), stream) if each.validity.valid][-1]
    assert message.mu_proven == pytest.approx(0.6 - 2.58 * 0.0292, abs=0.005)
    assert wheel.mu_proven == pytest.approx(message.mu_proven)
    assert wheel.source == WheelGrip.TYRE_FORCE
    assert wheel.used.mu_x == pytest.approx(0.6)


def test_a_wheel_with_a_pressure_has_its_own_grip_and_one_without_says_why() -> None:
    with_pressures, without = of_wheel(made(), steady(-3.0, pascal=4e6)), of_wheel(made(), steady(-3.0))
    known, unknown = with_pressures[-1], without[-1]
    assert known.validity.valid
    assert known.wheel == CAR.wheel_names[0]
    assert known.source == WheelGrip.BRAKE
    assert 0.25 < known.used.mu_used < 0.4
    assert 0.0 < known.mu_proven < known.used.mu_used
    assert unknown.source == WheelGrip.NONE
    assert unknown.validity.reason == Reason.NO_PRESSURE
    assert "front_left/brake_pressure" in unknown.validity.text
    assert isnan(unknown.used.mu_used)
    assert isnan(unknown.mu_proven)


def test_distances_are_those_of_the_car_while_its_wheels_slide() -> None:
    stream: Stream = []
    for k in range(1, 400):
        speed = TwistWithCovarianceStamped(header=header_at(k * STEP, "base_link"))
        speed.twist.twist.linear.x = 10.0
        speed.twist.covariance[0] = 0.01
        stream += [imu(k, -1.0), ("vehicle_speed", speed), wheels(k, 10.0 if k < 200 else 0.0)]
    message = told(made(), stream)[-1]
    assert message.distance == pytest.approx(10.0 * to_nanoseconds(message.header.stamp) * 1e-9, abs=0.2)
    assert message.distance > 15.0


def test_answers_do_not_depend_on_the_order_of_arrival() -> None:
    stream = steady(-3.0, leftward=1.0, pascal=4e6)
    late = random.Random(1)
    behind = {topic: late.uniform(0.0, 12.0) for topic, _ in stream}
    begin = 30  # until every input has been heard, samples are waited for or not
    shuffled = sorted(range(len(stream)), key=lambda place: place + behind[stream[place][0]] * (place >= begin))
    in_order, out_of_order = told(made(), stream), told(made(), [stream[place] for place in shuffled])
    assert len(in_order) > 15
    count = min(len(in_order), len(out_of_order))
    assert [repr(each) for each in in_order[:count]] == [repr(each) for each in out_of_order[:count]]


def test_a_reset_and_a_jump_back_begin_anew() -> None:
    processor = made()
    first = told(processor, steady(-3.0))
    processor.reset()
    assert [repr(each) for each in told(processor, steady(-3.0))] == [repr(each) for each in first]
    again = told(processor, steady(-3.0))
    assert again[-1].distance == pytest.approx(first[-1].distance, abs=0.2)


def test_health_shows_the_numbers() -> None:
    processor = made()
    told(processor, steady(-3.0))
    health = processor.health()
    assert health.level == Level.OK
    assert health.values["friction used"].startswith("0.29")
