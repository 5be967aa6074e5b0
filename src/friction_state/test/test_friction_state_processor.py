"""One message with all wheels for each stamp: what it holds, what it waits for, and what it does without."""

import random
from math import isnan, nan
from pathlib import Path
from typing import Any

import pytest
from friction_msgs.msg import (
    FrictionCurve,
    FrictionSlope,
    FrictionState,
    SupervisorState,
    TyreForce,
    Validity,
    WheelSlip,
    WheelState,
)
from sensor_msgs.msg import JointState
from visualization_msgs.msg import Marker

from friction_parameters.parameter import ParameterError, from_mapping
from friction_parameters.parameter_file import load
from friction_runtime.messages import header_at, to_nanoseconds
from friction_runtime.processor import Level
from friction_state.force_arrows import UNKNOWN, UNUSED, USED
from friction_state.parameters import SHIPPED, FrictionStateParameters
from friction_state.ros.force_markers import force_markers
from friction_state.ros.processor import FRICTION_STATE, StateProcessor, build
from vehicle_models.vehicle_file import load_vehicle

CONFIG = Path(__file__).parents[1] / "config" / "friction_state.yaml"
CAR = load_vehicle("chapter_car")
STEP = 5_000_000
VALID = Validity(valid=True)
Stream = list[tuple[str, Any]]


def made(**parameters: float) -> StateProcessor:
    (processor,) = build(FrictionStateParameters(**parameters), CAR)  # type: ignore[arg-type]
    return processor


def states(k: int) -> tuple[str, Any]:
    return "wheel_states", JointState(header=header_at(k * STEP, ""))


def answers(k: int, wheel: str, names: tuple[str, ...] = ("slip", "friction_slope", "friction_curve")) -> Stream:
    header = header_at(k * STEP, wheel)
    every = {
        "slip": WheelSlip(header=header, slip=0.001 * k, slip_stddev=0.01, validity=VALID),
        "friction_slope": FrictionSlope(header=header, sign=-1, validity=VALID),
        "friction_curve": FrictionCurve(header=header, lambda_max=0.1, mu_max=1.1, mu_max_stddev=nan),
        "abs_supervisor": SupervisorState(header=header, state=SupervisorState.S22, command=3, validity=VALID),
        "tyre_force": TyreForce(header=header, fx=-100.0 * k, fz=4000.0, validity=VALID),
    }
    return [(f"{wheel}/{name}", every[name]) for name in names]


def all_answers(k: int, *names: str) -> Stream:
    return [each for wheel in CAR.wheel_names for each in (answers(k, wheel, names) if names else answers(k, wheel))]


def feed(processor: StateProcessor, stream: Stream) -> list[FrictionState]:
    found = [output for topic, message in stream for output in processor.process(topic, message)]
    assert {topic for topic, _ in found} <= {FRICTION_STATE}
    return [message for _, message in found]


