from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from corner_sim.smart_tyre.tyre_signal import EncoderParameters, ToothedRing
from smart_tyre_forces.encoder_crossings import EncoderCrossings, Stretch
from smart_tyre_forces.tooth_table import ToothTable
from smart_tyre_forces.wheel_angle import WheelAngle
from vehicle_models.reason import Reason

Array = NDArray[np.float64]


def crossings(voltage: Array, cuts: list[int] | None = None) -> list[Stretch]:
    found, detector = [], EncoderCrossings(1e4)
    for part in np.split(voltage, cuts or []):
        if len(part):
            found += detector.push(part)
    return found


def all_times(stretches: list[Stretch]) -> Array:
    return np.concatenate([s.times for s in stretches])


@given(frequency=st.floats(120.0, 830.0), phase=st.floats(0.0, 6.28), amplitude=st.floats(0.7, 6.0))
@settings(max_examples=50)
def test_crossings_of_a_sine_lie_where_they_should(frequency: float, phase: float, amplitude: float) -> None:
    t = np.arange(2000)
    found = all_times(crossings(amplitude * np.sin(2.0 * np.pi * frequency * t / 1e4 + phase)))
    half_turns = found * 2.0 * frequency / 1e4 + phase / np.pi
    # A half wave is 3.75 degrees of wheel angle; 0.002 are required of a noise-free sine, but for the first crossing.
    np.testing.assert_allclose(half_turns[1:], np.round(half_turns[1:]), rtol=0.0, atol=0.002 / 3.75)
    np.testing.assert_allclose(np.diff(np.round(half_turns)), 1.0)


def test_noise_about_zero_adds_no_crossings() -> None:
    rng = np.random.default_rng(0)
    voltage = 0.8 * np.sin(2.0 * np.pi * 120.0 * np.arange(100_000) / 1e4) + 0.02 * rng.standard_normal(100_000)
    found = crossings(voltage)
    assert all(s.interrupted is None for s in found)
    assert len(all_times(found)) == pytest.approx(2 * 120 * 10, abs=2)
    assert crossings(0.01 * rng.standard_normal(10_000)) == []


@given(cuts=st.lists(st.integers(1, 2999), max_size=60))
@settings(max_examples=30, deadline=None)
def test_blocks_of_any_size_give_the_same_crossings_bit_for_bit(simulate: Any, cuts: list[int]) -> None:
    voltage = simulate(6.0, 12.0, seconds=1.0).encoder_voltage[:3000].astype(np.float64)
    whole = all_times(crossings(voltage))
    np.testing.assert_array_equal(all_times(crossings(voltage, sorted(cuts))), whole)


@pytest.mark.parametrize("speed", [6.0, 15.0, 30.0])
@pytest.mark.parametrize(("teeth", "noticed"), [(1, False), (2, False), (3, False), (5, True)])
def test_up_to_three_missed_teeth_are_put_in_again_and_more_are_noticed(
    simulate: Any, speed: float, teeth: int, noticed: bool
) -> None:
    whole = simulate(speed, seconds=1.0).encoder_voltage.astype(np.float64)
    voltage = whole.copy()
    period = 1e4 / (48.0 * speed / 0.32 / (2.0 * np.pi))
    rising = 3000 + int(np.argmax((voltage[3000:-1] < 0.0) & (voltage[3001:] >= 0.0)))
    voltage[rising - round(0.25 * period) : rising + round((teeth - 0.25) * period)] = -0.2
    found = crossings(voltage)
    interrupted = [s.interrupted for s in found if s.interrupted is not None]
    assert bool(interrupted) == noticed
    if not noticed:
        # Half a degree at the bridged teeth, which the table knows otherwise.
        np.testing.assert_allclose(all_times(found), all_times(crossings(whole)), atol=0.15 * period)


@given(cuts=st.lists(st.integers(1, 5999), max_size=60))
@settings(max_examples=20, deadline=None)
def test_blocks_of_any_size_give_the_same_crossings_across_missing_teeth(cuts: list[int]) -> None:
    angle = np.linspace(1.0, 25.0, 6000)
    ring = ToothedRing(EncoderParameters(teeth=60, missing_teeth=2), 1)
    voltage = ring.voltage(angle, np.full(6000, 40.0), np.random.default_rng(0))
    whole = all_times(crossings(voltage))
    assert len(whole) == pytest.approx(24.0 * 120 / (2.0 * np.pi), abs=2)
    np.testing.assert_array_equal(all_times(crossings(voltage, sorted(cuts))), whole)


