"""The equations (8.3) to (8.6), each alone, against closed forms and finite differences."""

from functools import partial
from math import inf, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from corner_sim.corner import SingleCorner
from friction_slope.crossing import CrossingDetector
from friction_slope.estimate import SlopeSample
from friction_slope.indicator import eta_sign, normalised_deceleration, slip_rate_sign, slope_indicator
from friction_slope.signals import SignalWindow
from friction_slope.tyre_relaxation import TyreRelaxation
from vehicle_models import burckhardt
from vehicle_models.surfaces import TABLE_8_1, surface
from vehicle_models.vehicle_file import load_vehicle

DT = 0.005
STEP = 5_000_000
CORNER = load_vehicle("chapter_corner").corner("front_left")


def fed(window: SignalWindow, speeds: np.ndarray, torques: np.ndarray, first: int = 1) -> SignalWindow:
    for k, (speed, torque) in enumerate(zip(speeds, torques, strict=True)):
        window.update(SlopeSample((first + k) * STEP, float(speed), float(torque)))
    return window


@given(st.floats(-50.0, 50.0), st.floats(-5e3, 5e3), st.floats(0.2, 5.0))
def test_h_is_the_jerk_plus_the_torque_rate_over_the_inertia(jerk: float, torque_rate: float, inertia: float) -> None:
    time = np.arange(12) * DT
    window = fed(SignalWindow(inertia, 12, 12, 0.0), 80.0 + 0.5 * jerk * time**2, 100.0 + torque_rate * time)
    assert window.h() == pytest.approx(jerk + torque_rate / inertia, abs=1e-5 * (1.0 + abs(torque_rate)))


def test_torque_steps_that_the_wheel_answers_leave_no_trace_in_h() -> None:
    """omega_dot = (M - T_b) / J with a constant friction moment M: H is zero whatever the brake does."""
    rng = np.random.default_rng(0)
    torque = rng.uniform(0.0, 1000.0, 60)
    impulse = np.concatenate([[0.0], np.cumsum(0.5 * DT * (torque[1:] + torque[:-1]))])
    window = SignalWindow(1.0, 9, 9, 0.0)
    for k in range(60):
        window.update(SlopeSample((k + 1) * STEP, float(100.0 + 300.0 * k * DT - impulse[k]), float(torque[k])))
        if window.ready:
            assert window.h() == pytest.approx(0.0, abs=1e-6)
            assert window.friction_moment() == pytest.approx(300.0, abs=1e-8)


@pytest.mark.parametrize("name", TABLE_8_1)
def test_h_of_a_simulated_wheel_is_gamma_times_slope_times_slip_rate(name: str) -> None:
    """The right-hand side of (8.3), from the plant's own truth, at the centre of the shortest window."""
    theta = surface(name)
    corner = SingleCorner(CORNER, [30.0], max_step=2.5e-4)
    hold = 0.9 * float(CORNER.peak_torque(theta))
    window, history = SignalWindow(CORNER.inertia, 3, 3, 0.0), []
    torque = 0.0
    checked = 0
    for k in range(140):
        slip, speed, omega = float(corner.slip[0]), float(corner.speed[0]), float(corner.wheel_speed[0])
        omega_dot = float(corner.wheel_acceleration(theta, torque)[0])
        slip_rate = ((1.0 - slip) * float(corner.acceleration(theta)[0]) - CORNER.radius * omega_dot) / speed
        gamma = CORNER.radius * CORNER.vertical_load / CORNER.inertia
        history.append(gamma * float(burckhardt.slope(theta, slip)) * slip_rate)
        window.update(SlopeSample((k + 1) * STEP, omega, torque))
        if k > 70:
            assert window.h() == pytest.approx(history[-2], abs=2e-3 * max(map(abs, history)))
            checked += 1
        after = min(torque + hold / 50.0, hold)
        corner.step(torque, after, theta, DT)
        torque = after
    assert checked == 69


@pytest.mark.parametrize(("lead", "delay"), [(0.0, 0.04), (1.0, 0.0), (2.0, -0.04), (0.5, 0.02)])
def test_delay_follows_from_window_and_lead(lead: float, delay: float) -> None:
    window = fed(SignalWindow(1.0, 17, 3, lead), np.full(20, 50.0), np.zeros(20))
    assert window.delay == pytest.approx(delay)


