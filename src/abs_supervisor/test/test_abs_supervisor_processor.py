"""The supervisor behind its messages: message time, fail-safe, shadow mode, counts, hostile input."""

from dataclasses import replace
from itertools import pairwise
from math import inf, nan
from pathlib import Path
from typing import Any

import pytest
from friction_msgs.msg import (
    BrakeCommand,
    BrakeDemand,
    FrictionCurve,
    SlopeVote,
    SupervisorDebug,
    SupervisorState,
    Validity,
    WheelSlip,
)
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import serialize_message
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Header

from abs_supervisor.parameters import SHIPPED, PressureParameters, SupervisorParameters
from abs_supervisor.ros.processor import WheelProcessor, build
from abs_supervisor.state_machine import Thresholds
from friction_parameters.parameter import ParameterError, changed, from_mapping, ignored
from friction_parameters.parameter_file import load
from friction_runtime.messages import from_nanoseconds, to_nanoseconds, validity
from friction_runtime.processor import Level
from friction_slope.parameters import FrictionSlopeParameters
from vehicle_models.brake_actuator import BrakeActuator
from vehicle_models.reason import Reason
from vehicle_models.vehicle_file import load_vehicle

CONFIG = Path(__file__).parents[1] / "config" / "abs_supervisor.yaml"
STEP = 5_000_000
VOTE = "front_left/slope_vote"
VEHICLE = load_vehicle("chapter_corner")
P = SupervisorParameters(
    shadow=False,
    thresholds=Thresholds(h_instability=-100.0, h_stability=1000.0, wait=0.04, release_timeout=0.08),
    tolerance=0.02,
    real_time=False,
)
BY_PRESSURE = replace(P, braking_source="pressure")
K = 1e-4
SPEED, SLIP = 20.0, 0.29
"""Of the car [m/s], and of the wheel where a test says nothing else: a release helps, and the pressure
may rise in full."""


def demand(stamp: int, torque: float, wheel: str = "") -> BrakeDemand:
    return BrakeDemand(header=Header(stamp=from_nanoseconds(stamp)), wheel=wheel, pressure=torque / K)


def vote(stamp: int, indicator: float, growing: int = 1, reason: int = Reason.OK) -> SlopeVote:
    h = indicator if growing > 0 else -indicator
    return SlopeVote(
        header=Header(stamp=from_nanoseconds(stamp)),
        wheel="front_left",
        h=h,
        indicator=indicator,
        validity=validity("front_left", Reason(reason), "" if reason == Reason.OK else "why"),
    )