def stamps(found: list[FrictionState]) -> list[int]:
    return [to_nanoseconds(message.header.stamp) // STEP for message in found]


EVERY = ("slip", "friction_slope", "friction_curve", "abs_supervisor")


def test_a_message_holds_the_estimates_of_every_wheel_at_its_stamp() -> None:
    processor = made()
    stream = [each for k in range(1, 4) for each in (states(k), *all_answers(k, "tyre_force", *EVERY))]
    found = feed(processor, stream)
    assert stamps(found) == [1, 2, 3]
    assert [wheel.wheel for wheel in found[-1].wheels] == list(CAR.wheel_names)
    for wheel in found[-1].wheels:
        assert (wheel.slip, wheel.slip_stddev, wheel.slip_valid) == (0.003, 0.01, True)
        assert (wheel.slope_sign, wheel.slope_valid) == (-1, True)
        assert (wheel.lambda_max, wheel.mu_max, wheel.curve_valid) == (0.1, 1.1, False)
        assert isnan(wheel.mu_max_stddev)
        assert (wheel.supervisor_state, wheel.command, wheel.supervisor_valid) == (SupervisorState.S22, 3, True)
        assert (wheel.fx, wheel.fz, wheel.force_valid) == (-300.0, 4000.0, True)
    assert processor.health().level is Level.OK


def test_what_is_not_known_is_nan_and_not_valid() -> None:
    found = feed(made(), [each for k in range(1, 20) for each in (states(k), *answers(k, "front_left", ("slip",)))])
    left, right = found[0].wheels[:2]
    assert left.slip == 0.001 and left.slip_valid
    unknown = (right.slip, right.lambda_max, right.mu_max_stddev, right.fx, left.lambda_max)
    assert all(isnan(value) for value in unknown)
    assert not (right.slip_valid or right.slope_valid or right.curve_valid or right.force_valid)
    assert (right.slope_sign, right.supervisor_state, right.command) == (0, WheelState.UNKNOWN, WheelState.UNKNOWN)


def test_a_sample_waits_for_the_last_answer_up_to_the_deadline() -> None:
    processor = made(deadline=0.02)
    for k in range(1, 4):
        feed(processor, [states(k), *all_answers(k, *EVERY)])
    assert feed(processor, [states(4), *all_answers(4, *EVERY)[:-1]]) == []
    assert stamps(feed(processor, all_answers(4, *EVERY)[-1:])) == [4]
    late = feed(processor, [states(k) for k in range(5, 10)])
    assert stamps(late) == [5]
    assert isnan(late[0].wheels[0].slip) and not late[0].wheels[0].slip_valid


def test_an_estimator_that_does_not_run_is_not_waited_for_after_the_first_second() -> None:
    processor = made()
    found = [stamps(feed(processor, [states(k), *all_answers(k)])) for k in range(1, 230)]
    assert found[50] == [41], "the deadline of 0.05 s"
    assert found[-1] == [229]
    stream = [each for k in range(230, 250) for each in (states(k), *all_answers(k, *EVERY))]
    joined = feed(processor, stream)
    assert stamps(joined) == list(range(230, 250))
    assert joined[-1].wheels[0].supervisor_valid and not joined[0].wheels[0].curve_valid


def test_forces_and_curves_count_for_a_while_and_slips_do_not() -> None:
    processor = made(hold=0.1)
    feed(processor, [states(1), *all_answers(1, *EVERY, "tyre_force")])
    found = {stamps([each])[0]: each.wheels[0] for each in feed(processor, [states(k) for k in range(2, 60)])}
    assert found[2].fx == found[21].fx == -100.0 and found[21].force_valid and found[21].lambda_max == 0.1
    assert isnan(found[22].fx) and not found[22].force_valid and isnan(found[22].lambda_max)
    assert isnan(found[2].slip) and not found[2].slope_valid


def test_order_of_arrival_does_not_change_a_bit() -> None:
    stream = [each for k in range(1, 300) for each in (states(k), *all_answers(k, *EVERY[:3]))]
    expected = feed(made(), stream)
    generator = random.Random(3)
    for _ in range(3):
        delays = {topic: generator.randint(0, 4) * STEP for topic, _ in stream}
        # Every topic keeps its order; the topics run up to four samples apart.
        shuffled = sorted(stream, key=lambda each: to_nanoseconds(each[1].header.stamp) + delays[each[0]])
        found = feed(made(), shuffled)
        assert repr(found) == repr(expected[: len(found)])
        assert len(found) > 280


def test_a_looped_bag_gives_the_same_again() -> None:
    processor = made()
    stream = [each for k in range(1, 100) for each in (states(k), *all_answers(k, "tyre_force", *EVERY))]
    first, second = feed(processor, stream), feed(processor, stream)
    assert stamps(second) == list(range(1, 100))
    assert repr(first) == repr(second)


def test_silence_is_named() -> None:
    processor = made()
    assert processor.health().level is Level.ERROR
    feed(processor, [states(k) for k in range(1, 30)])
    assert (processor.health().level, processor.health().message) == (Level.WARN, "no estimate of any wheel yet")


def test_every_field_of_a_wheel_comes_from_an_estimate() -> None:
    (message,) = feed(made(), [states(1), *all_answers(1, "tyre_force", *EVERY)])
    fresh, filled = WheelState(), message.wheels[0]
    fields = set(WheelState.get_fields_and_field_types())
    same = {name for name in fields if repr(getattr(fresh, name)) == repr(getattr(filled, name))}
    assert same == {"lambda_max_stddev", "curve_valid", "fx_stddev", "fz_stddev"}, "zero or false in the estimates too"


def test_shipped_parameter_file_holds_the_defaults() -> None:
    assert load(FrictionStateParameters, CONFIG, "friction_state") == SHIPPED["friction_state"].parameters
    with pytest.raises(ParameterError, match="deadline"):
        from_mapping(FrictionStateParameters, {"deadline": -1.0})


class TestMarkers:
    def markers(self, wheel: WheelState) -> dict[str, Marker]:
        others = [WheelState(wheel=name) for name in CAR.wheel_names[1:]]
        state = FrictionState(header=header_at(STEP, "base_link"), wheels=[wheel, *others])
        found = force_markers(state, CAR).markers
        assert len({(marker.ns, marker.id) for marker in found}) == len(found) == 2 * len(CAR.wheels)
        assert all(marker.action == Marker.DELETE and not marker.points for marker in found if marker.id)
        return {marker.ns: marker for marker in found if marker.id == 0}

    def wheel(self, **fields: Any) -> WheelState:
        known = {"fx": -2000.0, "fz": 4000.0, "force_valid": True, "mu_max": 1.0, "curve_valid": True}
        return WheelState(wheel="front_left", **{**known, **fields})

    def test_arrows_stand_at_the_contact_patch_and_are_as_long_as_the_force(self) -> None:
        found = self.markers(self.wheel())
        ahead = (1.0 - CAR.front_load_share) * CAR.wheelbase
        for name, tip in (("fx", (ahead - 0.5, 0.5 * CAR.track, 0.0)), ("fz", (ahead, 0.5 * CAR.track, 1.0))):
            tail, head = found[name].points
            assert (tail.x, tail.y, tail.z) == pytest.approx((ahead, 0.5 * CAR.track, 0.0))
            assert (head.x, head.y, head.z) == pytest.approx(tip)
            assert found[name].header.frame_id == "base_link"

    @pytest.mark.parametrize(
        ("fields", "colour"),
        [
            ({"fx": 0.0}, UNUSED),
            ({"fx": -4400.0}, USED),
            ({"curve_valid": False}, UNKNOWN),
            ({"mu_max": nan}, UNKNOWN),
            ({"mu_max": 0.5}, USED),
        ],
    )
    def test_colour_is_the_share_of_the_grip(self, fields: dict[str, Any], colour: tuple[float, ...]) -> None:
        shown = self.markers(self.wheel(**fields))["fx"].color
        assert (shown.r, shown.g, shown.b) == pytest.approx(colour, abs=1e-6)

    def test_force_that_is_not_valid_is_deleted(self) -> None:
        assert self.markers(self.wheel(force_valid=False, fx=nan, fz=nan))["fx"].action == Marker.DELETE

    def test_markers_come_twenty_times_a_second_and_only_where_asked_for(self) -> None:
        stream = [each for k in range(1, 201) for each in (states(k), *all_answers(k))]
        asked = made(publish_markers=True)
        topics = [topic for name, message in stream for topic, _ in asked.process(name, message)]
        assert topics.count("force_markers") == pytest.approx(20, abs=1)
        quiet = made()
        assert {topic for name, message in stream for topic, _ in quiet.process(name, message)} == {FRICTION_STATE}
