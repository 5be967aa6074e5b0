"""The detector behind its messages: alignment, reasons with names, shipped files, hostile streams."""

from dataclasses import replace
from math import inf, nan
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from friction_msgs.msg import FrictionSlope, WheelSlip
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import serialize_message
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Header

from friction_runtime.parameters import ParameterError, from_mapping, load
from friction_runtime.processor import Level
from friction_runtime.stamps import from_nanoseconds, to_nanoseconds
from friction_slope.estimate import Method, Reason
from friction_slope.parameters import FrictionSlopeParameters
from friction_slope.processor import WheelProcessor, build

CONFIG = Path(__file__).parents[1] / "config"
STEP = 5_000_000
PRESSURE, SLIP = "front_left/brake_pressure", "front_left/slip"
P = FrictionSlopeParameters(window=5, rate_window=5)
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
        header=header(stamp), slip=value, slip_rate=rate, vehicle_speed=25.0, valid=valid, reason_text=text
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
    return [message for topic, given in fed for _, message in processor.process(topic, given)]


def test_stable_side_is_told_with_h_of_the_equation() -> None:
    last = run(WheelProcessor("front_left", P), stream(30))[-1]
    assert last.valid
    assert (last.sign, last.method, last.reason) == (1, FrictionSlope.METHOD_SLIP, FrictionSlope.OK)
    assert last.h == pytest.approx(60.0 + 100.0, rel=1e-6)
    assert last.indicator == last.h
    assert last.delay == pytest.approx(0.01)
    assert last.wheel == "front_left"
    assert to_nanoseconds(last.header.stamp) == 30 * STEP
    assert serialize_message(last), "can be published: every field is set"


def test_output_does_not_depend_on_the_order_of_arrival() -> None:
    fed = stream(60)
    straight = run(WheelProcessor("front_left", P), fed)
    shuffled: list[Fed] = []
    random = Random(3)
    for k in range(0, len(fed), 12):
        part = fed[k : k + 12]
        streams = {topic: [item for item in part if item[0] == topic] for topic, _ in part}
        while any(streams.values()):
            topic = random.choice([name for name, items in streams.items() if items])
            shuffled.append(streams[topic].pop(0))
    assert shuffled != fed
    assert repr(run(WheelProcessor("front_left", P), shuffled)) == repr(straight)


def test_pressure_that_never_arrives_is_named_after_the_deadline() -> None:
    fed = [item for item in stream(40) if item[0] != PRESSURE]
    found = run(WheelProcessor("front_left", P), fed)
    assert len(found) == 40 - round(P.deadline / 0.005)
    assert {message.reason for message in found} == {FrictionSlope.NO_TORQUE}
    assert all(PRESSURE in message.reason_text and not message.valid for message in found)
    assert all(np.isnan(message.indicator) for message in found)


def test_slip_that_is_not_valid_is_named_with_its_own_reason() -> None:
    fed: list[Fed] = []
    for topic, message in stream(30):
        if topic == SLIP:
            message.valid, message.slip, message.reason_text = False, nan, "front_left: no vehicle speed"
        fed.append((topic, message))
    last = run(WheelProcessor("front_left", P), fed)[-1]
    assert last.reason == FrictionSlope.NO_SLIP
    assert SLIP in last.reason_text
    assert "no vehicle speed" in last.reason_text


def test_method_no_slip_does_not_wait_for_slip_unless_it_is_to_tell_the_slip_at_a_crossing() -> None:
    alone = replace(P, method="no_slip", slip_at_crossing=False)
    processor = WheelProcessor("front_left", alone)
    assert not processor.estimates
    fed = [item for item in stream(30) if item[0] != SLIP]
    assert len(run(processor, fed)) == 30
    beside = WheelProcessor("front_left", replace(alone, slip_at_crossing=True))
    assert list(beside.estimates) == [SLIP]


def test_slip_beside_no_slip_changes_no_indicator() -> None:
    fed = stream(40)
    alone = run(
        WheelProcessor("front_left", replace(P, method="no_slip", slip_at_crossing=False)),
        [item for item in fed if item[0] != SLIP],
    )
    beside = run(WheelProcessor("front_left", replace(P, method="no_slip")), fed)
    assert repr([(m.h, m.indicator, m.sign) for m in alone]) == repr([(m.h, m.indicator, m.sign) for m in beside])


def test_missing_wheel_name_is_reported_with_the_names_there_are() -> None:
    said: list[tuple[str, str]] = []
    processor = WheelProcessor("front_left", P, lambda severity, text: said.append((severity, text)))
    fed = [*stream(3)[:2], speed(STEP, 90.0, name="FL")]
    found = run(processor, fed)
    assert found[0].reason == FrictionSlope.BAD_INPUT
    assert said[0][0] == "error"
    assert "'front_left'" in said[0][1]
    assert "rear_left, FL" in said[0][1]


