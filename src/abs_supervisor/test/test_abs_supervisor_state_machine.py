"""The state machine of Figure 8.1, explored over all states and all classes of input."""

from itertools import product
from math import inf, nan

import pytest

from abs_supervisor.state_machine import COMMANDS, Cause, Inputs, State, Thresholds, transition
from vehicle_models.brake_actuator import Command

T = Thresholds(h_instability=-100.0, h_stability=1000.0, wait=0.04, release_timeout=0.08)
INDICATORS = (nan, -inf, -100.1, -100.0, -99.9, 0.0, 999.9, 1000.0, 1000.1, inf)
TIMES = (0.0, 0.039, 0.04, 0.079, 0.08, 10.0)
EVERY = list(product(State, (False, True), INDICATORS, (False, True), (False, True), (False, True), TIMES))
EDGES = {
    (State.S0, State.S1): {Cause.BRAKING},
    (State.S1, State.S21): {Cause.INSTABILITY},
    (State.S21, State.S22): {Cause.WAIT_OVER},
    (State.S22, State.S1): {Cause.STABILITY, Cause.RELEASE_TIMEOUT},
    **{(state, State.S0): {Cause.BRAKING_OVER, Cause.FAIL_SAFE, Cause.LOW_SPEED} for state in State if state},
}


def step(
    state: State,
    *,
    braking: bool = True,
    indicator: float = nan,
    growing: bool = True,
    failed: bool = False,
    slow: bool = False,
    time: float = 0.0,
) -> tuple[State, Cause]:
    return transition(state, Inputs(braking, indicator, growing, failed, slow), time, T)


def test_every_state_and_input_has_a_next_state_along_an_edge_of_the_figure() -> None:
    seen: dict[tuple[State, State], set[Cause]] = {}
    for state, braking, indicator, growing, failed, slow, time in EVERY:
        after, cause = transition(state, Inputs(braking, indicator, growing, failed, slow), time, T)
        if after is state:
            assert cause is Cause.NONE
        else:
            seen.setdefault((state, after), set()).add(cause)
    assert seen == EDGES


def test_every_failure_ends_in_s0_from_anywhere() -> None:
    for state, braking, indicator, growing, _, slow, time in EVERY:
        assert transition(state, Inputs(braking, indicator, growing, True, slow), time, T)[0] is State.S0


def test_no_state_is_kept_without_braking_or_at_low_speed() -> None:
    for state, _, indicator, growing, failed, slow, time in EVERY:
        assert transition(state, Inputs(False, indicator, growing, failed, slow), time, T)[0] is State.S0
        assert transition(state, Inputs(True, indicator, growing, failed, True), time, T)[0] is State.S0


def test_indicator_matters_in_s1_and_s22_only() -> None:
    for state, (braking, growing, failed, slow), time in product(
        (State.S0, State.S21), product((False, True), repeat=4), TIMES
    ):
        results = {transition(state, Inputs(braking, h, growing, failed, slow), time, T) for h in INDICATORS}
        assert len(results) == 1


def test_more_negative_indicator_never_makes_instability_less_likely() -> None:
    ordered = sorted(h for h in INDICATORS if h == h)
    left = [step(State.S1, indicator=h)[0] is State.S21 for h in ordered]
    assert left == sorted(left, reverse=True)
    back = [step(State.S22, indicator=h, growing=False)[0] is State.S1 for h in ordered]
    assert back == sorted(back)


@pytest.mark.parametrize(("indicator", "after"), [(-99.9, State.S1), (-100.0, State.S21), (nan, State.S1)])
def test_stability_is_lost_at_or_below_the_negative_threshold(indicator: float, after: State) -> None:
    assert step(State.S1, indicator=indicator)[0] is after


@pytest.mark.parametrize(("indicator", "after"), [(999.9, State.S22), (1000.0, State.S1), (nan, State.S22)])
def test_stability_is_regained_at_or_above_the_positive_threshold(indicator: float, after: State) -> None:
    assert step(State.S22, indicator=indicator, growing=False)[0] is after


def test_peak_is_not_crossed_against_the_direction_of_the_slip() -> None:
    assert step(State.S1, indicator=-inf, growing=False) == (State.S1, Cause.NONE)
    assert step(State.S22, indicator=inf, growing=True) == (State.S22, Cause.NONE)


def test_s21_waits_n_ms_whatever_the_indicator_says() -> None:
    assert step(State.S21, indicator=inf, growing=False, time=0.039) == (State.S21, Cause.NONE)
    assert step(State.S21, indicator=inf, growing=False, time=0.04) == (State.S22, Cause.WAIT_OVER)


def test_release_ends_by_time_and_the_indicator_has_precedence() -> None:
    assert step(State.S22, time=0.08) == (State.S1, Cause.RELEASE_TIMEOUT)
    assert step(State.S22, time=0.08, indicator=1000.0, growing=False) == (State.S1, Cause.STABILITY)
    assert step(State.S22, time=0.079) == (State.S22, Cause.NONE)


def test_causes_of_the_way_out_are_distinguished() -> None:
    assert step(State.S22, failed=True, braking=False)[1] is Cause.FAIL_SAFE
    assert step(State.S22, braking=False, slow=True)[1] is Cause.BRAKING_OVER
    assert step(State.S22, slow=True)[1] is Cause.LOW_SPEED


def test_braking_begins_only_with_good_inputs() -> None:
    assert step(State.S0) == (State.S1, Cause.BRAKING)
    assert step(State.S0, failed=True) == (State.S0, Cause.NONE)
    assert step(State.S0, slow=True) == (State.S0, Cause.NONE)


def test_a_stop_on_a_slippery_road_walks_through_the_figure() -> None:
    walk = [
        dict(braking=False),
        dict(braking=True),
        dict(indicator=500.0),
        dict(indicator=-200.0),
        dict(indicator=-200.0, time=0.01),
        dict(time=0.04),
        dict(indicator=-50.0, growing=False, time=0.01),
        dict(indicator=2000.0, growing=False, time=0.02),
        dict(braking=False),
    ]
    state, path = State.S0, []
    for inputs in walk:
        state, _ = step(state, **inputs)  # type: ignore[arg-type]
        path.append(state.name)
    assert path == ["S0", "S1", "S1", "S21", "S21", "S22", "S22", "S1", "S0"]


def test_commands_are_those_of_section_8_2_2() -> None:
    assert COMMANDS == {
        State.S0: Command.NONE,
        State.S1: Command.INCREASE,
        State.S21: Command.DECREASE,
        State.S22: Command.DECREASE,
    }


def test_numbers_are_those_of_the_messages() -> None:
    from friction_msgs.msg import BrakeCommand, SupervisorState

    assert {state.name: int(state) for state in State} == {n: getattr(SupervisorState, n) for n in State.__members__}
    for cause in Cause:
        assert getattr(SupervisorState, f"CAUSE_{cause.name}") == cause
    for command in Command:
        assert getattr(BrakeCommand, command.name) == command


@pytest.mark.parametrize(
    "bad",
    [
        dict(h_instability=0.0),
        dict(h_stability=0.0),
        dict(h_instability=nan),
        dict(wait=-0.1),
        dict(release_timeout=0.0),
    ],
)
def test_thresholds_of_the_wrong_sign_are_refused(bad: dict[str, float]) -> None:
    good = dict(h_instability=-1.0, h_stability=1.0, wait=0.0, release_timeout=0.1)
    with pytest.raises(ValueError):
        Thresholds(**(good | bad))