def turning(stamp: int, slip: float = SLIP) -> list[tuple[str, Any]]:
    """Messages of a wheel with a slip; its speed is never the same twice, as that of a sensor that works."""
    header = Header(stamp=from_nanoseconds(stamp))
    speed = SPEED * (1.0 - slip) / 0.3 + 1e-3 * (stamp // STEP % 2)
    message = WheelSlip(
        header=header,
        slip=slip,
        slip_stddev=0.00316,
        vehicle_speed=SPEED,
        wheel_speed=speed,
        speed_measured=True,
        validity=Validity(valid=True),
    )
    return [
        ("wheel_states", JointState(header=header, name=["front_left"], velocity=[speed])),
        ("front_left/slip", message),
    ]


def pressure(stamp: int, torque: float) -> tuple[str, Any]:
    header = Header(stamp=from_nanoseconds(stamp))
    return "front_left/brake_pressure", FluidPressure(header=header, fluid_pressure=torque / K)


PEAK = {"theta_1": nan, "lambda_max": 0.12, "lambda_max_stddev": 0.01, "mu_max": 1.0}
"""Of a friction curve."""
BEFORE = 50
"""Samples before a test begins."""


class Bench:
    """A processor with a brake that obeys it, fed sample by sample; keeps its outputs and reports."""

    def __init__(self, parameters: SupervisorParameters = P) -> None:
        self.said: list[tuple[str, str]] = []
        self.processor = WheelProcessor(
            "front_left", VEHICLE, parameters, lambda severity, text: self.said.append((severity, text))
        )
        self.stamp = 0
        self.state, self.debug = SupervisorState(), SupervisorDebug()
        self.command: int | None = None
        self.counter = 0
        self.slip = SLIP
        self.brake = BrakeActuator(1, STEP * 1e-9)
        for k in range(BEFORE):  # it rolls, and dives: slip is evidence after a time, where the wheel itself falls
            self.slip = SLIP * min(max(k - 30, 0) / 15, 1.0)
            self.sample(0.0, torque=0.0, felt=60.0 if k >= 30 else None)

    def sense(self, torque: float, felt: float | None = None) -> None:
        """All inputs but the vote, at the present stamp; `felt`: torque of the brake, its own where None."""
        self.processor.process("brake_demand", demand(self.stamp, torque))
        acts = float(self.brake.step(torque, self.command or 0)[0])
        for topic, message in (*turning(self.stamp, self.slip), pressure(self.stamp, acts if felt is None else felt)):
            assert self.processor.process(topic, message) == []

    def take(self, outputs: Any) -> None:
        self.command = None
        for topic, message in outputs:
            assert serialize_message(message), "can be published: every field is set"
            if topic.endswith("abs_supervisor"):
                self.state = message
            elif topic.endswith("abs_supervisor_debug"):
                self.debug = message
                assert message.header.stamp == self.state.header.stamp
            else:
                self.command = message.command
                assert message.header.stamp == self.state.header.stamp
                assert (message.counter, message.valid_for) == (self.counter + 1, 0.1)
                self.counter = message.counter

    def sample(
        self,
        indicator: float,
        torque: float = 500.0,
        growing: int = 1,
        reason: int = Reason.OK,
        felt: float | None = None,
    ) -> str:
        self.stamp += STEP
        self.sense(torque, felt)
        self.take(self.processor.process(VOTE, vote(self.stamp, indicator, growing, reason)))
        return self.name

    @property
    def name(self) -> str:
        return ("S0", "S1", "S21", "S22")[self.state.state]

    def brake_into_s22(self) -> None:
        self.sample(500.0)
        self.sample(-200.0)
        while self.sample(-200.0) != "S22":
            pass


def test_a_cycle_is_commanded_counted_and_logged_with_its_causes() -> None:
    bench = Bench()
    assert bench.sample(0.0, torque=0.0) == "S0"
    assert bench.command == BrakeCommand.NONE
    assert bench.sample(500.0) == "S1"
    assert bench.command == BrakeCommand.INCREASE
    assert bench.sample(-100.0) == "S21"
    assert bench.command == BrakeCommand.DECREASE
    began = bench.stamp
    while bench.sample(2000.0, growing=-1) == "S21":
        pass
    assert bench.name == "S22"
    assert (bench.stamp - began) * 1e-9 == pytest.approx(P.thresholds.wait)
    assert bench.sample(2000.0, growing=-1) == "S1"
    assert bench.sample(0.0, torque=0.0) == "S0"
    counts = bench.debug
    assert (counts.transitions, counts.instabilities, counts.recoveries, counts.fail_safes) == (5, 1, 1, 0)
    transitions = [text for severity, text in bench.said if severity == "debug"]
    causes = [text.split("cause ")[1] for text in transitions]
    assert causes == ["braking", "instability", "wait_over", "stability", "braking_over"]
    lasted = f"{(bench.stamp - (BEFORE + 2) * STEP) / 1e9:.2f} s"
    told = [each for each in bench.said if each[0] != "debug"]
    assert told == [("info", f"front_left: braked for {lasted}, releases: 1, last cause: braking_over")]
    values = bench.processor.health().values
    assert values["transitions"] == "5"
    assert values["recoveries"] == "1"


def test_the_pressure_rises_slowly_on_a_wheel_that_slips_far_beyond_its_peak() -> None:
    """By 2 of the 5 kN m/s of its brake, from 1.5 times the slip on from which a release helps."""
    for slip, share in ((SLIP, 1.0), (0.4, 0.4)):
        bench = Bench()
        bench.slip = slip
        commands = []
        for _ in range(10):
            assert bench.sample(500.0) == "S1"
            commands.append(bench.command)
        assert set(commands) <= {BrakeCommand.INCREASE, BrakeCommand.HOLD}
        assert commands.count(BrakeCommand.INCREASE) == round(10 * share)


def test_release_time_out_is_measured_from_the_entry_into_s22() -> None:
    bench = Bench()
    bench.brake_into_s22()
    entered = bench.stamp
    while bench.sample(-200.0) == "S22":
        pass
    assert bench.name == "S1"
    assert (bench.stamp - entered) * 1e-9 == pytest.approx(P.thresholds.release_timeout)
    assert bench.debug.release_timeouts == 1


@pytest.mark.parametrize("reason", [Reason.NO_PRESSURE, Reason.BAD_INPUT, Reason.GAP, Reason.NO_SLIP])
def test_vote_that_does_not_count_brings_the_fail_safe_within_the_stated_time(reason: int) -> None:
    bench = Bench()
    bench.brake_into_s22()
    first = bench.stamp + STEP
    while bench.sample(nan, reason=reason) == "S22":
        assert bench.state.validity.reason == Reason.INVALID_SLOPE
    assert bench.name == "S0"
    assert bench.command == BrakeCommand.NONE
    assert (bench.stamp - first) * 1e-9 == pytest.approx(P.tolerance)
    assert bench.state.cause == SupervisorState.CAUSE_FAIL_SAFE
    assert [severity for severity, _ in bench.said if severity != "debug"] == ["info", "error"]
    assert bench.said[-2][1].endswith(", releases: 1, last cause: fail_safe")
    assert bench.said[-1][1] == "front_left/slope_vote: why: fail-safe"
    assert bench.state.validity.text == "front_left/slope_vote: why"


def test_one_bad_sample_does_not_end_a_release() -> None:
    bench = Bench()
    bench.brake_into_s22()
    assert bench.sample(nan, reason=Reason.BAD_INPUT) == "S22"
    assert bench.command == BrakeCommand.DECREASE
    assert bench.sample(-200.0) == "S22"


@pytest.mark.parametrize("reason", [Reason.NO_EXCITATION, Reason.NOT_BRAKING])
def test_vote_that_is_merely_not_measurable_keeps_the_state(reason: int) -> None:
    bench = Bench()
    bench.sample(500.0)
    for _ in range(400):  # the pressure of the test before is forgotten
        assert bench.sample(nan if reason == Reason.NOT_BRAKING else 0.0, reason=reason) == "S1"
    assert bench.state.validity.valid


def test_low_speed_ends_the_intervention() -> None:
    bench = Bench()
    bench.brake_into_s22()
    assert bench.sample(nan, reason=Reason.LOW_SPEED) == "S0"
    assert bench.state.cause == SupervisorState.CAUSE_LOW_SPEED
    assert bench.state.validity.reason == Reason.LOW_SPEED
    assert bench.state.validity.text == "front_left: why"


def test_low_speed_of_a_wheel_that_may_be_locked_says_that_the_abs_is_lost() -> None:
    """Without slip, a wheel that is alone cannot tell its lock from a standstill of the car."""
    bench = Bench()
    bench.brake_into_s22()
    for known in (True, False):
        for _ in range(40):
            bench.stamp += STEP
            given = [*turning(bench.stamp), pressure(bench.stamp, 500.0), ("brake_demand", demand(bench.stamp, 500.0))]
            for topic, message in (*given, (VOTE, vote(bench.stamp, nan, reason=Reason.LOW_SPEED))):
                if topic.endswith("slip") and not known:
                    message = WheelSlip(
                        header=message.header, vehicle_speed=nan, validity=Validity(reason=Reason.BAD_INPUT)
                    )
                bench.take(bench.processor.process(topic, message))
        assert ("ABS inactive" in bench.state.validity.text) != known
        assert bench.processor.health().level is (Level.OK if known else Level.WARN)


def test_silence_brings_the_fail_safe_by_the_clock_of_the_node() -> None:
    bench = Bench()
    bench.brake_into_s22()
    ages = {VOTE: 0.02, "brake_demand": 0.02}
    assert bench.processor.watch(ages, 0.0) == []
    bench.take(bench.processor.watch(ages | {VOTE: P.stale_after + 0.01}, 0.0))
    assert bench.name == "S0"
    assert bench.command == BrakeCommand.NONE
    assert bench.state.validity.reason == Reason.NO_SLOPE
    assert bench.processor.watch(ages | {VOTE: 1.0}, 0.0) == []
    assert bench.processor.health().level is Level.ERROR
    bench.sample(500.0)
    assert bench.name == "S1"


def test_silent_demand_is_held_for_a_while_and_then_fails_safe() -> None:
    bench = Bench()
    bench.sample(500.0)
    last = bench.stamp
    while bench.name != "S0":
        bench.stamp += STEP
        for topic, message in (*turning(bench.stamp), pressure(bench.stamp, 500.0), (VOTE, vote(bench.stamp, 500.0))):
            for state, command in pairwise([*bench.processor.process(topic, message), None]):
                if bench.name != "S0" and state is not None and command is not None and state[0].endswith("supervisor"):
                    bench.take([state, command])
    assert bench.state.validity.reason == Reason.NO_DEMAND
    answered = to_nanoseconds(bench.state.header.stamp)
    assert (answered - last) * 1e-9 == pytest.approx(P.demand_timeout + P.tolerance, abs=0.0051)
    assert bench.stamp - answered <= P.deadline * 1e9, "what the answers wait for"


def test_every_vote_is_answered_once_with_its_stamp() -> None:
    bench = Bench()
    for k in range(50):
        bench.sample(nan, reason=Reason.NOT_READY if k < 20 else Reason.OK)
        assert bench.command is not None
        assert bench.state.header.stamp == from_nanoseconds(bench.stamp)


def test_in_shadow_mode_there_is_no_command_topic_at_all() -> None:
    bench = Bench(replace(P, shadow=True))
    assert list(bench.processor.outputs) == ["front_left/abs_supervisor", "front_left/abs_supervisor_debug"]
    bench.brake_into_s22()
    assert bench.command is None
    assert bench.state.shadow


def test_in_shadow_mode_a_demand_that_never_comes_is_a_warning_said_once() -> None:
    said: list[tuple[str, str]] = []
    processor = WheelProcessor("front_left", VEHICLE, replace(P, shadow=True), lambda *each: said.append(each))
    for k in range(1, 200):
        for topic, message in (*turning(k * STEP), pressure(k * STEP, 0.0)):
            processor.process(topic, message)
        processor.process(VOTE, vote(k * STEP, 500.0))
    assert processor.health().level is Level.WARN
    assert "brake_demand" in processor.health().message
    assert [severity for severity, text in said if "brake_demand" in text] == ["warning"]


def test_jump_back_in_time_returns_to_s0_and_goes_on() -> None:
    bench = Bench()
    for _ in range(40):
        bench.sample(500.0)
    bench.brake_into_s22()
    lasted = f"{(bench.stamp - (BEFORE + 1) * STEP) / 1e9:.2f} s"
    bench.stamp = 0
    bench.sample(500.0, torque=0.0)
    assert bench.name == "S0"
    assert bench.state.cause == SupervisorState.CAUSE_RESET
    told = [each for each in bench.said if each[0] != "debug"]
    assert told == [
        ("info", f"{VOTE}: stamps jumped back, front_left starts again"),
        ("info", f"front_left: braked for {lasted}, releases: 1, last cause: reset"),
    ]
    assert bench.sample(500.0) == "S1"


def test_demand_of_another_wheel_does_not_count() -> None:
    bench = Bench()
    for k in range(5, 80):
        bench.processor.process("brake_demand", demand(k * STEP, 500.0, wheel="rear_left"))
        for topic, message in (*turning(k * STEP), pressure(k * STEP, 0.0), (VOTE, vote(k * STEP, 500.0))):
            outputs = bench.processor.process(topic, message)
            if outputs:
                bench.take(outputs)
    assert bench.name == "S0"
    assert bench.state.validity.reason == Reason.NO_DEMAND


def pressed(processor: WheelProcessor, stamp: int, torque: float) -> str:
    for topic, message in (*turning(stamp), pressure(stamp, torque)):
        processor.process(topic, message)
    outputs = processor.process(VOTE, vote(stamp, nan, reason=Reason.NO_EXCITATION))
    return ("S0", "S1", "S21", "S22")[outputs[0][1].state]


def test_without_a_demand_topic_braking_follows_the_torque_with_hysteresis() -> None:
    processor = WheelProcessor("front_left", VEHICLE, BY_PRESSURE)
    assert "front_left/brake_pressure" in processor.sensors
    stamps = iter(range(STEP, 10**12, STEP))
    assert [pressed(processor, next(stamps), torque) for torque in (0.0, 49.0, 50.0, 21.0)] == ["S0", "S0", "S1", "S1"]
    held = [pressed(processor, next(stamps), 0.0) for _ in range(60)]
    assert held.index("S0") * STEP * 1e-9 == pytest.approx(P.pressure.release_hold, abs=0.0051)


def test_garbage_is_refused_as_demand_and_as_pressure() -> None:
    said: list[str] = []
    for parameters, topic, kind in (
        (P, "brake_demand", BrakeDemand),
        (BY_PRESSURE, "front_left/brake_pressure", FluidPressure),
    ):
        processor = WheelProcessor("front_left", VEHICLE, parameters, lambda severity, text: said.append(text))
        message = kind(header=Header(stamp=from_nanoseconds(STEP)))
        field = "pressure" if kind is BrakeDemand else "fluid_pressure"
        for garbage in (nan, inf, 1e12):
            setattr(message, field, garbage)
            assert processor.process(topic, message) == []
            assert topic in said[-1]
            assert "not a brake pressure" in said[-1]
    assert len(said) == 6


def test_pressure_is_taken_for_the_time_at_which_it_acted() -> None:
    processor = WheelProcessor("front_left", replace(VEHICLE, brake_pressure_delay=0.01), BY_PRESSURE)
    torques = [0.0] * 9 + [500.0] * 9
    for k, torque in enumerate(torques, 1):
        for topic, message in (*turning(k * STEP), pressure((k + 2) * STEP, torque)):
            processor.process(topic, message)
        ((_, state), *_) = processor.process(VOTE, vote(k * STEP, nan, reason=Reason.NO_EXCITATION))
        assert state.demand_torque == pytest.approx(torque)


def test_brake_gain_is_that_of_the_wheel() -> None:
    wheel = VEHICLE.wheel("front_left")
    strong = replace(VEHICLE, wheels=(replace(wheel, brake_gain=2.0 * K),))
    processor = WheelProcessor("front_left", strong, P)
    processor.process("brake_demand", demand(STEP, 300.0))
    for topic, message in (*turning(STEP), pressure(STEP, 0.0)):
        processor.process(topic, message)
    assert processor.process(VOTE, vote(STEP, 0.0))[0][1].demand_torque == pytest.approx(600.0)


def test_reset_starts_again() -> None:
    bench = Bench()
    bench.brake_into_s22()
    bench.processor.reset()
    bench.stamp = 0
    assert bench.sample(500.0, torque=0.0) == "S0"
    assert bench.debug.transitions == 0


NUMBERS = st.one_of(st.floats(allow_nan=True, allow_infinity=True), st.sampled_from([0.0, nan, inf, -inf, 1e300]))
TOPICS = (
    VOTE,
    "brake_demand",
    "wheel_states",
    "front_left/slip",
    "front_left/brake_pressure",
    "front_left/friction_curve",
)
MESSAGES = st.tuples(st.sampled_from(TOPICS), st.integers(-2, 20), NUMBERS, NUMBERS, st.integers(0, 20))


def hostile(topic: str, stamp: int, a: float, b: float, reason: int) -> Any:
    header = Header(stamp=from_nanoseconds(stamp))
    known = reason % 2 == 0
    return {
        VOTE: lambda: SlopeVote(header=header, h=a, indicator=b, validity=Validity(valid=known, reason=reason)),
        "brake_demand": lambda: BrakeDemand(header=header, pressure=a),
        "wheel_states": lambda: JointState(header=header, name=["front_left"], velocity=[a]),
        "front_left/slip": lambda: WheelSlip(
            header=header, slip=a, slip_stddev=b, vehicle_speed=b, validity=Validity(valid=known)
        ),
        "front_left/brake_pressure": lambda: FluidPressure(header=header, fluid_pressure=a),
        "front_left/friction_curve": lambda: FrictionCurve(
            header=header, lambda_max=a, lambda_max_stddev=b, samples=100, validity=Validity(reason=reason)
        ),
    }[topic]()


@given(st.lists(MESSAGES, max_size=60))
def test_hostile_streams_give_known_states_and_commands_and_no_exception(stream: list[Any]) -> None:
    processor = WheelProcessor("front_left", VEHICLE, P)
    for topic, step, a, b, reason in stream:
        for name, answer in processor.process(topic, hostile(topic, max(step, 0) * STEP, a, b, reason)):
            if name.endswith("brake_command"):
                assert answer.command in list(range(4))
            elif name.endswith("abs_supervisor"):
                assert answer.state in range(4)
                assert answer.validity.valid == (answer.validity.reason == Reason.OK)
            assert serialize_message(answer)


def states(wheel: str) -> dict[str, type]:
    return {f"{wheel}/abs_supervisor": SupervisorState, f"{wheel}/abs_supervisor_debug": SupervisorDebug}


def test_shipped_parameter_file_holds_the_defaults_and_commands_no_brake() -> None:
    parameters = load(SupervisorParameters, CONFIG, "abs_supervisor")
    assert parameters == SHIPPED["abs_supervisor"].parameters == SupervisorParameters()
    assert parameters.shadow
    for vehicle in (VEHICLE, load_vehicle("chapter_car")):
        assert [processor.outputs for processor in build(parameters, vehicle)] == [
            states(wheel) for wheel in vehicle.wheel_names
        ]


def test_every_wheel_of_the_car_is_commanded_where_that_is_chosen() -> None:
    car = load_vehicle("chapter_car")
    assert [processor.outputs for processor in build(SupervisorParameters(shadow=False), car)] == [
        {**states(wheel), f"{wheel}/brake_command": BrakeCommand} for wheel in car.wheel_names
    ]


def test_thresholds_are_those_of_the_votes_it_goes_with() -> None:
    shipped = CONFIG.parents[2] / "friction_slope" / "config" / "friction_slope.yaml"
    votes = load(FrictionSlopeParameters, shipped, "friction_slope").vote
    thresholds = load(SupervisorParameters, CONFIG, "abs_supervisor").thresholds
    assert (votes.h_instability, votes.h_stability) == (thresholds.h_instability, thresholds.h_stability)


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ({"thresholds": {"h_instability": 1.0}}, "thresholds.h_instability"),
        ({"thresholds": {"h_stability": -1.0}}, "thresholds.h_stability"),
        ({"braking_source": "pressure", "pressure": {"release_torque": 60.0}}, "pressure.release_torque"),
        ({"braking_source": "pressure", "braking_torque": 20.0}, "braking_torque"),
        ({"braking_source": "pedal"}, "braking_source"),
    ],
)
def test_bad_parameters_are_refused_by_name(values: dict[str, Any], named: str) -> None:
    with pytest.raises(ParameterError, match=named):
        from_mapping(SupervisorParameters, values)


