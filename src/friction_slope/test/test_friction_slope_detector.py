"""The detector on simulated braking: both directions, both methods, and what it refuses."""

from dataclasses import replace
from itertools import pairwise
from math import inf, nan
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from corner_sim.corner import SingleCorner
from friction_slope.detector import (
    LEAST_PEAK,
    LOCKED_INDICATOR,
    DetectorParameters,
    NoSlipParameters,
    SlopeDetector,
)
from friction_slope.estimate import Method, SlopeEstimate, SlopeSample
from vehicle_models import burckhardt
from vehicle_models.constants import GRAVITY
from vehicle_models.physical_bounds import HIGHEST_ROAD_FRICTION
from vehicle_models.reason import Reason
from vehicle_models.surfaces import TABLE_8_1, surface
from vehicle_models.vehicle_file import load_vehicle
from vehicle_models.wheel_forces import WheelLoad

DT = 0.005
STEP = 5_000_000
CORNER = load_vehicle("chapter_corner").corner("front_left")
CAR = load_vehicle("chapter_car")
EXACT = DetectorParameters(
    window=3, rate_window=3, h_instability=0.0, h_stability=0.0, slip_rate_dead_zone=0.0, least_growth=0.0
)


def exact(method: Method = Method.SLIP) -> SlopeDetector:
    return SlopeDetector(CORNER, method, EXACT, NoSlipParameters(eta_margin=0.0))


def through_the_peak(name: str) -> tuple[list[SlopeSample], np.ndarray]:
    """Noise-free samples of a ramp past the peak and a release back through it, and the true signs of the slope."""
    theta = surface(name)
    peak = float(burckhardt.peak(theta)[0])
    corner = SingleCorner(CORNER, [30.0])
    torque, hold, released = 0.0, 1.08 * float(CORNER.peak_torque(theta)), False
    samples, signs = [], []
    for k in range(400):
        slip, speed, omega = float(corner.slip[0]), float(corner.speed[0]), float(corner.wheel_speed[0])
        omega_dot = float(corner.wheel_acceleration(theta, torque)[0])
        rate = ((1.0 - slip) * float(corner.acceleration(theta)[0]) - CORNER.radius * omega_dot) / speed
        samples.append(SlopeSample((k + 1) * STEP, omega, torque, slip, rate, speed))
        signs.append(1 if slip <= peak else -1)
        released = released or slip > 2.0 * peak
        after = max(torque - 25.0, 0.0) if released else min(torque + hold / 50.0, hold) if k >= 20 else 0.0
        corner.step(torque, after, theta, DT)
        torque = after
        if released and slip < 0.5 * peak:
            break
    return samples, np.array(signs)


def content(estimates: list[SlopeEstimate]) -> str:
    """Everything that is estimated, in words: NaN is equal to NaN."""
    return repr([(name, getattr(each, name)) for each in estimates for name in dir(each) if name[0] != "_"])


def changed(sample: SlopeSample, **changes: Any) -> SlopeSample:
    names = ("stamp", "wheel_speed", "brake_torque", "slip", "slip_rate", "vehicle_speed", "acceleration")
    return SlopeSample(**{name: changes.get(name, getattr(sample, name)) for name in names})


def run(detector: SlopeDetector, samples: list[SlopeSample]) -> list[SlopeEstimate]:
    return [detector.update(sample) for sample in samples]


@pytest.mark.parametrize("name", TABLE_8_1)
@pytest.mark.parametrize("method", Method)
def test_sign_follows_both_crossings_within_the_documented_delay_and_one_sample(name: str, method: Method) -> None:
    samples, truth = through_the_peak(name)
    found = run(exact(method), samples)
    signs = np.array([estimate.sign for estimate in found])
    for change in (-1, 1):
        true = int(np.flatnonzero(np.diff(truth) == 2 * change)[0]) + 1
        detected = int(np.flatnonzero((signs[1:] == change) & (signs[:-1] == -change))[0]) + 1
        delay = found[detected].delay
        assert delay == pytest.approx(DT)
        # The crossing lies between the samples true - 1 and true: delay and one sample from it end before true + 2.
        assert 0 <= detected - true <= 1
    assert found[-1].crossings == 2


