from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

from corner_sim.smart_tyre.tyre_ring import TyreRing
from corner_sim.smart_tyre.tyre_signal import (
    AccelerometerParameters,
    EncoderParameters,
    ToothedRing,
    TyreBlock,
    TyreSignalSource,
)

G = 9.81
RING = TyreRing()
QUIET = replace(AccelerometerParameters.ideal(), resolution=0.0)


def drive(
    speed: float,
    seconds: float,
    accelerometer: AccelerometerParameters = QUIET,
    encoder: EncoderParameters = EncoderParameters.ideal(),
    fx: float = 0.0,
    noise_seed: int = 0,
) -> TyreBlock:
    source = TyreSignalSource(RING, accelerometer, encoder, wheel_seed=1, noise_seed=noise_seed)
    return source.advance(np.full(round(seconds * 1e4), speed / RING.radius), fx, RING.static_load)


def test_signal_is_the_centripetal_level_with_one_twin_spike_a_revolution() -> None:
    speed = 20.0
    omega = speed / RING.radius
    block = drive(speed, 0.7)
    a = block.radial_acceleration[200:]
    assert np.median(a) == pytest.approx(omega**2 * RING.radius, rel=0.02)
    in_patch = a < 0.5 * omega**2 * RING.radius
    passages = np.count_nonzero(in_patch[1:] & ~in_patch[:-1])
    assert passages == pytest.approx(0.68 * omega / (2.0 * np.pi), abs=1.0)
    # Each passage lies between two spikes.
    for first in np.flatnonzero(in_patch[1:] & ~in_patch[:-1])[1:-1]:
        last = first + np.argmax(~in_patch[first + 1 :])
        assert np.max(a[first - 40 : first]) > 1.5 * omega**2 * RING.radius
        assert np.max(a[last : last + 40]) > 1.5 * omega**2 * RING.radius


def test_mean_of_the_signal_over_whole_revolutions_is_that_of_the_closed_belt() -> None:
    omega = 20.0 / RING.radius
    block = drive(20.0, 2.5)
    turned = block.wheel_angle - block.wheel_angle[200]
    whole = np.flatnonzero((turned >= 0.0) & (turned < 40.0 * np.pi))
    half = RING.patch_half_angle(RING.static_load, 2e5, 20.0)
    expected = omega**2 * np.mean(RING.belt_radius(np.linspace(-np.pi, np.pi, 20_000, endpoint=False), half))
    assert np.mean(block.radial_acceleration[whole]) == pytest.approx(expected, rel=3e-3)


def test_gravity_is_felt_once_a_revolution() -> None:
    omega = 5.0 / RING.radius
    block = drive(5.0, 4.0)
    mounting = np.random.default_rng([1, 1]).uniform(0.0, 2.0 * np.pi)
    theta = block.wheel_angle - mounting - RING.patch_shift(0.0, RING.static_load, 2e5, 5.0)
    free = np.abs(np.mod(theta + np.pi, 2.0 * np.pi) - np.pi) > np.radians(75.0)
    design = np.stack([np.cos(theta), np.sin(theta), np.ones(len(theta))], axis=1)[free]
    cosine, sine, level = np.linalg.lstsq(design, block.radial_acceleration[free], rcond=None)[0]
    assert np.hypot(cosine, sine) == pytest.approx(G, rel=0.05)
    assert level == pytest.approx(omega**2 * RING.radius, rel=0.01)


def test_noise_grows_with_speed_to_the_power_of_three_halves_within_its_band() -> None:
    loud = replace(QUIET, texture_noise=4.0 * G)
    deviations = []
    for speed in (10.0, 20.0):
        noise = drive(speed, 5.0, loud).radial_acceleration - drive(speed, 5.0).radial_acceleration
        deviations.append(np.std(noise[200:]))
    assert deviations[1] == pytest.approx(4.0 * G, rel=0.1)
    assert deviations[1] / deviations[0] == pytest.approx(2.0**1.5, rel=0.02)
    frequency, power = signal.welch(noise[200:], 1e4, nperseg=4096)
    inside = power[(frequency > 300) & (frequency < 1500)].mean()
    assert power[frequency < 50].mean() < 0.01 * inside
    assert power[frequency > 4000].mean() < 0.05 * inside


def test_radio_delays_by_whole_samples() -> None:
    late = replace(QUIET, delay=1e-3)
    prompt = replace(QUIET, delay=0.0)
    a, b = (drive(15.0, 0.3, p).radial_acceleration for p in (late, prompt))
    np.testing.assert_array_equal(a[10:], b[:-10])


def test_accelerometer_saturates_at_500_g() -> None:
    block = drive(34.0, 0.5)
    assert np.max(block.radial_acceleration) == pytest.approx(500.0 * G)
    assert np.max(drive(25.0, 0.5).radial_acceleration) < 500.0 * G