def test_hysteresis_set_for_a_demand_is_ignored_and_said() -> None:
    beside = changed(SupervisorParameters(), {"pressure.release_torque": 60.0})
    assert ignored(beside) == [
        "pressure.release_torque: ignored, as 'braking_source' is 'demand', not pressure",
    ]
    by_pressure = replace(SupervisorParameters(), braking_source="pressure", pressure=PressureParameters(10.0))
    assert ignored(by_pressure) == []


def test_locked_wheel_whose_h_is_unknown_is_released() -> None:
    bench = Bench()
    bench.sample(500.0)
    bench.stamp += STEP
    bench.sense(500.0)
    locked = vote(bench.stamp, -1e5)
    locked.h = nan
    bench.take(bench.processor.process(VOTE, locked))
    assert bench.name == "S21"


@pytest.mark.parametrize("reason", [Reason.BAD_INPUT, Reason.NOT_BRAKING, Reason.NO_EXCITATION])
def test_indicator_of_a_vote_that_does_not_count_releases_nothing(reason: int) -> None:
    bench = Bench()
    bench.sample(500.0)
    for _ in range(300):
        bench.sample(-1e5, reason=reason)
        assert bench.command != BrakeCommand.DECREASE


def test_law_alone_releases_nothing() -> None:
    bench = Bench()
    bench.slip = 0.05
    bench.sample(500.0, torque=0.0)
    for _ in range(60):
        bench.sample(-1e5)
        assert bench.command == BrakeCommand.INCREASE
    assert bench.state.release == SupervisorState.RELEASE_REFUSED
    assert bench.state.refused_releases >= 1
    assert bench.state.slip == pytest.approx(0.05)
    assert bench.debug.release_slip > 0.2


