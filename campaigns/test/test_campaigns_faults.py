"""The fault campaign: its faults act as named, its numbers are right, and its shortest rows pass."""

from argparse import Namespace
from collections.abc import Sequence
from dataclasses import replace
from math import inf

import numpy as np
import pytest
from friction_msgs.msg import BrakeCommand, BrakeDemand
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Header

from benchmarks.protocol import DT, SPEED
from benchmarks.runner import load_part
from campaigns.faults import sensors, transport
from campaigns.faults.case import (
    BEFORE_BRAKING,
    CORNER,
    FOUR_WHEELS,
    ONSET,
    Arrival,
    Case,
    Fault,
    Hit,
    Manoeuvre,
    Site,
    frozen,
    lagging,
    silent,
)
from campaigns.faults.catalogue import FAULTS, LOCKED_START, NO_FAULT, quick, whole
from campaigns.faults.loop import Loop, Record
from campaigns.faults.measures import Measures, Reference, limits, measure, without_abs
from corner_sim.plant import SAMPLE_TIME_NS
from friction_runtime.messages import from_nanoseconds, to_nanoseconds
from vehicle_models import burckhardt
from vehicle_models.surfaces import surface

START = 10_000_000_000_000
SPEEDS = [99.0, 100.0, 101.0, 102.0]
DRY = Manoeuvre(CORNER, "dry", 1.5)


@pytest.fixture
def site() -> Site:
    return Site(Manoeuvre(FOUR_WHEELS, "dry", 0.6).vehicle, np.random.default_rng(0))


def wheel_states(sample: int) -> JointState:
    header = Header(stamp=from_nanoseconds(START + sample * SAMPLE_TIME_NS))
    return JointState(header=header, name=["a", "b", "c", "d"], velocity=list(SPEEDS))


def arrivals(fault: Fault, samples: int) -> list[Arrival]:
    return [each for k in range(samples) for each in fault("wheel_states", wheel_states(k))]


def first_wheel(found: Sequence[Arrival]) -> list[float]:
    return [each.message.velocity[0] for each in found]


def stamps_of(found: Sequence[Arrival]) -> list[int]:
    return [to_nanoseconds(each.message.header.stamp) - START for each in found]


def test_a_dead_sensor_reads_zero_and_leaves_the_other_wheels_and_topics_alone(site: Site) -> None:
    found = arrivals(sensors.dead(site), 3)
    assert all(list(each.message.velocity) == [0.0, *SPEEDS[1:]] for each in found)
    assert stamps_of(found) == [0, SAMPLE_TIME_NS, 2 * SAMPLE_TIME_NS]
    (passed,) = sensors.dead(site)("brake_demand", BrakeDemand(pressure=3.0))
    assert passed.message == BrakeDemand(pressure=3.0)


def test_a_flickering_sensor_reads_zero_now_and_then(site: Site) -> None:
    read = first_wheel(arrivals(sensors.flickering(site), 1000))
    assert set(read) == {0.0, SPEEDS[0]}
    assert 0.01 < read.count(0.0) / 1000 < 0.5


def test_noise_has_three_times_the_standard_deviation_of_the_chapter(site: Site) -> None:
    read = np.array(first_wheel(arrivals(sensors.noisy(site), 5000)))
    assert np.hypot(read.std(), np.sqrt(0.005)) == pytest.approx(3.0 * np.sqrt(0.005), rel=0.05)


def test_ripple_has_two_per_cent_once_a_revolution(site: Site) -> None:
    read = np.array(first_wheel(arrivals(sensors.rippled(site), 2000))) / SPEEDS[0] - 1.0
    assert np.abs(read).max() == pytest.approx(0.02, rel=0.01)
    periods = np.count_nonzero((read[:-1] < 0.0) & (read[1:] >= 0.0))
    assert periods == pytest.approx(2000 * DT * SPEEDS[0] / (2.0 * np.pi), abs=1.0)


def test_a_wheel_that_is_missing_leaves_the_others_in_their_places(site: Site) -> None:
    (found,) = sensors.missing(site)("wheel_states", wheel_states(0))
    assert (list(found.message.name), list(found.message.velocity)) == (["b", "c", "d"], SPEEDS[1:])


