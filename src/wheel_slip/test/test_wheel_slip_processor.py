"""Messages in, messages out: order of arrival, bad input, jumps in time, shipped parameters."""

import random
from collections.abc import Sequence
from dataclasses import replace
from math import isfinite, isnan, nan
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from friction_msgs.msg import WheelSlip
from geometry_msgs.msg import TwistWithCovarianceStamped
from sensor_msgs.msg import Imu, JointState

from friction_parameters.generated import parameter_file
from friction_parameters.parameter import ParameterError, from_mapping
from friction_parameters.parameter_file import load
from friction_runtime.messages import from_nanoseconds, to_nanoseconds
from vehicle_models.reason import Reason
from vehicle_models.vehicle_file import load_vehicle
from wheel_slip.parameters import SHIPPED, SpeedSensorParameters, WheelSlipParameters
from wheel_slip.ros.processor import VEHICLE_SPEED, CarProcessor, build

CONFIG = Path(__file__).parents[1] / "config" / "wheel_slip.yaml"
PERIOD = 5_000_000
CORNER = load_vehicle("chapter_corner")
Message = tuple[str, Any]


def wheel_states(stamp: int, speeds: Sequence[float], names: Sequence[str] = ("front_left",)) -> Message:
    message = JointState(name=list(names), velocity=list(speeds))
    message.header.stamp = from_nanoseconds(stamp)
    return "wheel_states", message


def imu(stamp: int, acceleration: float) -> Message:
    message = Imu()
    message.header.stamp = from_nanoseconds(stamp)
    message.linear_acceleration.x = acceleration
    return "imu/data", message


def velocity(stamp: int, speed: float, variance: float = 0.25) -> Message:
    message = TwistWithCovarianceStamped()
    message.header.stamp = from_nanoseconds(stamp)
    message.twist.twist.linear.x = speed
    message.twist.covariance[0] = variance
    return "vehicle_velocity", message


def stop(samples: int = 300, start: int = PERIOD, seed: int = 0) -> list[Message]:
    """A noisy stop of one wheel from 30 m/s at 6 m/s^2 with slip 0.1, speed sensor at 50 Hz."""
    rng = np.random.default_rng(seed)
    messages: list[Message] = []
    for k in range(samples):
        t = k * 0.005
        speed = 30.0 - 6.0 * max(t - 0.3, 0.0)
        slip = 0.1 * min(max((t - 0.3) / 0.2, 0.0), 1.0)
        stamp = start + k * PERIOD
        messages.append(wheel_states(stamp, [(1.0 - slip) * speed / 0.3 + 0.07 * rng.normal()]))
        messages.append(imu(stamp, (-6.0 if t > 0.3 else 0.0) + 0.1 * rng.normal()))
        if k % 4 == 0:
            messages.append(velocity(stamp, speed + 0.2 * rng.normal(), 0.04))
    return messages


def run(processor: CarProcessor, messages: Sequence[Message]) -> list[WheelSlip]:
    outputs = [each for topic, message in messages for each in processor.process(topic, message)]
    return [out for topic, out in outputs if topic != VEHICLE_SPEED]


def numbers(message: WheelSlip) -> tuple[Any, ...]:
    """All fields, comparable (NaN equals NaN)."""
    fields = [getattr(message, name) for name in message.get_fields_and_field_types() if name != "header"]
    return (to_nanoseconds(message.header.stamp), *(repr(value) for value in fields))


@pytest.fixture
def processor() -> CarProcessor:
    return CarProcessor(CORNER, load(WheelSlipParameters, CONFIG, "wheel_slip"))


def test_shipped_parameter_file_holds_the_defaults() -> None:
    assert load(WheelSlipParameters, CONFIG, "wheel_slip") == WheelSlipParameters()
    assert CONFIG.read_text() == parameter_file("wheel_slip", SHIPPED["wheel_slip"])


def test_one_processor_serves_every_wheel_of_the_car() -> None:
    (processor,) = build(WheelSlipParameters(), load_vehicle("chapter_car"))
    wheels = load_vehicle("chapter_car").wheel_names
    assert processor.optional == ("vehicle_velocity", *(f"{wheel}/brake_pressure" for wheel in wheels))
    assert list(processor.outputs) == [*(f"{wheel}/slip" for wheel in wheels), VEHICLE_SPEED]


def test_slip_follows_a_stop_with_the_speed_sensor(processor: CarProcessor) -> None:
    outputs = run(processor, stop())
    last = outputs[-1]
    assert len(outputs) >= 299
    assert last.validity.valid
    assert last.speed_measured
    assert last.slip == pytest.approx(0.1, abs=5.0 * last.slip_stddev)
    assert last.slip_stddev < 0.02
    assert last.slip_rate == pytest.approx(0.0, abs=5.0 * last.slip_rate_stddev)
    assert to_nanoseconds(last.header.stamp) % PERIOD == 0