def test_a_wheel_that_dives_is_released_and_its_intervention_and_budget_are_in_the_state() -> None:
    bench, strong = Bench(), 5000.0
    bench.slip = 0.0
    for _ in range(130):
        bench.sample(500.0, torque=strong)
    assert bench.command == BrakeCommand.INCREASE
    assert bench.state.intervention == SupervisorState.STANDBY
    for k in range(1, 13):
        bench.slip = 0.025 * k
        bench.sample(500.0, torque=strong)
    while bench.sample(-200.0, torque=strong) != "S22":
        pass
    assert bench.command == BrakeCommand.DECREASE
    assert bench.state.intervention == SupervisorState.ACTIVE
    assert bench.state.budget < 1.0


def test_curve_lowers_the_slip_that_a_release_needs_once_it_is_50_ms_old() -> None:
    bench, came = Bench(), 0
    for k in range(40):
        bench.sample(500.0)
        if k == 10:
            header = Header(stamp=from_nanoseconds(bench.stamp))
            curve = FrictionCurve(header=header, samples=30, validity=Validity(valid=True), **PEAK)
            assert bench.processor.process("front_left/friction_curve", curve) == []
            came = bench.stamp
        if not came or bench.stamp - came not in range(50_000_000, 60_000_000):
            assert (bench.debug.release_slip < 0.15) == (came > 0 and bench.stamp >= came + 60_000_000)