def test_stamps_repeat_crawl_step_back_or_are_zero(site: Site) -> None:
    topics = ["wheel_states"]
    assert stamps_of(arrivals(transport.repeating(topics), 4)) == [0, 0, 0, 0]
    assert stamps_of(arrivals(transport.zero(topics), 2)) == [-START, -START]
    assert stamps_of(arrivals(transport.crawling(topics), 3)) == [0, 5, 10]
    assert stamps_of(arrivals(transport.shifted(topics, -0.05), 2)) == [-50_000_000, -45_000_000]


def test_a_clock_that_jumps_is_that_of_the_sensors_and_of_the_brake(site: Site) -> None:
    fault = transport.clock_jump(site, ["wheel_states"], 3600.0)
    (measured,) = fault("wheel_states", wheel_states(0))
    topic = f"{site.wheel}/brake_command"
    (answered,) = fault(topic, BrakeCommand(header=measured.message.header))
    assert stamps_of([measured, answered]) == [3_600_000_000_000, 0]


def test_a_frozen_sender_repeats_its_first_message_and_a_lagging_one_its_values_only() -> None:
    assert stamps_of(arrivals(frozen(["wheel_states"]), 3)) == [0, 0, 0]
    fault = lagging(["p"], "fluid_pressure", 2)
    read = [fault("p", FluidPressure(fluid_pressure=float(k)))[0].message.fluid_pressure for k in range(5)]
    assert read == [0.0, 0.0, 0.0, 1.0, 2.0]


def test_messages_are_lost_doubled_or_late_in_the_share_that_is_asked_for(site: Site) -> None:
    topics = ["wheel_states"]
    assert not arrivals(silent(topics), 3)
    assert len(arrivals(transport.dropped(site, topics, 0.2), 2000)) == pytest.approx(1600, rel=0.1)
    assert len(arrivals(transport.duplicated(site, topics, 0.2), 2000)) == pytest.approx(2400, rel=0.1)
    late = [each.delay for each in arrivals(transport.late(site, topics, 0.2, 0.007), 2000)]
    assert set(late) == {0.0, 0.007}
    assert late.count(0.007) == pytest.approx(400, rel=0.2)


def test_a_late_message_reaches_the_graph_after_the_next_one() -> None:
    """The first wheel_states of the fault is 7 ms late: two samples have come when it does."""
    seen: list[int] = []

    def make(site: Site) -> Fault:
        sent: list[int] = []

        def pass_on(topic: str, message: JointState) -> list[Arrival]:
            if topic == "wheel_states":
                sent.append(1)
            return [Arrival(0.007 if topic == "wheel_states" and len(sent) == 1 else 0.0, topic, message)]

        return pass_on

    loop = Loop(DRY, Case("late", make, begin=-0.2), 1)
    passed = loop._processors[0].process

    def process(topic: str, message: JointState) -> object:
        if topic == "wheel_states":
            seen.append(to_nanoseconds(message.header.stamp))
        return passed(topic, message)

    loop._processors[0].process = process  # type: ignore[method-assign,assignment]
    loop.run(-0.1)
    (back,) = np.flatnonzero(np.diff(seen) < 0)
    assert np.diff(seen)[back] == -SAMPLE_TIME_NS


def test_the_stop_without_abs_is_that_of_the_momentum() -> None:
    """At 0.3 of the peak torque the wheel rolls, and the brake alone decelerates the corner."""
    manoeuvre = Manoeuvre(CORNER, "dry", 0.3)
    found = without_abs(manoeuvre)
    mu_max = float(burckhardt.peak(surface("dry"))[1])
    assert found.duration == pytest.approx(SPEED / (0.3 * mu_max * 9.81), rel=0.03)
    assert found.distance == pytest.approx(0.5 * SPEED * found.duration, rel=0.03)


def test_a_demand_at_which_a_wheel_locks_without_abs_is_no_ordinary_braking() -> None:
    """At 0.9 of the peak torque of a front wheel at rest the rear ones, relieved of load, are beyond theirs."""
    released = measured(record([1] * 10 + [int(BrakeCommand.DECREASE)] * 40 + [1] * 50, [0.2] * 100, [True] * 100))
    judged = [
        {each.name for each in limits(NO_FAULT, Manoeuvre(FOUR_WHEELS, "dry", demand), released, released)}
        for demand in (0.6, 0.9)
    ]
    assert ["duration ratio" in names for names in judged] == [True, False]
    assert ["lock [s]" in names for names in judged] == [False, True]


