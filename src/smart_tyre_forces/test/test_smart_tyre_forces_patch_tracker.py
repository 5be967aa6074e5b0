from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from corner_sim.smart_tyre.tyre_ring import TyreRing
from corner_sim.smart_tyre.tyre_signal import TyreBlock
from smart_tyre_forces.front_template import TemplateFit, TemplateLearner
from smart_tyre_forces.fronts import Fronts, find_fronts
from smart_tyre_forces.patch_tracker import Passage, PatchTracker
from smart_tyre_forces.tooth_table import ToothTable
from vehicle_models.constants import GRAVITY
from vehicle_models.reason import Reason
from vehicle_models.vehicle_file import load_vehicle

RING = TyreRing()
WHEEL = load_vehicle("smart_tyre_car").wheel("front_left")


def run(block: TyreBlock, table: ToothTable | None, cuts: list[int] | None = None, **kwargs: Any) -> list[Passage]:
    tracker = PatchTracker(WHEEL, table=table, **kwargs)
    found, first = [], 0
    edges = [*sorted(set(cuts or [])), len(block.encoder_voltage)]
    for edge in edges:
        if edge > first:
            part = slice(first, edge)
            found += tracker.push(first, block.encoder_voltage[part], block.radial_acceleration[part])
        first = edge
    return found


def fronts(passages: list[Passage]) -> tuple[np.ndarray, np.ndarray]:
    valid = [p for p in passages if p.reason is Reason.OK]
    return np.array([p.alpha_1 for p in valid]), np.array([p.alpha_2 for p in valid])


def same(a: list[Passage], b: list[Passage]) -> bool:
    return len(a) == len(b) and repr(a) == repr(b)


@pytest.mark.parametrize(("speed", "load"), [(6.0, 1.0), (12.0, 0.7), (12.0, 1.3), (25.0, 1.0)])
def test_length_is_that_of_the_patch(simulate: Any, speed: float, load: float) -> None:
    alpha_1, alpha_2 = fronts(run(simulate(speed, seconds=4.0, ideal=True, load=load), ToothTable(np.zeros(96))))
    length = 2.0 * RING.patch_half_angle(load * RING.static_load, 2e5, speed)
    assert len(alpha_1) > 5
    assert np.degrees(np.mean(alpha_2 - alpha_1)) == pytest.approx(np.degrees(length), abs=0.25)


def test_shift_follows_the_force(simulate: Any, table: ToothTable) -> None:
    def centre(fx: float) -> float:
        alpha_1, alpha_2 = fronts(run(simulate(15.0, seconds=4.0, fx=fx), table))
        return float(np.mean(alpha_1 + alpha_2)) / 2.0

    free = centre(0.0)
    for fx in (-3000.0, 2000.0):
        expected = RING.patch_shift(fx, RING.static_load, 2e5, 15.0) - RING.patch_shift(
            0.0, RING.static_load, 2e5, 15.0
        )
        assert np.degrees(centre(fx) - free) == pytest.approx(np.degrees(expected), abs=0.04)


@given(cuts=st.lists(st.integers(1, 59_999), max_size=80))
@settings(max_examples=20, deadline=None)
def test_blocks_of_any_size_give_the_same_passages_bit_for_bit(
    simulate: Any, table: ToothTable, cuts: list[int]
) -> None:
    block = simulate(8.0, 14.0, seconds=6.0)
    assert same(run(block, table, cuts), run(block, table))


@pytest.mark.parametrize("size", [1, 7, 100, 997])
def test_even_blocks_give_the_same_through_standstill_and_faults(simulate: Any, table: ToothTable, size: int) -> None:
    block = simulate(8.0, 2.9, 2.5, 0.0, 9.0, seconds=4.0)
    damaged = replace(block, encoder_voltage=block.encoder_voltage.copy())
    damaged.encoder_voltage[38_000:38_060] = 0.0
    whole = run(damaged, table)
    assert {p.reason for p in whole} >= {Reason.OK, Reason.SPEED_RANGE, Reason.REVERSAL}
    assert same(run(damaged, table, list(range(size, 40_000, size))), whole)


def test_template_gives_the_same_for_any_block_size_too(simulate: Any, table: ToothTable) -> None:
    learner = TemplateLearner()
    run(simulate(14.0, seconds=6.0, seed=5), table, refiner=learner)
    block = simulate(8.0, 14.0, seconds=6.0)
    whole = run(block, table, refiner=TemplateFit(learner.template))
    assert len(fronts(whole)[0]) > 20
    assert same(run(block, table, list(range(100, 60_000, 100)), refiner=TemplateFit(learner.template)), whole)


def test_template_is_better_than_the_crossing(simulate: Any, table: ToothTable) -> None:
    learner = TemplateLearner()
    run(simulate(14.0, seconds=6.0, seed=5), table, refiner=learner)
    block = simulate(18.0, seconds=8.0, seed=6)
    crossing = [np.std(a) for a in fronts(run(block, table))]
    template = [np.std(a) for a in fronts(run(block, table, refiner=TemplateFit(learner.template)))]
    assert max(template) < 0.8 * min(crossing)