@pytest.mark.parametrize("name", TABLE_8_1)
def test_sign_is_valid_once_it_has_lasted_for_its_delay(name: str) -> None:
    samples, truth = through_the_peak(name)
    found = run(exact(), samples)
    told = [k for k in range(1, len(found)) if found[k].sign and found[k].sign != found[k - 1].sign]
    assert len(told) == 3
    for k in told:
        assert [found[k].reason, found[k + 1].reason] == [Reason.NOT_LASTING, Reason.OK]
    for k, estimate in enumerate(found):
        # What a valid sign says was so `delay` before, between two samples: here and one sample earlier.
        assert estimate.reason is not Reason.OK or estimate.sign in truth[k - 2 : k]


def test_sign_that_its_indicator_contradicts_is_not_valid() -> None:
    samples, _ = through_the_peak("dry")
    found = run(exact(), samples)
    lost = next(k for k in range(len(found)) if found[k].crossings == 1)
    # Beyond the peak the torque rises as if the friction did, while the slip goes on growing.
    beyond = [changed(s, brake_torque=s.brake_torque + 4e5 * (n * DT) ** 2) for n, s in enumerate(samples[lost:])]
    after = run(exact(), samples[:lost] + beyond[:10])[lost + 3 :]
    assert all(estimate.sign == -1 and estimate.indicator > 0.0 for estimate in after)
    assert {estimate.reason for estimate in after} == {Reason.NOT_LASTING}


@pytest.mark.parametrize("name", TABLE_8_1)
def test_slip_at_the_crossing_is_lambda_max(name: str) -> None:
    samples, _ = through_the_peak(name)
    peak = float(burckhardt.peak(surface(name))[0])
    lost = next(estimate for estimate in run(exact(), samples) if estimate.crossing_sign == -1)
    one_sample = max(abs(b.slip - a.slip) for a, b in pairwise(samples) if b.slip < 2 * peak)
    assert lost.slip_at_crossing == pytest.approx(peak, abs=one_sample)
    at = next(sample for sample in samples if sample.stamp == lost.crossing_stamp)
    assert lost.slip_at_crossing == pytest.approx(at.slip, rel=1e-2)


def test_sign_is_not_known_before_braking_and_says_so() -> None:
    samples, _ = through_the_peak("dry")
    found = run(exact(), samples)
    assert [estimate.reason for estimate in found[:4]] == [Reason.NOT_READY] * 2 + [Reason.NOT_BRAKING] * 2
    assert all(estimate.sign == 0 and np.isnan(estimate.indicator) for estimate in found[:20])


def test_released_wheel_is_still_seen_and_then_is_no_longer_braked() -> None:
    detector = exact()
    for k in range(40):
        detector.update(SlopeSample((k + 1) * STEP, 90.0, 400.0, 0.05, 0.0, 30.0))
    reasons = [detector.update(SlopeSample((k + 41) * STEP, 90.0, 0.0, 0.05, 0.0, 30.0)).reason for k in range(80)]
    assert reasons.index(Reason.NOT_BRAKING) * DT == pytest.approx(EXACT.braking_hold, abs=DT)


def test_locked_wheel_is_no_standstill_without_a_speed_sensor() -> None:
    detector = exact(Method.NO_SLIP)
    for k in range(20):
        detector.update(SlopeSample((k + 1) * STEP, 100.0, 500.0))
    reasons = [detector.update(SlopeSample((k + 21) * STEP, 0.0, 500.0)).reason for k in range(600)]
    standing = (30.0 - EXACT.minimum_speed) / EXACT.max_deceleration
    assert reasons.index(Reason.LOW_SPEED) * DT == pytest.approx(standing, abs=2 * DT)


def test_locked_wheel_of_a_car_whose_speed_is_known_is_no_standstill_however_long_it_lasts() -> None:
    detector = exact(Method.NO_SLIP)
    for k in range(20):
        detector.update(SlopeSample((k + 1) * STEP, 100.0, 500.0, 0.0, 0.0, 30.0))
    found = [detector.update(SlopeSample((k + 21) * STEP, 0.0, 500.0, 1.0, 0.0, 25.0)) for k in range(1000)]
    assert {(each.reason, each.indicator) for each in found[20:]} == {(Reason.OK, LOCKED_INDICATOR)}


def test_method_slip_stops_below_the_minimum_vehicle_speed() -> None:
    detector = exact()
    for k in range(20):
        estimate = detector.update(SlopeSample((k + 1) * STEP, 40.0, 500.0, 0.1, 0.5, 1.4))
    assert estimate.reason is Reason.LOW_SPEED
    assert np.isnan(estimate.h)