@pytest.mark.parametrize(("demand", "beyond"), [(0.7, []), (0.8, [2, 3]), (0.9, [2, 3])])
def test_a_release_counts_at_the_wheels_that_stay_before_their_peak_without_abs(
    demand: float, beyond: list[int]
) -> None:
    """At 0.8 of the peak torque of a front wheel at rest the rear ones pass theirs, though they do not lock."""
    manoeuvre = Manoeuvre(FOUR_WHEELS, "dry", demand)
    stop = without_abs(manoeuvre)
    assert [wheel for wheel, each in enumerate(stop.beyond) if each] == beyond
    for wheel in range(4):
        one = record([1] * 10 + [int(BrakeCommand.DECREASE)] * 40 + [1] * 50, [0.2] * 100, [True] * 100)
        command = np.ones((100, 4), dtype=np.int64)
        command[:, wheel] = one.command[:, 0]
        alike = {name: getattr(one, name).repeat(4, axis=1) for name in ("slip", "slip_error", "acting")}
        run = replace(one, command=command, **alike)
        found = measure(run, NO_FAULT, manoeuvre, stop)
        names = [each.name for each in limits(NO_FAULT, manoeuvre, found, found) if not each.passed]
        assert ("DECREASE of a healthy wheel" in names) == (wheel not in beyond)


def record(command: Sequence[int], slip: Sequence[float], acting: Sequence[bool]) -> Record:
    """Return a run of one wheel, whose first sample is the onset."""
    k = len(command)
    time = np.array([ONSET + DT * i for i in range(k)])
    return Record(
        True, time, np.full(k, 20.0), np.array([20.0 * DT * i for i in range(k)]), np.array(slip)[:, np.newaxis],
        np.full((k, 1), np.nan), np.array(command)[:, np.newaxis], np.array(acting)[:, np.newaxis], inf, "",
    )  # fmt: skip


def reference(wheels: int) -> Reference:
    return Reference(1.0, 10.0, locks=False, beyond=(False,) * wheels, torque=800.0)


def measured(found: Record, case: Case = NO_FAULT) -> Measures:
    return measure(found, case, DRY, reference(found.slip.shape[1]))


def test_measures_of_a_run_whose_numbers_are_known() -> None:
    released = int(BrakeCommand.DECREASE)
    command = [1] * 10 + [released] * 40 + [1] * 50
    slip = [0.01] * 20 + [0.5] * 80  # 10 samples of the release are below half of lambda_max
    found = measured(record(command, slip, [True] * 100))
    assert found.distance == pytest.approx(20.0 * 99 * DT)
    assert found.distance_ratio == pytest.approx(found.distance / 10.0)
    assert found.longest_release == pytest.approx(0.2)
    assert found.wrong_release == pytest.approx(0.05)
    assert found.released == pytest.approx(40 / 99)
    assert found.largest_slip == 0.5


@pytest.mark.parametrize("case", [NO_FAULT, *FAULTS], ids=lambda case: case.name)
def test_a_release_before_the_peak_fails_under_every_fault_where_the_demand_is_below_it(case: Case) -> None:
    released = measured(
        record([1] * 10 + [int(BrakeCommand.DECREASE)] * 5 + [1] * 85, [0.02] * 100, [True] * 100), case
    )
    failed = {
        demand: [
            each.name for each in limits(case, Manoeuvre(CORNER, "dry", demand), released, released) if not each.passed
        ]
        for demand in (0.6, 1.5)
    }
    assert "release below half of lambda_max [s]" in failed[0.6]
    assert "release below half of lambda_max [s]" not in failed[1.5]


def test_a_healthy_wheel_without_abs_is_noticed_and_one_that_is_hit_is_not_healthy() -> None:
    lost = record([1] * 100, [0.01] * 100, [True] * 50 + [False] * 50)
    assert measured(lost).healthy_lost
    assert not measured(lost, Case("of the wheel", NO_FAULT.make, Hit.FIRST_WHEEL, BEFORE_BRAKING)).healthy_lost