@pytest.mark.parametrize("real_time", [False, True])
def test_a_curve_that_counts_is_waited_for_where_no_clock_tells_that_it_has_come(real_time: bool) -> None:
    bench = Bench(replace(P, real_time=real_time))

    def curve(stamp: int) -> list[Any]:
        message = FrictionCurve(
            header=Header(stamp=from_nanoseconds(stamp)), samples=30, validity=Validity(valid=True), **PEAK
        )
        return list(bench.processor.process("front_left/friction_curve", message))

    for _ in range(20):
        bench.sample(500.0)
        assert curve(bench.stamp) == []
    last = bench.stamp
    answered = 0
    while bench.stamp < last + 60_000_000:
        bench.sample(500.0)
        answered += bench.command is not None
    assert answered == (12 if real_time else 10)
    outputs = curve(last + STEP)
    assert [message.header.stamp for topic, message in outputs if topic.endswith("brake_command")] == (
        [] if real_time else [from_nanoseconds(last + 55_000_000)]
    )


def test_curve_counts_for_a_moment_after_the_last_one_that_had_a_peak() -> None:
    bench = Bench()
    bench.slip = 0.05
    for _ in range(40):  # the dive before is forgotten
        bench.sample(500.0)
    came = {}
    for k in range(260):
        bench.sample(500.0)
        header = Header(stamp=from_nanoseconds(bench.stamp))
        curve = FrictionCurve(header=header, samples=30, validity=Validity(valid=k < 20), **PEAK)
        curve.validity.reason = Reason.OK if k < 20 else Reason.NO_PEAK
        bench.processor.process("front_left/friction_curve", curve)
        came[k] = bench.debug.release_slip
    assert came[19] < 0.15
    assert max(came[k] for k in range(20, 50)) < 0.15
    assert min(came[k] for k in range(70, 260)) >= 0.2


