"""The machine of modes: total, and what no evidence may do."""

from itertools import product
from math import inf, nan
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheel_slip.estimate import SOURCES, Mode, SpeedSource
from wheel_slip.mode import Cause, Evidence, transition
from wheel_slip.tuning import SlideTuning

SHIPPED = SlideTuning()
ROLLING = {Mode.ROLLING, Mode.SENSOR_ROLLING}
SENSOR = {Mode.SENSOR_ROLLING, Mode.SENSOR_SLIDING}
NUMBERS = st.one_of(st.floats(allow_nan=True, allow_infinity=True), st.sampled_from([-1.0, 0.0, 0.3, 1.0, 2.0, 3.0]))
EVIDENCE = st.builds(
    Evidence,
    sensor=st.booleans(),
    speed_at_wheels=st.booleans(),
    wheels_roll=st.booleans(),
    pulled=st.booleans(),
    acceleration=NUMBERS,
    calm=st.booleans(),
    agree=st.booleans(),
    rolled=NUMBERS,
    steady=NUMBERS,
)


def evidence(**changes: Any) -> Evidence:
    """Wheels that slide under a car of which nothing else is known, but for some changes."""
    nothing = Evidence(False, True, False, False, 2.0, False, False, -1.0, -1.0)
    return nothing._replace(**changes)


def test_every_mode_answers_every_class_of_evidence_and_changes_exactly_where_there_is_a_cause() -> None:
    numbers = ((nan, 0.0, 0.5, 2.8, 9.0, inf), (nan, -1.0, 0.5, 1.5, inf), (nan, -1.0, 1.0, inf))
    reached = set()
    for mode, flags, (a, rolled, steady) in product(Mode, product((False, True), repeat=6), product(*numbers)):
        sensor, speed, roll, pulled, calm, agree = flags
        seen = Evidence(sensor, speed, roll, pulled, a, calm, agree, rolled, steady)
        after, cause = transition(mode, seen, SHIPPED)
        assert (after is mode) == (cause is Cause.NONE)
        reached |= {after, cause}
    assert reached == {*Mode, *Cause} - {Cause.STARTED}


@given(mode=st.sampled_from(Mode), seen=EVIDENCE)
def test_a_mode_has_a_sensor_where_one_is_there_and_never_where_none_is(mode: Mode, seen: Evidence) -> None:
    after, _ = transition(mode, seen, SHIPPED)
    assert (after in SENSOR) == seen.sensor
    assert (SOURCES[after] is SpeedSource.SENSOR) == seen.sensor


@given(mode=st.sampled_from(Mode), seen=EVIDENCE)
def test_a_change_of_the_sensor_leaves_the_trust_in_the_wheels_as_it_was(mode: Mode, seen: Evidence) -> None:
    after, cause = transition(mode, seen, SHIPPED)
    if cause in (Cause.SENSOR, Cause.NO_SENSOR):
        assert (after in ROLLING) == (mode in ROLLING)


@given(mode=st.sampled_from(sorted(set(Mode) - ROLLING)), seen=EVIDENCE)
def test_wheels_that_do_not_roll_are_trusted_only_where_they_turn_alike_for_long(mode: Mode, seen: Evidence) -> None:
    after, cause = transition(mode, seen._replace(wheels_roll=False), SHIPPED)
    if after in ROLLING:
        assert cause is Cause.AGAINST_ACCELEROMETER
        assert seen.steady >= SHIPPED.steady_time


@given(mode=st.sampled_from(Mode), seen=EVIDENCE)
def test_a_speed_once_known_is_never_given_up(mode: Mode, seen: Evidence) -> None:
    after, _ = transition(mode, seen, SHIPPED)
    assert after is not Mode.WAITING or mode is Mode.WAITING


@given(seen=EVIDENCE)
def test_without_speed_at_wheels_and_sensor_it_goes_on_waiting(seen: Evidence) -> None:
    nothing = seen._replace(sensor=False, speed_at_wheels=False)
    assert transition(Mode.WAITING, nothing, SHIPPED) == (Mode.WAITING, Cause.NONE)


@given(mode=st.sampled_from(Mode), seen=EVIDENCE)
def test_the_same_evidence_does_not_trust_the_wheels_and_distrust_them_again(mode: Mode, seen: Evidence) -> None:
    """Within what the evidence can be: wheels that have rolled were below roll_below, or pulled, all the time."""
    weak = seen.pulled or seen.acceleration <= SHIPPED.roll_below
    possible = seen._replace(rolled=seen.rolled if weak and seen.wheels_roll else -1.0, steady=-1.0)
    after, _ = transition(mode, possible, SHIPPED)
    if after in ROLLING and mode not in ROLLING:
        assert transition(after, possible, SHIPPED) == (after, Cause.NONE)


@pytest.mark.parametrize(
    ("mode", "seen", "expected"),
    [
        (Mode.WAITING, evidence(sensor=True), (Mode.SENSOR_SLIDING, Cause.SENSOR)),
        (Mode.ROLLING, evidence(sensor=True, wheels_roll=False), (Mode.SENSOR_ROLLING, Cause.SENSOR)),
        (Mode.SENSOR_SLIDING, evidence(), (Mode.SLIDING, Cause.NO_SENSOR)),
        (Mode.ROLLING, evidence(wheels_roll=True, acceleration=3.1), (Mode.SLIDING, Cause.STRONG)),
        (Mode.ROLLING, evidence(wheels_roll=True, acceleration=3.1, pulled=True), (Mode.ROLLING, Cause.NONE)),
        (Mode.ROLLING, evidence(), (Mode.SLIDING, Cause.WHEELS_SLIDE)),
        (Mode.SLIDING, evidence(wheels_roll=True, rolled=0.31, agree=True), (Mode.ROLLING, Cause.AGREED)),
        (Mode.SLIDING, evidence(wheels_roll=True, rolled=0.29, agree=True), (Mode.SLIDING, Cause.NONE)),
        (Mode.SLIDING, evidence(wheels_roll=True, rolled=0.31, pulled=True), (Mode.ROLLING, Cause.PULLED)),
        (Mode.SLIDING, evidence(wheels_roll=True, rolled=0.9, calm=True), (Mode.SLIDING, Cause.NONE)),
        (Mode.SLIDING, evidence(wheels_roll=True, rolled=1.1, calm=True), (Mode.ROLLING, Cause.CALM)),
        (Mode.SLIDING, evidence(wheels_roll=True, rolled=1.1, acceleration=0.5), (Mode.SLIDING, Cause.NONE)),
        (Mode.SLIDING, evidence(wheels_roll=True, steady=2.1), (Mode.ROLLING, Cause.STEADY)),
        (Mode.SLIDING, evidence(steady=2.1), (Mode.ROLLING, Cause.AGAINST_ACCELEROMETER)),
    ],
)
def test_transitions_are_those_of_the_table(mode: Mode, seen: Evidence, expected: tuple[Mode, Cause]) -> None:
    assert transition(mode, seen, SHIPPED) == expected