def test_a_wheel_that_is_hardly_braked_needs_no_abs() -> None:
    """At 0.3 of the peak torque on snow that is 39 N m: the supervisor does not take it for braking."""
    lost = measured(record([1] * 100, [0.01] * 100, [False] * 100))
    judged = {
        demand: {each.name for each in limits(NO_FAULT, Manoeuvre(CORNER, "snow", demand), lost, lost)}
        for demand in (0.3, 0.5)
    }
    assert ["healthy wheels without ABS" in names for names in judged.values()] == [False, True]


def test_none_is_timed_from_the_last_good_message() -> None:
    """The fault begins at sample 20: the last good message is sample 19, NONE comes at 27."""
    case = Case("lost", NO_FAULT.make, Hit.ALL_WHEELS, begin=20 * DT, none_within=0.05)
    found = measured(record([1] * 27 + [0] * 73, [0.01] * 100, [True] * 100), case)
    assert found.none == pytest.approx(8 * DT)
    names = [each.name for each in limits(case, DRY, found, found) if not each.passed]
    assert "NONE after [s]" not in names
    never = measured(record([1] * 100, [0.01] * 100, [True] * 100), case)
    assert "NONE after [s]" in [each.name for each in limits(case, DRY, never, never) if not each.passed]


def test_the_whole_plan_has_every_fault_on_every_road_and_the_quick_one_is_part_of_it() -> None:
    rows = {(manoeuvre, case.name) for manoeuvre, cases in whole() for case in cases}
    assert len(rows) == sum(len(cases) for _, cases in whole())
    for manoeuvre in {manoeuvre for manoeuvre, _ in rows if manoeuvre.demand in (0.6, 1.5)}:
        assert {name for each, name in rows if each == manoeuvre} >= {case.name for case in (NO_FAULT, *FAULTS)}
    assert {(each, case.name) for each, cases in quick() for case in cases} <= rows
    assert {case.name for _, cases in quick() for case in cases} | {LOCKED_START.name} == {name for _, name in rows}


def test_partial_braking_of_the_corner_keeps_its_brake() -> None:
    faults = ["none", "slope_invalid", "stamps_crawl"]
    options = Namespace(
        seeds=1, law="slope_sign", quick=False, live=None, car=[CORNER], surface=["dry"], fault=faults,
        demand=[0.6],
    )  # fmt: skip
    rows = list(load_part("campaigns", "faults").run(options))
    assert [row["fault"] for row in rows] == faults
    assert {row["fault"]: row["failures"] for row in rows if not row["passed"]} == {}


def test_valid_slips_stay_within_their_intervals_where_a_pressure_reads_zero() -> None:
    """All wheels slip beside one without a torque, as they would with an accelerometer that is wrong."""
    manoeuvre = Manoeuvre(FOUR_WHEELS, "cobblestone", 1.5)
    (case,) = (each for each in FAULTS if each.name == "pressure_zero")
    run = Loop(manoeuvre, case, 40_000, "curve").run(2.0)
    valid = run.slip_error[run.time > ONSET]
    assert np.isfinite(valid).mean() > 0.5
    assert measure(run, case, manoeuvre, reference(4)).wrong_for < 0.03


@pytest.mark.parametrize(("law", "begin"), [("slope_sign", 0.5), ("curve", 0.5), ("curve", 1.5)])
def test_a_dead_sensor_costs_one_wheel_of_a_car_its_abs_and_no_other(law: str, begin: float) -> None:
    """The wheel dives at 0.5 s; at 1.5 s it is held at its peak by a brake that could lock it within 20 ms."""
    manoeuvre = Manoeuvre(FOUR_WHEELS, "dry", 1.5)
    (case,) = (replace(each, begin=begin, none_later=0.0) for each in FAULTS if each.name == "wheel_dead")
    run = Loop(manoeuvre, case, 40_000, law).run(begin + 0.5)  # no stop: what it costs in distance, the campaign tells
    found = measure(run, case, manoeuvre, reference(4))
    judged = [each for each in limits(case, manoeuvre, found, found) if each.name != "distance ratio"]
    assert [str(each) for each in judged if not each.passed] == []
    assert {"NONE after [s]", "named after [s]", "healthy wheels without ABS"} <= {each.name for each in judged}
    assert "front_left" in run.said