def test_method_slip_without_slip_answers_as_no_slip_and_says_so() -> None:
    samples, _ = through_the_peak("wet")
    blind = [changed(sample, slip=nan, slip_rate=nan, vehicle_speed=nan) for sample in samples]
    found = run(exact(Method.NO_SLIP), blind)
    assert content(run(exact(), blind)[2:]) == content(found[2:])
    assert {estimate.method for estimate in found} == {Method.NO_SLIP}
    assert found[-1].crossings == 2
    assert np.isnan(found[-1].slip_at_crossing)


def test_a_sign_told_by_one_equation_is_not_held_by_the_other() -> None:
    # The slip rate has a sign, eta of a wheel at constant speed has none.
    detector = SlopeDetector(CORNER, Method.SLIP, EXACT)
    known = [SlopeSample((k + 1) * STEP, 90.0, 400.0 + k, 0.05, 0.5, 30.0) for k in range(20)]
    assert run(detector, known)[-1].sign == 1
    lost = [changed(known[-1], stamp=(k + 21) * STEP, slip=nan, slip_rate=nan, vehicle_speed=nan) for k in range(5)]
    found = run(detector, lost)
    assert {estimate.method for estimate in found} == {Method.NO_SLIP}
    assert {(estimate.sign, estimate.reason) for estimate in found} == {(0, Reason.NO_EXCITATION)}


def test_slip_rate_in_the_dead_zone_holds_the_sign() -> None:
    samples, _ = through_the_peak("dry")
    found = run(SlopeDetector(CORNER, Method.SLIP, replace(EXACT, slip_rate_dead_zone=1e3)), samples)
    braked = [estimate for estimate in found if estimate.reason is Reason.NO_EXCITATION]
    assert len(braked) > 50
    assert all(estimate.indicator == 0.0 and estimate.sign == 0 for estimate in braked)


def test_eta_margin_widens_the_dead_zone_of_no_slip_and_is_nothing_to_slip() -> None:
    samples, _ = through_the_peak("dry")
    wide = NoSlipParameters(eta_margin=100.0)
    assert {e.indicator for e in run(SlopeDetector(CORNER, Method.NO_SLIP, EXACT, wide), samples)[30:]} == {0.0}
    assert content(run(SlopeDetector(CORNER, Method.SLIP, EXACT, wide), samples)) == content(run(exact(), samples))


def test_load_of_the_wheel_decides_what_friction_it_uses() -> None:
    samples, _ = through_the_peak("dry")
    light = replace(CORNER, vertical_load=0.1 * CORNER.vertical_load)
    no_slip = NoSlipParameters(eta_margin=0.0)
    signed = [
        sum(estimate.reason is Reason.OK for estimate in run(SlopeDetector(c, Method.NO_SLIP, EXACT, no_slip), samples))
        for c in (light, CORNER)
    ]
    assert signed[0] < signed[1]


@pytest.mark.parametrize("method", Method)
@pytest.mark.parametrize("swing", [0.0, 0.5])
def test_slip_that_swings_as_much_as_it_grows_tells_no_loss_of_stability(method: Method, swing: float) -> None:
    """A wheel whose torque falls while its slip grows is beyond the peak, unless a rough road makes its slip swing."""
    growth, speed = 0.4, 25.0
    detector = SlopeDetector(CORNER, method, DetectorParameters(load_transfer=False))
    signs = set()
    for k in range(80):
        time, shaken = k * DT, swing * np.sin(2.0 * np.pi * 11.0 * k * DT)
        omega = (speed * (0.9 - growth * time)) / CORNER.radius + shaken
        torque = 400.0 - 50.0 * CORNER.inertia * time
        sample = SlopeSample((k + 1) * STEP, omega, torque, 0.1 + growth * time, growth, speed, 0.0)
        signs.add(detector.update(sample).sign)
    assert (-1 in signs) == (swing == 0.0)


def test_slip_below_every_peak_tells_no_loss_of_stability() -> None:
    def last(slip: float) -> SlopeEstimate:
        detector = SlopeDetector(CORNER, Method.SLIP, replace(EXACT, least_growth=1.0))
        return run(
            detector,
            [SlopeSample((k + 1) * STEP, 80.0 - 4.0 * k, 400.0 - k**2, slip, 0.5, 25.0) for k in range(10)],
        )[-1]

    assert (last(0.9 * LEAST_PEAK).sign, last(1.1 * LEAST_PEAK).sign) == (0, -1)


