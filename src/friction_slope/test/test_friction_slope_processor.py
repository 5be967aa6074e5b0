"""The detector behind its messages: alignment, reasons with names, shipped files, hostile streams."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from math import inf, nan
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from friction_msgs.msg import FrictionSlope, SlopeVote, Validity, WheelSlip
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import serialize_message
from sensor_msgs.msg import FluidPressure, Imu, JointState
from std_msgs.msg import Header

from friction_parameters.parameter import ParameterError, changed, from_mapping, ignored
from friction_parameters.parameter_file import load
from friction_runtime.messages import from_nanoseconds, to_nanoseconds
from friction_runtime.processor import Level, Output
from friction_slope.detector import DetectorParameters, NoSlipParameters
from friction_slope.parameters import SHIPPED, FrictionSlopeParameters
from friction_slope.ros.processor import WheelProcessor, build
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Accelerometer
from vehicle_models.vehicle_file import load_vehicle
from vehicle_models.wheel_forces import WheelLoad

CONFIG = Path(__file__).parents[1] / "config"
STEP = 5_000_000
PRESSURE, SLIP, IMU = "front_left/brake_pressure", "front_left/slip", "imu/data"
VEHICLE = load_vehicle("chapter_corner")
P = FrictionSlopeParameters(method="slip", detector=DetectorParameters(window=5, rate_window=5, least_growth=0.0))
NO_SLIP = replace(P, method="no_slip")
ALONE = replace(NO_SLIP, no_slip=NoSlipParameters(slip_at_crossing=False))
Fed = tuple[str, Any]


def header(stamp: int) -> Header:
    return Header(stamp=from_nanoseconds(stamp))


def speed(stamp: int, value: float, name: str = "front_left") -> Fed:
    return "wheel_states", JointState(header=header(stamp), name=["rear_left", name], velocity=[50.0, value])


def pressure(stamp: int, torque: float) -> Fed:
    return PRESSURE, FluidPressure(header=header(stamp), fluid_pressure=torque / 1e-4)


def slip(stamp: int, value: float, rate: float, valid: bool = True) -> Fed:
    text = "" if valid else "no vehicle speed"
    message = WheelSlip(
        header=header(stamp), slip=value, slip_rate=rate, vehicle_speed=25.0, validity=Validity(valid=valid, text=text)
    )
    return SLIP, message


def stream(count: int, first: int = 1) -> list[Fed]:
    """A wheel whose friction moment grows while slip grows: the stable side."""
    fed: list[Fed] = []
    for k in range(first, first + count):
        t = (k - first) * 0.005
        fed += [
            pressure(k * STEP, 300.0 + 100.0 * t),
            slip(k * STEP, 0.05 + 0.5 * t, 0.5),
            speed(k * STEP, 90.0 + 30.0 * t**2),
        ]
    return fed


def run(processor: WheelProcessor, fed: list[Fed]) -> list[FrictionSlope]:
    return [message for topic, given in fed for message in slopes(processor.process(topic, given))]


def slopes(outputs: Iterable[Output]) -> list[FrictionSlope]:
    return [message for _, message in outputs if isinstance(message, FrictionSlope)]


def test_stable_side_is_told_with_h_of_the_equation() -> None:
    last = run(WheelProcessor("front_left", VEHICLE, P), stream(30))[-1]
    assert last.validity.valid
    assert (last.sign, last.method, last.validity.reason) == (1, "slip", Reason.OK)
    assert last.h == pytest.approx(60.0 + 100.0, rel=1e-6)
    assert last.indicator == last.h
    assert last.delay == pytest.approx(0.01)
    assert last.wheel == "front_left"
    assert to_nanoseconds(last.header.stamp) == 30 * STEP
    assert serialize_message(last), "can be published: every field is set"


def test_output_does_not_depend_on_the_order_of_arrival() -> None:
    fed = stream(60)
    straight = run(WheelProcessor("front_left", VEHICLE, P), fed)
    shuffled: list[Fed] = []
    random = Random(3)
    for k in range(0, len(fed), 12):
        part = fed[k : k + 12]
        streams = {topic: [item for item in part if item[0] == topic] for topic, _ in part}
        while any(streams.values()):
            topic = random.choice([name for name, items in streams.items() if items])
            shuffled.append(streams[topic].pop(0))
    assert shuffled != fed
    assert repr(run(WheelProcessor("front_left", VEHICLE, P), shuffled)) == repr(straight)


def test_pressure_that_never_arrives_is_named_after_the_deadline() -> None:
    fed = [item for item in stream(40) if item[0] != PRESSURE]
    found = run(WheelProcessor("front_left", VEHICLE, P), fed)
    assert len(found) == 40 - round(P.deadline / 0.005)
    assert {message.validity.reason for message in found} == {Reason.NO_PRESSURE}
    assert all(PRESSURE in message.validity.text and not message.validity.valid for message in found)
    assert all(np.isnan(message.indicator) for message in found)


def blind(fed: list[Fed], begin: int, end: int) -> list[Fed]:
    """Make the slip of some samples not valid."""
    for topic, message in fed:
        if topic == SLIP and begin * STEP <= to_nanoseconds(message.header.stamp) < end * STEP:
            message.validity.valid, message.slip, message.validity.reason = False, nan, Reason.NO_SPEED
            message.validity.text = "front_left: no vehicle speed"
    return fed


def test_slip_that_is_not_valid_gives_way_to_the_method_without_slip_and_is_named() -> None:
    processor = WheelProcessor("front_left", VEHICLE, P)
    last = run(processor, blind(stream(40), 0, 41))[-1]
    assert last.method == "no_slip"
    alone = run(WheelProcessor("front_left", VEHICLE, ALONE), [item for item in stream(40) if item[0] != SLIP])[-1]
    assert (last.h, last.indicator, last.validity.reason) == (alone.h, alone.indicator, alone.validity.reason)
    assert processor.health().level is Level.WARN
    assert f"{SLIP}: no vehicle speed" in processor.health().message


def test_the_measured_slip_rate_counts_again_when_slip_is_back() -> None:
    processor = WheelProcessor("front_left", VEHICLE, P)
    found = run(processor, blind(stream(60), 20, 40))
    methods = [message.method for message in found]
    back = 40 + P.detector.rate_window - 1
    assert methods[:19] == ["slip" if k >= 4 else message.method for k, message in enumerate(found[:19])]
    assert set(methods[19 : back - 1]) == {"no_slip"}
    assert set(methods[back - 1 :]) == {"slip"}
    assert found[-1].validity.valid
    assert processor.health().level is Level.OK


def test_a_dead_wheel_slip_costs_its_method_but_no_answer_and_no_time_for_ever() -> None:
    processor = WheelProcessor("front_left", VEHICLE, P)
    delays: list[float] = []
    for topic, fed in stream(100):
        stamp = to_nanoseconds(fed.header.stamp)
        if topic == SLIP and stamp > 40 * STEP:
            continue
        for message in slopes(processor.process(topic, fed)):
            delays.append((stamp - to_nanoseconds(message.header.stamp)) / STEP)
    assert len(delays) == 100
    assert max(delays) == round(P.deadline / 0.005)
    assert set(delays[60:]) == {0.0}
    assert message.method == "no_slip"
    health = processor.health()
    assert health.level is Level.WARN
    assert f"{SLIP}: silent" in health.message
    assert health.values["method"] == "no_slip"


@pytest.mark.parametrize("parameters", [P, NO_SLIP])
def test_a_slip_that_was_never_heard_of_is_named_in_diagnostics(parameters: FrictionSlopeParameters) -> None:
    processor = WheelProcessor("front_left", VEHICLE, parameters)
    run(processor, [item for item in stream(80) if item[0] != SLIP])
    assert (processor.health().level, SLIP in processor.health().message) == (Level.WARN, True)


def test_slip_at_low_speed_is_no_fault() -> None:
    processor = WheelProcessor("front_left", VEHICLE, P)
    fed = blind(stream(40), 0, 41)
    for topic, message in fed:
        if topic == SLIP:
            message.validity.reason, message.vehicle_speed = Reason.LOW_SPEED, 1.0
    assert run(processor, fed)[-1].validity.reason == Reason.LOW_SPEED
    assert processor.health().level is Level.OK


def test_method_no_slip_does_not_wait_for_slip_unless_it_is_to_tell_the_slip_at_a_crossing() -> None:
    processor = WheelProcessor("front_left", VEHICLE, ALONE)
    assert not processor.estimates
    fed = [item for item in stream(30) if item[0] != SLIP]
    assert len(run(processor, fed)) == 30
    beside = WheelProcessor("front_left", VEHICLE, NO_SLIP)
    assert list(beside.estimates) == [SLIP]


def test_slip_beside_no_slip_changes_no_indicator() -> None:
    fed = stream(40)
    alone = run(
        WheelProcessor("front_left", VEHICLE, ALONE),
        [item for item in fed if item[0] != SLIP],
    )
    beside = run(WheelProcessor("front_left", VEHICLE, NO_SLIP), fed)
    assert repr([(m.h, m.indicator, m.sign) for m in alone]) == repr([(m.h, m.indicator, m.sign) for m in beside])


def test_missing_wheel_name_is_reported_with_the_names_there_are() -> None:
    said: list[tuple[str, str]] = []
    processor = WheelProcessor("front_left", VEHICLE, P, lambda severity, text: said.append((severity, text)))
    fed = [*stream(3)[:2], speed(STEP, 90.0, name="FL")]
    found = run(processor, fed)
    assert found[0].validity.reason == Reason.BAD_INPUT
    assert said[0][0] == "error"
    assert "'front_left'" in said[0][1]
    assert "rear_left, FL" in said[0][1]


@pytest.mark.parametrize("garbage", [nan, inf, -inf, 1e12])
def test_garbage_in_any_input_is_refused_and_the_estimate_goes_on(garbage: float) -> None:
    whole = stream(71)
    for bad in (speed(31 * STEP, garbage), pressure(31 * STEP, garbage), slip(31 * STEP, garbage, 0.5)):
        processor = WheelProcessor("front_left", VEHICLE, P)
        run(processor, whole[:90])
        rest = [item for item in whole[90:93] if item[0] != bad[0]]
        for message in run(processor, [bad, *rest, *whole[93:]]):
            assert not message.validity.valid or np.isfinite(message.indicator)
        assert message.validity.valid


@pytest.mark.parametrize("stamp", [0, 30 * STEP])
def test_zero_and_repeated_stamps_are_refused_by_topic(stamp: int) -> None:
    said: list[str] = []
    processor = WheelProcessor("front_left", VEHICLE, P, lambda severity, text: said.append(text))
    run(processor, stream(30))
    assert run(processor, [speed(stamp, 90.0)]) == []
    assert run(processor, [pressure(stamp, 90.0)]) == []
    refused = [text for text in said if text.endswith("refused")]
    assert ["wheel_states" in refused[0], PRESSURE in refused[1]] == [True, True]


def test_jump_back_in_time_starts_again() -> None:
    processor = WheelProcessor("front_left", VEHICLE, P)
    first = run(processor, stream(50))
    again = run(processor, stream(50))
    assert repr(again) == repr(first)


def test_reset_is_a_new_processor() -> None:
    processor = WheelProcessor("front_left", VEHICLE, P)
    first = run(processor, stream(50))
    processor.reset()
    assert repr(run(processor, stream(50))) == repr(first)


CAR = load_vehicle("chapter_car")


def imu(stamp: int, acceleration: float) -> Fed:
    message = Imu(header=header(stamp))
    message.linear_acceleration.x = acceleration
    return IMU, message


def braked(count: int, acceleration: Callable[[int], float] | None) -> list[Fed]:
    """The stream, and the deceleration of the car at each sample."""
    fed: list[Fed] = []
    for k, item in enumerate(stream(count)):
        if k % 3 == 0 and acceleration is not None:
            fed.append(imu((k // 3 + 1) * STEP, acceleration(k // 3)))
        fed.append(item)
    return fed


def harder(k: int) -> float:
    return -0.1 * k


def test_load_that_grows_with_the_deceleration_is_taken_out_of_h() -> None:
    processor = WheelProcessor("front_left", CAR, P)
    found = run(processor, braked(40, harder))[-1]
    printed = run(WheelProcessor("front_left", CAR, P), braked(40, None))[-1]
    load = WheelLoad(CAR, "front_left")
    for k in range(38):
        load.update((k + 1) * STEP, harder(k))
    friction_moment = 300.0 + 100.0 * 37 * 0.005 + 60.0 * 37 * 0.005
    assert printed.h - found.h == pytest.approx(friction_moment * load.rate / load.load, rel=0.02)
    assert processor.health().values["vertical load"] == "from imu/data"
    assert processor.health().level is Level.OK


def test_acceleration_that_was_never_there_is_not_waited_for_and_no_fault() -> None:
    processor = WheelProcessor("front_left", CAR, P)
    found = run(processor, braked(40, None))
    assert len(found) == 40
    assert processor.health().values["vertical load"] == "at rest"
    assert processor.health().level is Level.OK
    off = replace(P, detector=replace(P.detector, load_transfer=False))
    assert repr(found) == repr(run(WheelProcessor("front_left", CAR, off), braked(40, None)))


def test_acceleration_that_dies_costs_the_load_but_no_answer_and_no_time_for_ever() -> None:
    processor = WheelProcessor("front_left", CAR, P)
    delays: list[float] = []
    for topic, fed in braked(100, harder):
        stamp = to_nanoseconds(fed.header.stamp)
        if topic == IMU and stamp > 40 * STEP:
            continue
        for message in slopes(processor.process(topic, fed)):
            delays.append((stamp - to_nanoseconds(message.header.stamp)) / STEP)
    assert len(delays) == 100
    assert max(delays) <= round(P.deadline / 0.005)
    assert set(delays[60:]) == {0.0}
    printed = run(WheelProcessor("front_left", CAR, P), braked(100, None))[-1]
    assert message.h == printed.h
    assert processor.health().values["vertical load"] == "at rest"


def test_switched_off_the_acceleration_is_no_input() -> None:
    off = WheelProcessor("front_left", CAR, replace(P, detector=replace(P.detector, load_transfer=False)))
    assert IMU not in off.sensors
    assert IMU in WheelProcessor("front_left", CAR, P).sensors


def test_corner_alone_has_no_load_transfer_and_does_not_take_the_acceleration() -> None:
    assert IMU not in WheelProcessor("front_left", VEHICLE, P).sensors


def test_acceleration_is_read_as_the_accelerometer_is_mounted() -> None:
    turned = replace(CAR, accelerometer=Accelerometer(sign=-1.0, bias=0.3, scale=1.02))
    straight = run(WheelProcessor("front_left", CAR, P), braked(40, harder))
    fed = braked(40, lambda k: turned.accelerometer.reading(harder(k)))
    found = run(WheelProcessor("front_left", turned, P), fed)
    np.testing.assert_allclose([each.h for each in found], [each.h for each in straight])


@pytest.mark.parametrize("garbage", [nan, inf, 1e12])
def test_garbage_in_the_acceleration_is_refused_and_the_estimate_goes_on(garbage: float) -> None:
    said: list[str] = []
    processor = WheelProcessor("front_left", CAR, P, lambda severity, text: said.append(text))
    fed = braked(40, lambda k: garbage if k == 20 else harder(k))
    found = run(processor, fed)
    assert len(found) == 40
    assert found[-1].validity.valid
    assert any(IMU in text and "refused" in text for text in said)


def test_health_tells_what_is_wrong() -> None:
    processor = WheelProcessor("front_left", VEHICLE, P)
    assert processor.health().level is Level.ERROR
    run(processor, stream(30))
    assert processor.health().level is Level.OK
    processor.watch({"wheel_states": 1.0}, 0.0)
    assert "wheel_states" in processor.health().message


TOPICS = st.sampled_from(["wheel_states", PRESSURE, SLIP])
VALUES = st.one_of(st.floats(), st.sampled_from([0.0, 90.0, nan, inf, -inf]))


@given(st.lists(st.tuples(TOPICS, st.integers(-1, 30), VALUES, VALUES, st.booleans()), max_size=80), st.booleans())
def test_hostile_streams_give_consistent_messages_and_no_exception(fed: list[Any], with_slip: bool) -> None:
    processor = WheelProcessor("front_left", VEHICLE, replace(P, method="slip" if with_slip else "no_slip"))
    for topic, k, a, b, valid in fed:
        stamp = max(k, 0) * STEP
        if topic == SLIP:
            _, hostile = slip(stamp, a, b, valid)
        else:
            _, hostile = speed(stamp, a) if topic == "wheel_states" else pressure(stamp, a)
        for message in slopes(processor.process(topic, hostile)):
            assert message.validity.valid == (message.validity.reason == Reason.OK)
            assert message.validity.valid == (message.validity.text == "")
            assert not message.validity.valid or (np.isfinite(message.indicator) and message.sign in (-1, 1))


def test_shipped_parameter_file_holds_the_defaults_and_makes_a_vote_of_each_wheel_and_estimates_of_the_car() -> None:
    parameters = load(FrictionSlopeParameters, CONFIG / "friction_slope.yaml", "friction_slope")
    assert parameters == SHIPPED["friction_slope"].parameters == FrictionSlopeParameters()
    assert ignored(parameters) == []
    wheel, car = build(parameters, VEHICLE)
    assert wheel.outputs == {"front_left/slope_vote": SlopeVote}
    assert car.outputs == {"front_left/friction_slope": FrictionSlope}


@pytest.mark.parametrize("method", ["slip", "no_slip"])
def test_each_wheel_has_its_vote_and_its_estimate_by_the_equations(method: str) -> None:
    (processor,) = build(replace(P, method=method), VEHICLE)
    assert isinstance(processor, WheelProcessor)
    assert processor.outputs == {"front_left/slope_vote": SlopeVote, "front_left/friction_slope": FrictionSlope}
    assert run(processor, stream(40))[-1].method == method


def test_vote_is_predicted_by_the_method_without_slip_and_the_estimate_is_not() -> None:
    parameters = FrictionSlopeParameters()
    last = votes(parameters, stream(40))[-1]
    assert isinstance(last, SlopeVote)
    assert last.delay == pytest.approx(0.005 * (1.0 - parameters.vote.lead) * (parameters.vote.window - 1) / 2.0)
    assert last.delay < 0.0 < run(WheelProcessor("front_left", VEHICLE, parameters), stream(40))[-1].delay
    by_eta = replace(parameters, method="no_slip")
    assert repr(votes(by_eta, stream(40))) == repr(votes(parameters, stream(40)))
    assert serialize_message(last), "can be published: every field is set"


def test_vote_does_not_depend_on_how_the_estimate_is_tuned() -> None:
    tuned = changed(
        FrictionSlopeParameters(),
        {"detector.window": 40, "detector.h_instability": -1000.0, "no_slip.eta_margin": 5.0},
    )
    assert repr(votes(tuned, stream(40))) == repr(votes(FrictionSlopeParameters(), stream(40)))


def test_vote_without_pressure_says_why_it_does_not_count() -> None:
    last = votes(FrictionSlopeParameters(), [item for item in stream(40) if item[0] != PRESSURE])[-1]
    assert last.validity.reason == Reason.NO_PRESSURE
    assert PRESSURE in last.validity.text
    assert np.isnan(last.indicator)


def votes(parameters: FrictionSlopeParameters, fed: list[Fed]) -> list[Any]:
    return voted(WheelProcessor("front_left", VEHICLE, parameters), fed)


def voted(processor: WheelProcessor, fed: list[Fed]) -> list[SlopeVote]:
    outputs = [output for topic, given in fed for output in processor.process(topic, given)]
    return [message for _, message in outputs if isinstance(message, SlopeVote)]


def test_vote_alone_is_the_same_and_takes_no_acceleration() -> None:
    alone = WheelProcessor("front_left", CAR, P, estimates=False)
    assert IMU not in alone.sensors
    assert list(alone.outputs) == ["front_left/slope_vote"]
    assert repr(voted(alone, braked(40, None))) == repr(voted(WheelProcessor("front_left", CAR, P), braked(40, harder)))


def test_vote_does_not_wait_for_a_late_acceleration_and_comes_before_the_estimate() -> None:
    processor = WheelProcessor("front_left", CAR, P)
    run(processor, braked(40, harder))
    names = [name for item in stream(2, first=41)[:3] for name, _ in processor.process(*item)]
    assert names == ["front_left/slope_vote"]
    assert [name for name, _ in processor.process(*imu(41 * STEP, harder(41)))] == ["front_left/friction_slope"]


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ({"detector": {"window": 2}}, "detector.window"),
        ({"detector": {"window": 3, "lead": 1.0}}, "detector: 'window'"),
        ({"detector": {"window": 6, "lead": 2.85}}, "'detector.lead' = 2.85 is outside"),
        ({"detector": {"h_instability": 1.0}}, "h_instability"),
        ({"detector": {"h_stability": -1.0}}, "h_stability"),
        ({"no_slip": {"eta_margin": nan}}, "no_slip.eta_margin"),
        ({"method": "guess"}, "method"),
    ],
)
def test_bad_parameters_are_refused_by_name(values: dict[str, Any], named: str) -> None:
    with pytest.raises(ParameterError, match=named):
        from_mapping(FrictionSlopeParameters, values)


def test_parameters_of_no_slip_serve_both_methods() -> None:
    assert ignored(changed(FrictionSlopeParameters(), {"no_slip.eta_margin": 0.3})) == []


def test_every_wheel_of_the_car_has_a_processor_that_reads_its_joint() -> None:
    car = load_vehicle("chapter_car")
    renamed = replace(car, wheels=tuple(replace(wheel, joint=f"car::{wheel.name}") for wheel in car.wheels))
    processors = build(P, renamed)
    assert [topic for processor in processors for topic in processor.outputs] == [
        f"{name}/{topic}" for name in car.wheel_names for topic in ("slope_vote", "friction_slope")
    ]
    fed = [(topic, given) for topic, given in stream(30) if topic != "wheel_states"]
    fed += [speed(k * STEP, 90.0 + 30.0 * (0.005 * (k - 1)) ** 2, name="car::front_left") for k in range(1, 31)]
    straight = run(WheelProcessor("front_left", VEHICLE, P), stream(30))
    first = processors[0]
    assert isinstance(first, WheelProcessor)
    assert repr(run(first, fed)) == repr(straight)


def test_pressure_is_taken_for_the_time_at_which_it_acted() -> None:
    late = replace(VEHICLE, brake_pressure_delay=0.02)
    fed = [
        pressure((given.header.stamp.sec * 10**9 + given.header.stamp.nanosec) + 4 * STEP, given.fluid_pressure * 1e-4)
        if topic == PRESSURE
        else (topic, given)
        for topic, given in stream(30)
    ]
    straight = run(WheelProcessor("front_left", VEHICLE, P), stream(30))
    assert repr(run(WheelProcessor("front_left", late, P), fed)) == repr(straight)


@pytest.mark.parametrize(("factor", "named"), [(1.0, ""), (1e-5, "in bar"), (1e5, "converted from bar")])
def test_a_pressure_in_another_unit_is_named_and_gives_no_sign(factor: float, named: str) -> None:
    processor = WheelProcessor("front_left", VEHICLE, ALONE)
    found: list[FrictionSlope] = []
    for k in range(1, 400):
        torque = 300.0 * min(max(0.01 * (k - 100), 0.0), 1.0)  # brakes the car by 4.4 m/s^2
        rolled = 100.0 - max(k - 100, 0) * 0.005 * 300.0 / (0.3 * 225.0) / 0.3
        for topic, message in (pressure(k * STEP, factor * torque), speed(k * STEP, rolled)):
            found += slopes(processor.process(topic, message))
    assert len(found) > 380
    if named:
        assert not any(slope.validity.valid for slope in found)
        assert found[-1].validity.reason == Reason.BAD_INPUT
        assert found[-1].validity.text.startswith(PRESSURE)
        assert named in found[-1].validity.text
    else:
        assert not any(slope.validity.reason == Reason.BAD_INPUT for slope in found)