def test_part_of_h_that_a_changing_load_causes_is_the_friction_moment_times_its_relative_rate() -> None:
    """With mu constant, J z_dot = r mu Fz: all of H is that of the load."""
    inertia, moment = 1.3, 400.0
    window = SignalWindow(inertia, 9, 9, 0.0)
    speed = 100.0
    for k in range(20):
        relative = 1.0 + 0.8 * k * DT
        window.update(SlopeSample((k + 1) * STEP, speed, 0.0), load=2500.0 * relative)
        speed += DT * moment / inertia * (relative + 0.4 * DT)
    assert window.h() == pytest.approx(moment / inertia * 0.8, rel=1e-6)
    assert window.h_of_load() == pytest.approx(window.h(), rel=1e-3)


def test_load_that_was_unknown_anywhere_in_the_window_tells_nothing() -> None:
    window = SignalWindow(1.0, 5, 3, 0.0)
    known = []
    for k in range(12):
        window.update(SlopeSample((k + 1) * STEP, 50.0, 0.0), load=nan if k == 5 else 2500.0)
        if window.ready:
            known.append(not np.isnan(window.h_of_load()))
    assert known == [True] + [False] * 5 + [True] * 2


def test_slip_that_the_tyre_has_built_up_follows_over_its_relaxation_length() -> None:
    tyre = TyreRelaxation(0.3)
    assert tyre.update(1 * STEP, 0.02, 30.0) == 0.02
    assert tyre.update(3 * STEP, 0.12, 30.0) == pytest.approx(0.12 - 0.1 * np.exp(-1.0))


def test_slip_that_was_lost_is_built_up_when_it_is_back() -> None:
    tyre = TyreRelaxation(0.3)
    tyre.update(1 * STEP, 0.02, 30.0)
    assert np.isnan(tyre.update(2 * STEP, nan, 30.0))
    assert tyre.update(3 * STEP, 0.12, 30.0) == 0.12
    assert np.isnan(tyre.update(4 * STEP, 0.12, nan))


def test_slip_is_read_where_h_is_read() -> None:
    window = SignalWindow(1.0, 9, 3, 0.0)
    for k in range(20):
        window.update(SlopeSample((k + 1) * STEP, 50.0, 0.0, slip_rate=2.0), slip=0.01 * k)
    assert window.slip() == pytest.approx(0.01 * (19 - 4))
    assert window.slip_rate() == pytest.approx(2.0)


def test_unknown_slip_makes_the_slip_unknown_and_nothing_else() -> None:
    window = SignalWindow(1.0, 9, 3, 0.0)
    for k in range(20):
        slip = nan if k == 15 else 0.1
        window.update(SlopeSample((k + 1) * STEP, 50.0 - k, 0.0, slip=slip, slip_rate=slip))
    assert np.isnan(window.slip())
    assert window.slip_rate() == pytest.approx(0.1)
    assert window.wheel_acceleration() == pytest.approx(-200.0)


@given(st.floats(0.0, 0.95), st.floats(-1.2, 1.2), st.floats(-20.0, 20.0, allow_subnormal=False), st.floats(2.0, 60.0))
def test_eta_tells_the_sign_of_the_slip_rate_wherever_it_says_one(
    slip: float, friction: float, eta: float, speed: float
) -> None:
    """(8.6): slip_rate = (g / v)(eta - (1 - slip) mu) when the whole car brakes with this wheel's friction."""
    slip_rate = 9.81 / speed * (eta - (1.0 - slip) * friction)
    sign = eta_sign(eta, friction, 0.0, 0.0, speed)
    assert sign in (0, np.sign(slip_rate)) or eta == 0.0


def test_eta_has_no_sign_in_the_interval_of_disagreement() -> None:
    signs = [eta_sign(eta, 0.8, 0.1, 0.0, 20.0) for eta in (-0.2, -0.1, 0.0, 0.5, 0.85, 0.95)]
    assert signs == [-1, 0, 0, 0, 0, 1]
    assert eta_sign(0.05, -0.3, 0.0, 0.0, 20.0) == 1


def test_wheel_that_gains_speed_with_its_car_does_not_return_from_a_slip() -> None:
    """A car that is pulled by 0.3 g: by (8.6) the slip falls where its wheel gains more speed than that."""
    assert [eta_sign(eta, -0.3, 0.05, 0.0, 20.0) for eta in (-0.4, -0.34, -0.1)] == [-1, 0, 0]


def test_dead_zone_of_the_slip_rate_is_the_same_at_every_speed() -> None:
    for speed in (3.0, 30.0):
        eta = 0.8 + 0.5 * speed / 9.81
        assert eta_sign(eta + 1e-9, 0.8, 0.0, 0.5, speed) == 1
        assert eta_sign(eta - 1e-9, 0.8, 0.0, 0.5, speed) == 0


def test_normalised_deceleration_is_that_of_the_book() -> None:
    assert normalised_deceleration(-32.7, 0.3) == pytest.approx(1.0)