def test_gap_fills_the_window_again_and_says_so() -> None:
    samples, _ = through_the_peak("dry")
    late = samples[:60] + [changed(s, stamp=s.stamp + 100_000_000) for s in samples[60:]]
    found = run(exact(), late)
    assert [estimate.reason for estimate in found[60:64]] == [Reason.GAP, Reason.GAP, Reason.NOT_LASTING, Reason.OK]
    assert found[62].h == pytest.approx(run(exact(), samples)[62].h)


@pytest.mark.parametrize(
    ("bad", "reason"),
    [
        (dict(wheel_speed=nan), Reason.BAD_INPUT),
        (dict(wheel_speed=inf), Reason.BAD_INPUT),
        (dict(brake_torque=nan), Reason.NO_PRESSURE),
        (dict(stamp=STEP), Reason.BAD_INPUT),
    ],
)
def test_garbage_is_refused_and_leaves_no_trace(bad: dict[str, float], reason: Reason) -> None:
    samples, _ = through_the_peak("dry")
    clean = run(exact(), samples)
    detector = exact()
    for k, sample in enumerate(samples):
        if k == 50:
            garbage = changed(sample, stamp=sample.stamp - STEP // 2)
            refused = detector.update(changed(garbage, **bad))
            assert refused.reason is reason
            assert np.isnan(refused.indicator)
        assert content([detector.update(sample)]) == content([clean[k]])  # NaN where nothing is known


def test_reset_is_a_new_detector() -> None:
    samples, _ = through_the_peak("snow")
    detector = exact()
    for sample in samples:
        detector.update(sample)
    detector.reset()
    again = [detector.update(sample) for sample in samples]
    assert content(again) == content(run(exact(), samples))


def growing_load(count: int, acceleration: bool) -> list[SlopeSample]:
    """A front wheel at constant friction while its car brakes harder and harder: all of H is that of the load."""
    load, corner = WheelLoad(CAR, "front_left"), CAR.corner("front_left")
    samples, omega, moment = [], 80.0, 0.0
    for k in range(count):
        braking = 30.0 * min(k * DT, 0.3)
        load.update((k + 1) * STEP, -braking)
        before, moment = moment, 0.9 * corner.radius * load.load
        torque = 700.0
        omega += DT * (0.5 * (before + moment) - torque) / corner.inertia
        samples.append(SlopeSample((k + 1) * STEP, omega, torque, 0.1, 0.5, 25.0, -braking if acceleration else nan))
    return samples


def test_changing_load_is_taken_out_of_h_where_there_is_an_acceleration() -> None:
    with_load = SlopeDetector(CAR.corner("front_left"), Method.SLIP, EXACT, load=WheelLoad(CAR, "front_left"))
    printed = SlopeDetector(CAR.corner("front_left"), Method.SLIP, EXACT)
    found = run(with_load, growing_load(60, acceleration=True))[-1]
    as_printed = run(printed, growing_load(60, acceleration=True))[-1]
    assert as_printed.h > 100.0
    assert found.h == pytest.approx(0.0, abs=0.05 * as_printed.h)
    assert (found.load_transfer, as_printed.load_transfer) == (True, False)


def test_without_an_acceleration_h_is_that_of_the_equation_as_printed() -> None:
    detector = SlopeDetector(CAR.corner("front_left"), Method.SLIP, EXACT, load=WheelLoad(CAR, "front_left"))
    printed = SlopeDetector(CAR.corner("front_left"), Method.SLIP, EXACT)
    fed = growing_load(60, acceleration=False)
    assert content(run(detector, fed)) == content(run(printed, fed))


def test_kick_of_the_sensor_does_not_count_as_more_than_tyres_can_brake() -> None:
    def after(kick: float) -> SlopeEstimate:
        detector = SlopeDetector(CAR.corner("front_left"), Method.SLIP, EXACT, load=WheelLoad(CAR, "front_left"))
        fed = growing_load(60, acceleration=True)
        fed[40].acceleration = kick
        return run(detector, fed)[-1]

    assert content([after(-190.0)]) == content([after(-HIGHEST_ROAD_FRICTION * GRAVITY)])


def test_measured_braking_of_the_car_decides_where_eta_tells_the_slip_rate() -> None:
    """Friction of this wheel 0.8, of the car 0.4: by (8.6) an eta between them is that of a growing slip."""
    corner = CAR.corner("front_left")
    moment, eta = 0.8 * corner.radius * corner.vertical_load, 0.6
    omega_dot = -eta * GRAVITY / corner.radius
    torque = moment - corner.inertia * omega_dot

    def last(acceleration: float) -> SlopeEstimate:
        detector = SlopeDetector(corner, Method.NO_SLIP, EXACT, NoSlipParameters(eta_margin=0.05))
        fed = [
            SlopeSample((k + 1) * STEP, 90.0 + omega_dot * k * DT, torque + 10.0 * k**2, acceleration=acceleration)
            for k in range(8)
        ]
        return run(detector, fed)[-1]

    assert last(nan).reason is Reason.NO_EXCITATION
    assert last(-0.4 * GRAVITY).reason is Reason.OK
    assert last(-0.58 * GRAVITY).reason is Reason.NO_EXCITATION


NUMBERS = st.one_of(st.floats(), st.sampled_from([0.0, nan, inf, -inf, 100.0]))


@given(
    st.lists(st.tuples(st.integers(-2, 12), *[NUMBERS] * 6), max_size=80),
    st.sampled_from(Method),
    st.sampled_from((3, 5)),
)
def test_hostile_samples_give_known_signs_and_no_exception(
    stream: list[tuple[float, ...]], method: Method, window: int
) -> None:
    parameters = replace(EXACT, window=window, least_growth=1.0)
    load = WheelLoad(CAR, "front_left")
    detector = SlopeDetector(CORNER, method, parameters, NoSlipParameters(eta_margin=0.0), load, relaxation_length=0.3)
    stamp = STEP
    for step, *values in stream:
        stamp += int(step) * STEP
        with np.errstate(all="ignore"):
            estimate = detector.update(SlopeSample(stamp, *values))
        assert estimate.sign in (-1, 0, 1)
        if estimate.reason is Reason.OK:
            assert estimate.sign != 0
            assert estimate.indicator != 0.0
        elif estimate.reason not in (Reason.NO_EXCITATION, Reason.NOT_LASTING):
            assert estimate.sign == 0


@pytest.mark.parametrize("method", Method)
def test_locked_wheel_is_beyond_the_peak_although_nothing_moves(method: Method) -> None:
    detector = exact(method)
    for k in range(20):
        detector.update(SlopeSample((k + 1) * STEP, 100.0 - k**2 * 0.01, 300.0 + 50.0 * k, 0.0, 0.5, 30.0))
    for k in range(40):
        found = detector.update(SlopeSample((k + 21) * STEP, 0.0, 1000.0, 1.0, 0.0, 29.0))
    assert (found.sign, found.reason, found.indicator) == (-1, Reason.OK, LOCKED_INDICATOR)
    assert np.isnan(found.h)


@pytest.mark.parametrize("method", Method)
def test_slip_of_a_braked_wheel_below_the_limit_is_no_lock(method: Method) -> None:
    detector = exact(method)
    for k in range(40):
        found = detector.update(SlopeSample((k + 1) * STEP, 0.21 * 100.0 if k > 20 else 100.0, 500.0, 0.5, 0.0, 30.0))
    assert found.indicator != LOCKED_INDICATOR


def test_spike_of_the_wheel_speed_is_refused_and_leaves_no_trace() -> None:
    samples, _ = through_the_peak("dry")
    clean = run(exact(Method.NO_SLIP), samples)
    detector = exact(Method.NO_SLIP)
    for k, sample in enumerate(samples):
        if k == 60:
            spike = detector.update(changed(sample, stamp=sample.stamp - STEP // 2, wheel_speed=900.0))
            assert spike.reason is Reason.BAD_INPUT
            assert "900" in spike.text
        assert content([detector.update(sample)]) == content([clean[k]])


def test_spike_as_the_first_sample_is_forgotten_within_a_gap() -> None:
    detector = exact(Method.NO_SLIP)
    detector.update(SlopeSample(STEP, 900.0, 500.0))
    found = [detector.update(SlopeSample(k * STEP, 80.0 - 0.1 * k, 500.0)) for k in range(2, 30)]
    assert all(estimate.indicator != LOCKED_INDICATOR for estimate in found)
    assert found[-1].reason in (Reason.OK, Reason.NO_EXCITATION, Reason.NOT_READY)
    assert np.isfinite(found[-1].h)