@pytest.mark.parametrize("garbage", [nan, inf, -inf, 1e12])
def test_garbage_in_any_input_is_refused_and_the_estimate_goes_on(garbage: float) -> None:
    fed = stream(30)
    for bad in (speed(31 * STEP, garbage), pressure(31 * STEP, garbage), slip(31 * STEP, garbage, 0.5)):
        processor = WheelProcessor("front_left", P)
        run(processor, fed)
        rest = [item for item in stream(31)[-3:] if item[0] != bad[0]]
        for message in run(processor, [bad, *rest, *stream(40, first=32)]):
            assert not message.valid or np.isfinite(message.indicator)
        assert message.valid


@pytest.mark.parametrize("stamp", [0, 30 * STEP])
def test_zero_and_repeated_stamps_are_refused_by_topic(stamp: int) -> None:
    said: list[str] = []
    processor = WheelProcessor("front_left", P, lambda severity, text: said.append(text))
    run(processor, stream(30))
    assert run(processor, [speed(stamp, 90.0)]) == []
    assert run(processor, [pressure(stamp, 90.0)]) == []
    assert ["wheel_states" in said[0], PRESSURE in said[1]] == [True, True]


def test_jump_back_in_time_starts_anew() -> None:
    processor = WheelProcessor("front_left", P)
    first = run(processor, stream(50))
    again = run(processor, stream(50))
    assert repr(again) == repr(first)


def test_reset_is_a_new_processor() -> None:
    processor = WheelProcessor("front_left", P)
    first = run(processor, stream(50))
    processor.reset()
    assert repr(run(processor, stream(50))) == repr(first)


def test_health_tells_what_is_wrong() -> None:
    processor = WheelProcessor("front_left", P)
    assert processor.health().level is Level.ERROR
    run(processor, stream(30))
    assert processor.health().level is Level.OK
    processor.watch({"wheel_states": 1.0})
    assert "wheel_states" in processor.health().message


TOPICS = st.sampled_from(["wheel_states", PRESSURE, SLIP])
VALUES = st.one_of(st.floats(), st.sampled_from([0.0, 90.0, nan, inf, -inf]))


@given(st.lists(st.tuples(TOPICS, st.integers(-1, 30), VALUES, VALUES, st.booleans()), max_size=80), st.booleans())
def test_hostile_streams_give_consistent_messages_and_no_exception(fed: list[Any], with_slip: bool) -> None:
    processor = WheelProcessor("front_left", replace(P, method="slip" if with_slip else "no_slip"))
    for topic, k, a, b, valid in fed:
        stamp = max(k, 0) * STEP
        if topic == SLIP:
            _, hostile = slip(stamp, a, b, valid)
        else:
            _, hostile = speed(stamp, a) if topic == "wheel_states" else pressure(stamp, a)
        for _, message in processor.process(topic, hostile):
            assert message.valid == (message.reason == FrictionSlope.OK)
            assert message.valid == (message.reason_text == "")
            assert not message.valid or (np.isfinite(message.indicator) and message.sign in (-1, 1))


@pytest.mark.parametrize(
    ("name", "method"),
    [("friction_slope", FrictionSlope.METHOD_NO_SLIP), ("friction_slope_monitor", FrictionSlope.METHOD_SLIP)],
)
def test_shipped_parameter_files_load_and_build(name: str, method: int) -> None:
    parameters = load(FrictionSlopeParameters, CONFIG / f"{name}.yaml", "friction_slope")
    processor = build(parameters)[0]
    assert run(processor, stream(40))[-1].method == method


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ({"window": 2}, "window"),
        ({"window": 3, "lead": 1.0}, "window"),
        ({"h_instability": 1.0}, "h_instability"),
        ({"h_stability": -1.0}, "h_stability"),
        ({"method": "guess"}, "method"),
        ({"wheels": []}, "wheels"),
        ({"inertias": [1.0, 1.0]}, "inertias"),
        ({"radii": [nan]}, "radii"),
    ],
)
def test_bad_parameters_are_refused_by_name(values: dict[str, Any], named: str) -> None:
    with pytest.raises(ParameterError, match=named):
        from_mapping(FrictionSlopeParameters, values)


def test_defaults_are_those_of_the_monitor_file() -> None:
    monitor = load(FrictionSlopeParameters, CONFIG / "friction_slope_monitor.yaml", "friction_slope")
    assert monitor == FrictionSlopeParameters()


def test_numbers_are_those_of_the_messages() -> None:
    for reason in Reason:
        assert getattr(FrictionSlope, reason.name) == reason
    for method in Method:
        assert getattr(FrictionSlope, f"METHOD_{method.name}") == method