@pytest.mark.parametrize(("teeth", "missing"), [(48, 1), (60, 2), (48, 3)])
def test_a_ring_with_missing_teeth_is_learned_and_gives_the_angle(teeth: int, missing: int) -> None:
    ring = ToothedRing(EncoderParameters(teeth=teeth, missing_teeth=missing), 4)
    time = np.arange(0.0, 9.0, 1e-4)
    # Even driving to learn from, then braking at 8 m/s^2.
    omega = np.interp(time, [0.0, 7.5, 9.0], [45.0, 46.0, 10.0])
    angle = np.cumsum(omega) * 1e-4
    wheel = WheelAngle(teeth)
    for stretch in crossings(ring.voltage(angle, omega, np.random.default_rng(0))):
        assert stretch.interrupted is None
        wheel.extend(stretch.times)
    assert wheel.table is not None
    samples = np.arange(int(wheel.times[0]) + 1, int(wheel.times[-1]))
    error = wheel.at(samples.astype(np.float64)) - angle[samples]
    assert np.degrees(np.std(error)) < 0.02


def test_a_surplus_pulse_is_noticed(simulate: Any) -> None:
    voltage = simulate(8.0, seconds=1.0).encoder_voltage.astype(np.float64).copy()
    high = 3000 + int(np.argmax(voltage[3000:3100]))
    voltage[high - 8 : high + 8] = -1.0
    assert any(s.interrupted is Reason.MISSED_TOOTH for s in crossings(voltage))


def test_braking_and_bad_teeth_are_not_taken_for_a_missed_tooth(simulate: Any) -> None:
    voltage = simulate(20.0, 6.0, seconds=1.5).encoder_voltage.astype(np.float64)
    assert all(s.interrupted is None for s in crossings(voltage))


def test_standstill_loses_the_angle(simulate: Any) -> None:
    voltage = simulate(5.0, 0.0, 0.0, 5.0, seconds=3.0).encoder_voltage.astype(np.float64)
    assert any(s.interrupted is Reason.REVERSAL for s in crossings(voltage))


def angle_error(block: Any, table: ToothTable) -> Array:
    wheel = WheelAngle(48, table)
    for stretch in crossings(block.encoder_voltage.astype(np.float64)):
        wheel.extend(stretch.times)
    samples = np.arange(int(wheel.times[0]) + 1, int(wheel.times[-1]))
    return np.asarray(wheel.at(samples.astype(np.float64)) - block.wheel_angle[samples])


@pytest.mark.parametrize("speed", [5.5, 12.0, 30.0])
def test_angle_is_good_to_a_tenth_of_a_degree_raw_and_a_fiftieth_with_the_table(
    simulate: Any, table: ToothTable, speed: float
) -> None:
    block = simulate(speed, seconds=3.0, seed=4)
    even = ToothTable(np.zeros(96))
    assert np.degrees(np.std(angle_error(block, even))) < 0.1
    assert np.degrees(np.std(angle_error(block, table))) < 0.02


def test_learned_table_is_the_pitch_of_the_ring(table: ToothTable) -> None:
    parameters = EncoderParameters(second_harmonic=0.0)
    ring = ToothedRing(parameters, 1)
    angle = np.arange(96) * np.pi / 48.0
    # The second harmonic moves rising and falling crossings apart by a constant; the ring's own pitch is the rest.
    expected = -ring.pitch(angle)
    learned = table.deviations.copy()
    for half in (slice(0, None, 2), slice(1, None, 2)):
        expected[half] -= expected[half].mean()
        learned[half] -= learned[half].mean()
    best = min(np.degrees(np.std(np.roll(learned, k) - expected)) for k in range(96))
    assert best < 0.01


@given(start=st.integers(0, 95), seed=st.integers(0, 1000), acceleration=st.floats(-0.05, 0.05))
@settings(max_examples=60, deadline=None)
def test_any_tooth_is_recognised_from_one_revolution(
    table: ToothTable, start: int, seed: int, acceleration: float
) -> None:
    noise = np.radians(0.015) * np.random.default_rng(seed).standard_normal(96)
    turned = table.angles(np.arange(start, start + 96)) + noise - start * table.step
    # Speed changes by 5 % within the revolution, as in hard braking at 15 m/s.
    times = 1000.0 + 200.0 * turned * (1.0 + acceleration * turned / (2.0 * np.pi))
    place = table.place(times)
    assert place is not None and place.certain
    assert place.index == start


def test_turning_backwards_is_not_recognised(table: ToothTable) -> None:
    forward = table.angles(np.arange(20, 117))
    assert table.place(100.0 * (forward[-1] - forward[::-1])[:96]) is None


def test_equal_teeth_cannot_be_told_apart() -> None:
    place = ToothTable(np.zeros(96)).place(100.0 * np.arange(96.0, dtype=np.float64))
    assert place is not None and not place.certain


def test_two_alike_halves_of_a_ring_are_not_guessed() -> None:
    half = np.radians(0.05) * np.random.default_rng(0).standard_normal(48)
    table = ToothTable(np.concatenate((half, half)))
    assert table.place(100.0 * table.angles(np.arange(10, 106))) is None


@pytest.mark.parametrize("bad", [np.zeros(95), np.zeros(0), np.full(96, np.nan), np.full(96, 0.1)])
def test_impossible_tooth_tables_are_refused(bad: Array) -> None:
    with pytest.raises(ValueError, match="tooth table"):
        ToothTable(bad)