def test_dead_wheel_sensor_gives_the_brake_to_the_driver_and_says_so() -> None:
    bench = Bench()
    bench.slip = 0.05
    for _ in range(30):
        bench.sample(500.0)
    died = bench.stamp
    bench.slip = 1.0
    while bench.state.validity.reason != Reason.WHEEL_SENSOR:
        bench.sample(-1e5)
    assert bench.stamp - died <= 50_000_000
    assert bench.command == BrakeCommand.NONE
    assert "dead" in bench.state.validity.text
    health = bench.processor.health()
    assert health.level is Level.ERROR
    assert "dead" in health.message


@pytest.mark.parametrize(("rear", "acts"), [(10.0, True), (0.1, False)])
def test_wheel_that_slides_too_slowly_for_its_slope_keeps_its_abs_while_others_turn(rear: float, acts: bool) -> None:
    """Without slip friction_slope knows the speed of its own wheel only [rad/s], and calls that near standstill."""
    car = load_vehicle("compact_car")
    processor = WheelProcessor("front_left", car, P)
    state, commands = SupervisorState(), set()
    for k in range(1, 80):
        stamp, front = k * STEP, max(40.0 - 1.0 * max(k - 10, 0), 2.0)
        header, low = Header(stamp=from_nanoseconds(stamp)), front < 5.0
        speeds = {"front_left": front, "front_right": front, "rear_left": rear, "rear_right": rear}
        wheels = JointState(header=header, name=list(speeds), velocity=[v + 1e-3 * (k % 2) for v in speeds.values()])
        for topic, message in (
            ("brake_demand", demand(stamp, 300.0)),
            ("wheel_states", wheels),
            (
                "front_left/slip",
                WheelSlip(header=header, vehicle_speed=nan, validity=Validity(reason=Reason.BAD_INPUT)),
            ),
            pressure(stamp, 300.0),
            (VOTE, vote(stamp, 500.0, reason=Reason.LOW_SPEED if low else Reason.OK)),
        ):
            for output, answer in processor.process(topic, message):
                if output.endswith("abs_supervisor"):
                    state = answer
                elif low and output.endswith("brake_command"):
                    commands.add(answer.command)
    assert (state.state != SupervisorState.S0) == acts
    assert (BrakeCommand.DECREASE in commands) == acts
    assert (state.validity.reason == Reason.LOW_SPEED) != acts