def test_output_does_not_depend_on_the_order_of_arrival_across_topics() -> None:
    in_order = stop()
    rng = random.Random(7)
    delay = {"wheel_states": 0.0, "imu/data": 0.0, "vehicle_velocity": 0.0}
    arrivals: list[tuple[float, int, Message]] = []
    for topic, message in in_order:
        # Up to 15 ms late, each topic in its own order.
        delay[topic] = max(delay[topic] - 5e6, rng.uniform(0.0, 15e6))
        arrivals.append((to_nanoseconds(message.header.stamp) + delay[topic], len(arrivals), (topic, message)))
    shuffled = [message for _, _, message in sorted(arrivals)]
    assert [m for m, _ in shuffled] != [m for m, _ in in_order]
    a = [numbers(m) for m in run(CarProcessor(CORNER, WheelSlipParameters()), in_order)]
    b = [numbers(m) for m in run(CarProcessor(CORNER, WheelSlipParameters()), shuffled)]
    assert a[: len(b)] == b[: len(a)]


def test_output_never_waits_for_a_slow_speed_sensor(processor: CarProcessor) -> None:
    processor.process(*velocity(PERIOD, 20.0))
    for k in range(1, 60):
        processor.process(*imu(k * PERIOD, 0.0))
        (_, output), *_ = processor.process(*wheel_states(k * PERIOD, [20.0 / 0.3]))
        assert to_nanoseconds(output.header.stamp) == k * PERIOD


def test_late_speed_is_used_at_its_own_time(processor: CarProcessor) -> None:
    late = CarProcessor(CORNER, WheelSlipParameters(speed_sensor=SpeedSensorParameters(latency=0.2)))
    messages = []
    for topic, message in stop(500):
        if topic == "vehicle_velocity":
            stamp = to_nanoseconds(message.header.stamp) + 200_000_000
            message.header.stamp = from_nanoseconds(stamp)
        messages.append((topic, message))
    last = run(late, messages)[-1]
    error = last.vehicle_speed - (30.0 - 6.0 * (499 * 0.005 - 0.3))
    assert abs(error) < 2.0 * last.vehicle_speed_stddev
    assert abs(error) < 0.5, "1.2 m/s if it counted where it arrives"


def test_loop_of_a_bag_starts_again_with_the_same_outputs(processor: CarProcessor) -> None:
    first = run(processor, stop())
    second = run(processor, stop())
    assert [numbers(m) for m in second[-290:]] == [numbers(m) for m in first[-290:]]


def test_reset_starts_again(processor: CarProcessor) -> None:
    first = run(processor, stop())
    processor.reset()
    assert [numbers(m) for m in run(processor, stop())] == [numbers(m) for m in first]


@pytest.mark.parametrize(
    ("bad", "named"),
    [
        (wheel_states(0, [50.0]), "wheel_states: stamp is zero"),
        (imu(0, 0.0), "imu/data: stamp is zero"),
        (imu(300 * PERIOD + 1, nan), "imu/data: value is not finite"),
        (velocity(0, 20.0), "vehicle_velocity: stamp is zero"),
        (velocity(301 * PERIOD, float("inf")), "vehicle_velocity: inf is not a vehicle speed"),
        (velocity((2**31 - 1) * 10**9, 20.0), "vehicle_velocity: stamp is out of range"),
        (wheel_states(300 * PERIOD, [50.0]), "wheel_states: stamp repeats"),
    ],
)
def test_bad_sample_is_refused_by_name_and_changes_nothing(bad: Message, named: str) -> None:
    said: list[str] = []
    disturbed = CarProcessor(CORNER, WheelSlipParameters(), lambda _severity, text: said.append(text))
    calm = CarProcessor(CORNER, WheelSlipParameters())
    messages = stop(400)
    cut = next(i for i, (_, m) in enumerate(messages) if to_nanoseconds(m.header.stamp) > 300 * PERIOD)
    outputs = run(disturbed, [*messages[:cut], bad, *messages[cut:]])
    assert [numbers(m) for m in outputs] == [numbers(m) for m in run(calm, messages)]
    assert any(named in text for text in said)


def test_missing_and_not_finite_wheels_are_invalid_and_named_while_others_go_on() -> None:
    said: list[str] = []
    car = load_vehicle("chapter_car")
    processor = CarProcessor(car, WheelSlipParameters(), lambda _severity, text: said.append(text))
    rolling = 20.0 / 0.3
    outputs: list[tuple[str, WheelSlip]] = []
    for k in range(1, 100):
        processor.process(*imu(k * PERIOD, 0.0))
        states = wheel_states(k * PERIOD, [rolling, nan, rolling], ("front_left", "front_right", "rear_left"))
        outputs = list(processor.process(*states))
    by_topic = dict(outputs)
    assert by_topic["front_left/slip"].validity.valid
    assert by_topic["rear_left/slip"].validity.valid
    for wheel in ("front_right", "rear_right"):
        message = by_topic[f"{wheel}/slip"]
        assert not message.validity.valid
        assert message.validity.reason == Reason.BAD_INPUT
        assert wheel in message.validity.text
        assert isnan(message.slip)
        assert isnan(message.wheel_speed)  # none has ever come: it is unknown, not 0
        assert any(f"'{wheel}'" in text for text in said)