@given(st.floats(-10.0, 10.0), st.floats(0.0, 5.0))
def test_slip_rate_sign_is_odd_and_zero_within_the_dead_zone(rate: float, zone: float) -> None:
    sign = slip_rate_sign(rate, zone)
    assert sign == -slip_rate_sign(-rate, zone)
    assert (sign == 0) == (abs(rate) <= zone)


def test_unknown_slip_rate_has_no_sign() -> None:
    assert slip_rate_sign(nan, 0.0) == 0


@given(st.floats(-1e3, 1e3), st.floats(-2.0, 2.0), st.floats(0.1, 1e4))
def test_sign_of_the_indicator_is_that_of_the_slope(slope: float, slip_rate: float, gain: float) -> None:
    """(8.4): H = gain mu_1 slip_rate by (8.3), so its sign times that of the slip rate is the sign of mu_1."""
    h = gain * slope * slip_rate
    assert np.sign(slope_indicator(h, slip_rate_sign(slip_rate, 0.0))) == (np.sign(slope) if h != 0.0 else 0.0)


def test_indicator_keeps_the_size_of_h_and_is_zero_in_the_dead_zone() -> None:
    assert [slope_indicator(-30.0, growing) for growing in (1, 0, -1)] == [-30.0, 0.0, 30.0]


def test_sign_is_held_between_the_thresholds_and_crossings_are_recorded() -> None:
    detector = CrossingDetector(-10.0, 100.0)
    steps = [(50.0, 1), (150.0, 1), (-5.0, 1), (-10.0, 1), (50.0, -1), (100.0, -1)]
    signs = []
    for k, (indicator, growing) in enumerate(steps):
        detector.update(indicator, growing, partial(float, 0.1 * k), k + 1)
        signs.append(detector.sign)
    assert signs == [0, 1, 1, -1, -1, 1]
    assert (detector.crossings, detector.crossing_sign, detector.stamp) == (2, 1, 6)
    assert detector.slip == pytest.approx(0.5)


def test_peak_is_not_crossed_against_the_direction_of_the_slip() -> None:
    detector = CrossingDetector(-10.0, 10.0)
    detector.update(50.0, 1, lambda: 0.1, 1)
    for growing in (-1, 0):
        detector.update(-inf, growing, lambda: 0.2, 2)
        assert detector.sign == 1
    detector.update(-50.0, 1, lambda: 0.2, 3)
    detector.update(inf, 1, lambda: 0.3, 4)
    assert (detector.sign, detector.crossings) == (-1, 1)


def test_the_first_that_is_heard_of_a_wheel_beyond_the_peak_is_a_slip_that_grows() -> None:
    detector = CrossingDetector(-10.0, 10.0)
    detector.update(-50.0, -1, lambda: 0.1, 1)
    assert detector.sign == 0
    detector.update(-50.0, 1, lambda: 0.1, 2)
    assert (detector.sign, detector.crossings) == (-1, 0)


def test_a_sign_beyond_the_peak_that_is_contradicted_within_its_trial_is_withdrawn() -> None:
    detector = CrossingDetector(-10.0, 100.0)
    steps = [(-20.0, 1), (5.0, 1), (-5.0, 1), (-20.0, 1), (0.0, 0), (-1.0, 1), (5.0, 1), (150.0, 1)]
    signs = []
    for k, (indicator, growing) in enumerate(steps):
        detector.update(indicator, growing, lambda: 0.1, k + 1, trial=3)
        signs.append(detector.sign)
    assert signs == [-1, 0, 0, -1, 0, 0, 0, 1]
    assert detector.crossings == 0


def test_stability_regained_within_the_trial_is_a_crossing() -> None:
    detector = CrossingDetector(-10.0, 100.0)
    detector.update(-20.0, 1, lambda: 0.2, 1, trial=3)
    detector.update(150.0, -1, lambda: 0.1, 2, trial=3)
    assert (detector.sign, detector.crossings, detector.crossing_sign) == (1, 1, 1)


def test_zero_thresholds_are_plain_signs_and_zero_is_none() -> None:
    detector = CrossingDetector(0.0, 0.0)
    detector.update(0.0, 0, lambda: 0.1, 1)
    assert detector.sign == 0
    detector.update(1e-12, 1, lambda: 0.1, 2)
    assert detector.sign == 1


@pytest.mark.parametrize("thresholds", [(1.0, 2.0), (-1.0, -0.5), (nan, 1.0)])
def test_thresholds_of_the_wrong_sign_are_refused(thresholds: tuple[float, float]) -> None:
    with pytest.raises(ValueError, match="h_instability"):
        CrossingDetector(*thresholds)