def test_missing_inputs_are_named_and_fail_safe() -> None:
    for missing, reason in (
        ("wheel_states", Reason.NO_WHEEL_SPEED),
        ("front_left/brake_pressure", Reason.NO_PRESSURE),
    ):
        bench = Bench()
        bench.brake_into_s22()
        for _ in range(40):
            bench.stamp += STEP
            given = [*turning(bench.stamp), pressure(bench.stamp, 500.0), ("brake_demand", demand(bench.stamp, 500.0))]
            for topic, message in (*given, (VOTE, vote(bench.stamp, -200.0))):
                outputs = bench.processor.process(topic, message) if topic != missing else []
                if outputs:
                    bench.take(outputs)
        assert bench.name == "S0"
        assert bench.command == BrakeCommand.NONE
        assert bench.state.validity.reason == reason
        assert missing in bench.state.validity.text


def test_state_says_what_was_not_checked() -> None:
    bench = Bench()
    bench.sample(500.0)
    assert "no friction curve" in bench.state.unchecked
    assert "no other wheel" in bench.state.unchecked
    shadow = Bench(replace(P, shadow=True))
    assert "pressure" in shadow.state.unchecked


def test_the_brake_is_handed_over_for_the_newest_sample_by_a_command_that_counts_on() -> None:
    bench = Bench()
    bench.brake_into_s22()
    assert bench.command == BrakeCommand.DECREASE
    ((topic, command),) = bench.processor.hand_over()
    assert (topic, command.command, command.counter) == (
        "front_left/brake_command",
        BrakeCommand.NONE,
        bench.counter + 1,
    )
    assert command.header.stamp == from_nanoseconds(bench.stamp)


def test_nothing_is_handed_over_before_the_first_sample_or_in_shadow_mode() -> None:
    assert list(WheelProcessor("front_left", VEHICLE, P).hand_over()) == []
    bench = Bench(replace(P, shadow=True))
    bench.sample(500.0)
    assert list(bench.processor.hand_over()) == []