def test_no_slip_near_standstill_and_in_reverse(processor: CarProcessor) -> None:
    for speed in (0.0, 0.5, -3.0):
        processor.reset()
        messages: list[Message] = []
        for k in range(1, 60):
            messages += [
                velocity(k * PERIOD, speed, 0.01),
                imu(k * PERIOD, 0.0),
                wheel_states(k * PERIOD, [speed / 0.3]),
            ]
        last = run(processor, messages)[-1]
        assert not last.validity.valid
        assert last.validity.reason == Reason.LOW_SPEED
        assert isnan(last.slip)
        assert isnan(last.slip_rate)
        assert last.vehicle_speed == pytest.approx(speed, abs=0.2)


def test_without_imu_the_speed_sensor_alone_serves_and_the_fault_is_said(processor: CarProcessor) -> None:
    messages = [m for m in stop(400) if m[0] != "imu/data"]
    last = run(processor, messages)[-1]
    assert last.validity.valid
    assert last.slip == pytest.approx(0.1, abs=5.0 * last.slip_stddev)
    assert "imu/data" in processor.health().message


def test_gap_makes_the_slip_invalid_until_the_filter_has_settled(processor: CarProcessor) -> None:
    messages = [m for m in stop(300) if not 200 * PERIOD < to_nanoseconds(m[1].header.stamp) <= 240 * PERIOD]
    outputs = run(processor, messages)
    after = [m for m in outputs if to_nanoseconds(m.header.stamp) > 240 * PERIOD]
    assert [m.validity.reason for m in after[:4]] == [Reason.GAP] * 4
    assert after[10].validity.valid


def test_every_output_of_a_hostile_stream_is_consistent(processor: CarProcessor) -> None:
    rng = random.Random(3)
    weird = [nan, float("inf"), -float("inf"), 1e308, -1e308, 0.0, 1e-308]
    messages: list[Message] = []
    for topic, message in stop(600):
        if rng.random() < 0.1:
            stamp = rng.choice([0, 1, PERIOD, to_nanoseconds(message.header.stamp) - 50 * PERIOD])
            message.header.stamp = from_nanoseconds(max(stamp, 0))
        if rng.random() < 0.1:
            value = rng.choice(weird)
            if topic == "wheel_states":
                message.velocity = rng.choice([[], [value], [value, value]])
            elif topic == "imu/data":
                message.linear_acceleration.x = value
            else:
                message.twist.twist.linear.x = value
                message.twist.covariance[0] = value
        messages.append((topic, message))
    for output in run(processor, messages):
        assert output.validity.valid == (output.validity.reason == Reason.OK)
        assert output.validity.valid == isfinite(output.slip)
        assert output.validity.valid == isfinite(output.slip_rate)
        assert output.validity.valid or output.validity.text


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ({"estimator": {"minimum_speed": 0.0}}, "estimator.minimum_speed"),
        ({"estimator.max_gap": -1.0}, "estimator.max_gap"),
        ({"estimator.wheel_filter.speed_stddev": 0.0}, "speed_stddev"),
        ({"speed_sensor.wait": 1.0}, "speed_sensor.wait"),
        ({"use_imu": "yes"}, "use_imu"),
    ],
)
def test_bad_parameter_is_refused_by_name(values: dict[str, Any], named: str) -> None:
    with pytest.raises(ParameterError, match=named):
        from_mapping(WheelSlipParameters, values)


def test_mounting_of_the_accelerometer_is_that_of_the_car(processor: CarProcessor) -> None:
    mounted = replace(CORNER.accelerometer, axis="y", sign=-1.0, bias=0.5, scale=1.02, pitch_gain=0.001)
    turned = CarProcessor(replace(CORNER, accelerometer=mounted), WheelSlipParameters())
    messages: list[Message] = []
    for topic, message in stop():
        if topic == "imu/data":
            forward = message.linear_acceleration.x
            message = imu(to_nanoseconds(message.header.stamp), 99.0)[1]
            message.linear_acceleration.y = -(1.02 * (1.0 + 9.81 * 0.001) * forward + 0.5)
        messages.append((topic, message))
    found, expected = run(turned, messages), run(processor, stop())
    assert [m.slip for m in found] == pytest.approx([m.slip for m in expected], abs=1e-9, nan_ok=True)