@pytest.mark.parametrize(("speed", "matched"), [(8.0, False), (20.0, False), (8.0, True), (20.0, True)])
def test_stated_deviation_of_the_fronts_is_their_scatter(
    simulate: Any, table: ToothTable, speed: float, matched: bool
) -> None:
    learner = TemplateLearner()
    run(simulate(14.0, seconds=6.0, seed=5), table, refiner=learner)
    refiner = TemplateFit(learner.template) if matched else None
    found = run(simulate(speed, seconds=12.0, seed=6), table, refiner=refiner)
    stated = np.sqrt(np.mean([p.front_stddev**2 for p in found if p.reason is Reason.OK]))
    scatter = np.sqrt(np.mean([np.var(a) for a in fronts(found)]))
    assert 0.6 * scatter < stated < 1.5 * scatter


def test_missed_teeth_leave_no_permanent_error(simulate: Any, table: ToothTable) -> None:
    block = simulate(12.0, seconds=8.0)
    damaged = replace(block, encoder_voltage=block.encoder_voltage.copy())
    damaged.encoder_voltage[40_000:40_300] = -0.3
    before, after = (fronts([p for p in run(b, table) if p.time > 50_000]) for b in (block, damaged))
    whole = run(damaged, table)
    assert [p.reason for p in whole if p.reason is not Reason.OK] == [Reason.MISSED_TOOTH]
    assert after[0][-10:] == pytest.approx(before[0][-10:], abs=1e-9)
    assert len({p.reference for p in whole}) == 1


@pytest.mark.parametrize("lost", [100, 5000, 20_000])
def test_lost_packets_are_said_once_and_the_angle_is_found_again(simulate: Any, table: ToothTable, lost: int) -> None:
    block = simulate(12.0, seconds=8.0)
    tracker = PatchTracker(WHEEL, table=table)
    found = tracker.push(0, block.encoder_voltage[:30_000], block.radial_acceleration[:30_000])
    begin = 30_000 + lost
    found += tracker.push(begin, block.encoder_voltage[begin:], block.radial_acceleration[begin:])
    assert [p.reason for p in found if p.reason is not Reason.OK] == [Reason.GAP]
    assert not any(p.reason is Reason.OK and 30_000 < p.time < begin + 1000 for p in found)
    whole = run(block, table)
    assert fronts(found)[0][-5:] == pytest.approx(fronts(whole)[0][-5:], abs=1e-9)


def test_nothing_is_said_below_3_and_above_35_metres_per_second(simulate: Any, table: ToothTable) -> None:
    for passage in run(simulate(8.0, 2.0, seconds=8.0), table):
        assert (passage.reason is Reason.OK) == (passage.wheel_speed * RING.radius >= 3.0)
    fast = run(simulate(36.0, seconds=3.0), table)
    assert fast and all(p.reason is Reason.SPEED_RANGE for p in fast)


def test_radius_of_the_wheel_decides_what_is_too_slow(simulate: Any, table: ToothTable) -> None:
    block = simulate(8.0, 3.2, seconds=8.0)
    small = PatchTracker(replace(WHEEL, radius=0.25), table=table)
    found = small.push(0, block.encoder_voltage, block.radial_acceleration)
    assert found[-1].reason is Reason.SPEED_RANGE
    assert run(block, table)[-1].reason is Reason.OK


def test_saturation_is_noticed(simulate: Any, table: ToothTable) -> None:
    reasons = {p.reason for p in run(simulate(33.0, seconds=3.0), table)}
    assert reasons == {Reason.SATURATED}


def test_missing_acceleration_spoils_only_its_revolution(simulate: Any, table: ToothTable) -> None:
    block = simulate(12.0, seconds=5.0)
    whole = run(block, table)
    damaged = replace(block, radial_acceleration=block.radial_acceleration.copy())
    damaged.radial_acceleration[int(whole[10].time)] = np.nan
    found = run(damaged, table)
    assert [k for k, p in enumerate(found) if p.reason is not Reason.OK] == [10]
    assert found[10].reason is Reason.BAD_INPUT


def test_encoder_that_is_not_finite_loses_the_angle_but_not_the_estimator(simulate: Any, table: ToothTable) -> None:
    block = simulate(12.0, seconds=6.0)
    damaged = replace(block, encoder_voltage=block.encoder_voltage.copy())
    damaged.encoder_voltage[20_050] = np.inf
    found = run(damaged, table, list(range(100, 60_000, 100)))
    assert [p.reason for p in found if p.reason is not Reason.OK] == [Reason.BAD_INPUT]
    assert fronts(found)[0][-3:] == pytest.approx(fronts(run(block, table))[0][-3:], abs=1e-9)


def test_dead_accelerometer_has_no_fronts(simulate: Any, table: ToothTable) -> None:
    block = simulate(12.0, seconds=4.0)
    dead = replace(block, radial_acceleration=np.zeros_like(block.radial_acceleration))
    reasons = {p.reason for p in run(dead, table)}
    assert reasons == {Reason.NO_FRONTS}