def test_offset_drifts() -> None:
    drifting = replace(QUIET, offset=5.0, offset_drift=2.0)
    difference = drive(10.0, 3.0, drifting).radial_acceleration - drive(10.0, 3.0).radial_acceleration
    np.testing.assert_allclose(difference[10:], 5.0 + 2e-4 * np.arange(10, 30_000), atol=2e-3)


def test_values_are_those_of_a_16_bit_converter() -> None:
    block = drive(12.0, 0.2, AccelerometerParameters(), EncoderParameters())
    for values, step in ((block.encoder_voltage, 20.0 / 2**16), (block.radial_acceleration, 1000.0 * G / 2**16)):
        counts = values[10:].astype(np.float64) / step
        np.testing.assert_allclose(counts, np.round(counts), atol=1e-2)


def test_edges_jitter_from_passage_to_passage_by_the_stated_deviation() -> None:
    jittery = replace(QUIET, edge_jitter=float(np.radians(0.12)), bandwidth=4900.0)
    block = drive(6.0, 120.0, jittery)
    level = 0.5 * (6.0 / RING.radius) ** 2 * RING.radius
    a = block.radial_acceleration.astype(np.float64)
    falls = np.flatnonzero((a[:-1] > level) & (a[1:] <= level))
    share = (a[falls] - level) / (a[falls] - a[falls + 1])
    angle = np.mod(
        block.wheel_angle[falls] + share * (block.wheel_angle[falls + 1] - block.wheel_angle[falls]), 2 * np.pi
    )
    assert len(angle) > 300
    assert np.degrees(np.std(angle)) == pytest.approx(0.12, rel=0.1)


def test_blocks_continue_each_other_without_a_step() -> None:
    def source() -> TyreSignalSource:
        return TyreSignalSource(RING, QUIET, EncoderParameters.ideal(), wheel_seed=1, noise_seed=3)

    speed = np.linspace(30.0, 40.0, 5000)
    whole = source().advance(speed, 100.0, RING.static_load)
    parts = source()
    blocks = [parts.advance(speed[i : i + 130], 100.0, RING.static_load) for i in range(0, 5000, 130)]
    assert [b.first_sample for b in blocks] == list(range(0, 5000, 130))
    np.testing.assert_allclose(np.concatenate([b.encoder_voltage for b in blocks]), whole.encoder_voltage, atol=2e-3)
    np.testing.assert_allclose(
        np.concatenate([b.radial_acceleration for b in blocks]), whole.radial_acceleration, atol=1e-2
    )


def test_lost_packets_come_at_the_stated_rate_and_keep_their_place() -> None:
    lossy = replace(QUIET, packet_loss=0.1)
    source = TyreSignalSource(RING, lossy, EncoderParameters.ideal(), wheel_seed=1, noise_seed=3)
    blocks = [source.advance(np.full(10, 30.0), 0.0, RING.static_load) for _ in range(2000)]
    assert 0.07 < np.mean([b.lost for b in blocks]) < 0.13
    assert all(b.first_sample == 10 * k for k, b in enumerate(blocks))


def test_encoder_gives_one_period_a_tooth_with_an_amplitude_that_grows_with_speed() -> None:
    slow, fast = drive(8.0, 2.0), drive(16.0, 2.0)
    for block, speed in ((slow, 8.0), (fast, 16.0)):
        rising = np.count_nonzero((block.encoder_voltage[:-1] < 0.0) & (block.encoder_voltage[1:] >= 0.0))
        assert rising == pytest.approx(48.0 * 2.0 * speed / RING.radius / (2.0 * np.pi), abs=1.0)
    assert np.max(fast.encoder_voltage) == pytest.approx(2.0 * np.max(slow.encoder_voltage), rel=0.01)


def test_teeth_belong_to_the_ring_and_have_the_stated_pitch_error() -> None:
    parameters = EncoderParameters(eccentricity=0.0)
    at_teeth = np.arange(48) * 2.0 * np.pi / 48.0 + 1e-9
    errors = np.array([ToothedRing(parameters, seed).pitch(at_teeth) for seed in range(50)])
    assert np.degrees(np.std(errors)) == pytest.approx(0.04, rel=0.08)
    np.testing.assert_array_equal(errors[3], ToothedRing(parameters, 3).pitch(at_teeth))
    around = np.linspace(0.0, 2.0 * np.pi, 10_001)
    pitch = ToothedRing(EncoderParameters(), 1).pitch(around)
    assert pitch[0] == pytest.approx(pitch[-1], abs=1e-12)
    assert np.max(np.abs(np.diff(pitch))) < 1e-4


def test_amplitude_is_modulated_over_a_revolution() -> None:
    modulated = replace(EncoderParameters.ideal(), modulation=0.06)
    block = drive(10.0, 1.0, encoder=modulated)
    envelope = [np.max(part) for part in np.array_split(block.encoder_voltage, 100)]
    assert max(envelope) / min(envelope) == pytest.approx(1.06 / 0.94, rel=0.03)