def test_reverse_driving_gives_nothing(simulate: Any, table: ToothTable) -> None:
    block = simulate(8.0, seconds=5.0)
    backwards = replace(
        block,
        encoder_voltage=np.ascontiguousarray(block.encoder_voltage[::-1]),
        radial_acceleration=np.ascontiguousarray(block.radial_acceleration[::-1]),
    )
    assert run(backwards, table) == []


@pytest.mark.parametrize("shapes", [(10, 9), (0, 0)])
def test_blocks_that_are_no_blocks_are_refused(shapes: tuple[int, int]) -> None:
    with pytest.raises(ValueError, match="block"):
        PatchTracker(WHEEL).push(0, np.zeros(shapes[0]), np.zeros(shapes[1]))


def test_a_passage_without_a_sample_on_one_of_its_fronts_has_none(simulate: Any, table: ToothTable) -> None:
    learner = TemplateLearner()
    run(simulate(14.0, seconds=6.0, seed=5), table, refiner=learner)
    theta = np.linspace(-3.1, 0.1, 1000)
    acceleration = 500.0 + np.random.default_rng(1).normal(0.0, 5.0, theta.size)
    beyond = Fronts(alpha_1=-0.15, alpha_2=0.6, floor=0.0, step=500.0)
    assert TemplateFit(learner.template).refine(beyond, theta, acceleration) is None


@given(data=st.data())
@settings(max_examples=40, deadline=None)
def test_no_stream_however_hostile_breaks_the_tracker(simulate: Any, table: ToothTable, data: st.DataObject) -> None:
    block = simulate(12.0, seconds=5.0)
    learner = TemplateLearner()
    run(simulate(14.0, seconds=6.0, seed=5), table, refiner=learner)
    tracker = PatchTracker(WHEEL, table=table, refiner=TemplateFit(learner.template))
    garbage = st.sampled_from([0.0, -1.0, 1e-30, 3e38, -3e38, np.nan, np.inf, -np.inf, 1.0, 4905.0])
    first = data.draw(st.integers(0, 2**40))
    with np.errstate(all="ignore"):
        for begin in range(0, 30_000, 3000):
            voltage = block.encoder_voltage[begin : begin + 3000].copy()
            acceleration = block.radial_acceleration[begin : begin + 3000].copy()
            for signal in (voltage, acceleration):
                at, length = data.draw(st.integers(0, 2999)), data.draw(st.integers(0, 400))
                signal[at : at + length] = data.draw(garbage)
            first += data.draw(st.sampled_from([0, 0, 0, 1, 5000]))
            found = tracker.push(first, voltage, acceleration)
            first += 3000
            for p in found:
                numbers = (p.alpha_1, p.alpha_2, p.wheel_speed, p.front_stddev)
                assert np.isfinite(p.time)
                assert np.all(np.isfinite(numbers)) == (p.reason is Reason.OK)
        good = [
            p
            for begin in range(0, 50_000, 1000)
            for p in tracker.push(
                first + begin,
                block.encoder_voltage[begin : begin + 1000],
                block.radial_acceleration[begin : begin + 1000],
            )
        ]
    # Clean signals afterwards give clean passages.
    assert [p.reason for p in good[-5:]] == [Reason.OK] * 5


def passage_shape(offset: float, step: float, noise: float) -> tuple[np.ndarray, np.ndarray]:
    theta = np.linspace(-np.radians(50.0), np.radians(50.0), 500)
    wave = RING.acceleration_shape(theta - 0.01, RING.half_patch) / RING.radius
    rng = np.random.default_rng(0)
    return theta, offset + step * wave + GRAVITY * np.cos(theta) + noise * rng.standard_normal(len(theta))


@given(offset=st.floats(-200.0, 200.0), speed=st.floats(6.0, 30.0), ratio=st.floats(0.85, 1.1))
@settings(max_examples=50)
def test_fronts_depend_neither_on_offset_nor_on_speed_nor_on_braking(offset: float, speed: float, ratio: float) -> None:
    step = (speed / RING.radius) ** 2 * RING.radius
    theta, acceleration = passage_shape(offset, step, 0.0)
    mean_cosine = -np.sin(np.radians(50.0)) / np.radians(130.0)
    found = find_fronts(theta, acceleration, offset + step / ratio**2 + GRAVITY * mean_cosine, ratio)
    assert found is not None
    assert np.degrees(found.alpha_1 + found.alpha_2) / 2.0 == pytest.approx(np.degrees(0.01), abs=0.03)
    assert np.degrees(found.alpha_2 - found.alpha_1) == pytest.approx(25.0, abs=0.3)


def test_no_fronts_in_noise() -> None:
    theta = np.linspace(-0.87, 0.87, 500, dtype=np.float64)
    assert find_fronts(theta, np.random.default_rng(1).standard_normal(500), 0.0, 1.0) is None
