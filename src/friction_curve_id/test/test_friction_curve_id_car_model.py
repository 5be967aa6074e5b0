"""Closed forms and derivatives of the car's model."""

from dataclasses import replace
from math import exp, inf, log, pi

import numpy as np
import pytest
from numpy.typing import NDArray

from friction_curve_id.car.braking_samples import BrakingSamples
from friction_curve_id.car.car_balance import OF_TORQUE, car_balance
from friction_curve_id.car.car_constants import CarConstants
from friction_curve_id.car.car_model import Carried, brake_gains, gains_by_fading, motion
from friction_curve_id.car.combined_slip import tyre_slips
from friction_curve_id.car.curve_family import SHAPE_PRIORS, Family, burckhardt_k, curve_values
from friction_curve_id.car.evidence import mixture, reaching_up, unresolved
from friction_curve_id.car.fit import CurveFit
from friction_curve_id.car.node_signals import Start, delayed, departs, node_signals
from friction_curve_id.car.pitch import PitchState, pitch_of_body
from friction_curve_id.car.prior import car_prior
from friction_curve_id.car.unknowns import FADING_WORK, SHARED, Unknown
from friction_curve_id.car.wheel_equation import EquationNoise, WheelEquation, wheel_equation
from vehicle_models import burckhardt
from vehicle_models.surfaces import SURFACES
from vehicle_models.vehicle import STATED, Deviation, SharedBy
from vehicle_models.vehicle_file import load_vehicle

Array = NDArray[np.float64]
CAR = load_vehicle("compact_car")
WHEELS = (0, 1, 2, 3)
SHAPES = {Family.BURCKHARDT: (0.2, 0.0), Family.PACEJKA: (1.8, -1.0)}
FAMILIES = pytest.mark.parametrize("family", list(Family))


@FAMILIES
def test_every_curve_has_its_peak_at_one_and_is_odd(family: Family) -> None:
    for log_peak in (log(0.03), log(0.15), log(0.4)):
        curve = curve_values(family, log_peak, SHAPES[family], np.array([1.0]))
        assert curve.value == pytest.approx(1.0, abs=1e-9)
        assert curve.slope == pytest.approx(0.0, abs=1e-8)
        x = np.linspace(0.05, 4.0, 80)
        forward = curve_values(family, log_peak, SHAPES[family], x).value
        assert (forward <= 1.0 + 1e-12).all()
        assert curve_values(family, log_peak, SHAPES[family], -x).value == pytest.approx(-forward)


@FAMILIES
def test_derivatives_of_a_curve_are_those_of_its_values(family: Family) -> None:
    x, step, at = np.linspace(-0.48, 4.0, 37), 1e-6, log(0.12)
    shape = SHAPES[family]
    curve = curve_values(family, at, shape, x)

    def change(log_peak: float, first: float, second: float, along: float) -> Array:
        values = [
            curve_values(
                family, at + sign * log_peak, (shape[0] + sign * first, shape[1] + sign * second), x + sign * along
            ).value
            for sign in (step, -step)
        ]
        return np.asarray((values[0] - values[1]) / (2.0 * step))

    assert curve.slope == pytest.approx(change(0.0, 0.0, 0.0, 1.0), abs=1e-7)
    assert curve.by_log_peak == pytest.approx(change(1.0, 0.0, 0.0, 0.0), abs=1e-7)
    assert curve.by_shape[0] == pytest.approx(change(0.0, 1.0, 0.0, 0.0), abs=1e-7)
    assert curve.by_shape[1] == pytest.approx(change(0.0, 0.0, 1.0, 0.0), abs=1e-7)


@pytest.mark.parametrize("name", SURFACES)
def test_published_roads_are_of_the_burckhardt_family(name: str) -> None:
    theta = np.array(SURFACES[name])
    peak, mu_max = map(float, burckhardt.peak(theta))
    k = theta[1] * peak
    u = k - log(k) + log(0.4) + log(peak)
    assert burckhardt_k(log(peak), u) == pytest.approx(k)
    assert abs(u) < 2.0 * SHAPE_PRIORS[Family.BURCKHARDT].stddev[0]
    x = np.array([0.2, 0.7, 1.5])
    curve = curve_values(Family.BURCKHARDT, log(peak), (u, 0.0), x)
    assert mu_max * curve.value == pytest.approx(burckhardt.friction(theta, x * peak))


def test_a_steady_deceleration_moves_its_load_in_the_end_and_overshoots_first() -> None:
    unknowns = car_prior(CAR, WHEELS, SHAPE_PRIORS[Family.PACEJKA], 0.0, True).mean
    pitch = pitch_of_body(np.full(2000, 5.0), 0.005, unknowns, PitchState())
    assert pitch.load[-1] == pytest.approx(5.0, rel=1e-6)
    damping = unknowns[Unknown.PITCH_DAMPING]
    overshoot = exp(-pi * damping / (1.0 - damping**2) ** 0.5)
    assert pitch.pitch.max() == pytest.approx(5.0 * (1.0 + overshoot), rel=2e-3)


def test_pitch_goes_on_from_where_older_samples_left_it() -> None:
    unknowns = car_prior(CAR, WHEELS, SHAPE_PRIORS[Family.PACEJKA], 0.0, True).mean
    force = np.random.default_rng(1).normal(3.0, 2.0, 80)
    whole = pitch_of_body(force, 0.005, unknowns, PitchState())
    state = PitchState((force[39], force[38]), (whole.pitch[39], whole.pitch[38]), (whole.load[39], whole.load[38]))
    rest = pitch_of_body(force[40:], 0.005, unknowns, state)
    assert rest.load == pytest.approx(whole.load[40:])
    assert rest.pitch == pytest.approx(whole.pitch[40:])


def samples_of_a_braking(count: int = 90) -> tuple[BrakingSamples, Start]:
    rng = np.random.default_rng(3)
    samples = BrakingSamples(4, count)
    speed = 25.0
    for k in range(count):
        force = min(max(k - 30, 0) / 30.0, 1.0)
        slip = np.array([0.08, 0.07, 0.05, 0.05]) * force
        omega = speed * (1.0 - slip) / 0.3 + rng.normal(0.0, 0.01, 4)
        torque = np.array([700.0, 700.0, 350.0, 350.0]) * force + rng.normal(0.0, 3.0, 4)
        samples.append(0.005 * k, omega, torque, -6.0 * force, -6.0 * force * 0.005, k >= 5)
        speed -= 6.0 * force * 0.005
    return samples, Start(0.0, 25.0, 0.0, 0.0)


@FAMILIES
def test_the_jacobian_of_the_wheel_equation_is_that_of_its_errors(family: Family) -> None:
    samples, start = samples_of_a_braking()
    car = CarConstants(CAR, WHEELS)
    nodes = node_signals(car, samples, start, np.full(4, 0.01), True).subset(slice(0, 80))
    p = car_prior(CAR, WHEELS, SHAPE_PRIORS[family], 0.023, True).mean
    p[Unknown.ENGINE_DRAG], p[Unknown.PRESSURE_DELAY] = 30.0, 0.0072

    def equation(unknowns: Array) -> tuple[Array, Array]:
        moved = motion(car, nodes, unknowns, Carried())
        torque, rate = delayed(samples, nodes, start, float(unknowns[Unknown.PRESSURE_DELAY]))
        tyres = tyre_slips(car, nodes, moved, torque, family, unknowns, None)
        found = wheel_equation(car, nodes, moved, torque, rate, tyres, unknowns, 5.0)
        return found.error, found.jacobian

    jacobian = equation(p)[1]
    # Gains and inertia are smoothed on purpose; the speed's way into relaxation is left out.
    smoothed = {Unknown.LOG_GAIN_FRONT, Unknown.LOG_GAIN_REAR, Unknown.LOG_INERTIA, Unknown.FADING}
    exact = set(range(p.size)) - smoothed
    for unknown in exact:
        step = 1e-5 * max(abs(p[unknown]), 1e-2)
        up, down = p.copy(), p.copy()
        up[unknown] += step
        down[unknown] -= step
        change = (equation(up)[0] - equation(down)[0]) / (2.0 * step)
        scale = float(np.abs(change).max())
        assert jacobian[:, 3:-3, unknown] == pytest.approx(change[:, 3:-3], abs=0.03 * scale + 1e-9), unknown


def test_the_scale_of_torque_moves_no_error() -> None:
    samples, start = samples_of_a_braking()
    car = CarConstants(CAR, WHEELS)
    nodes = node_signals(car, samples, start, np.full(4, 0.01), True)
    p = car_prior(CAR, WHEELS, SHAPE_PRIORS[Family.PACEJKA], 0.023, True).mean
    moved = motion(car, nodes, p, Carried())
    torque, rate = delayed(samples, nodes, start, 0.0)
    tyres = tyre_slips(car, nodes, moved, torque, Family.PACEJKA, p, None)
    found = wheel_equation(car, nodes, moved, torque, rate, tyres, p, 5.0)
    scaled = [Unknown.LOG_GAIN_FRONT, Unknown.LOG_GAIN_REAR, Unknown.LOG_MASS, Unknown.LOG_INERTIA]
    assert found.jacobian[:, :, scaled].sum(axis=2) == pytest.approx(0.0, abs=1e-9)


def test_a_brake_fades_with_its_work() -> None:
    samples = BrakingSamples(4, 60)
    for k in range(80):
        if samples.count == 60:
            samples.drop_oldest(20)
        samples.append(0.005 * k, np.full(4, 80.0), np.array([700.0, 700.0, 350.0, 0.0]), -5.0, -0.025, True)
    car = CarConstants(CAR, WHEELS)
    nodes = node_signals(car, samples, Start(0.1, 24.0, -5.0, 0.0), np.full(4, 0.01), False)
    assert nodes.work[:, -1] == pytest.approx(80.0 * 0.005 * 78.5 * np.array([700.0, 700.0, 350.0, 0.0]))
    p = car_prior(CAR, WHEELS, SHAPE_PRIORS[Family.PACEJKA], 0.0, True).mean
    p[Unknown.LOG_GAIN_REAR] = log(0.9)
    assert brake_gains(car, nodes, p)[:, -1] == pytest.approx([1.0, 1.0, 0.9, 0.9])
    p[Unknown.FADING] = 0.2
    left = 1.0 - 0.2 * nodes.work[:, -1] / FADING_WORK
    assert brake_gains(car, nodes, p)[:, -1] == pytest.approx(left * [1.0, 1.0, 0.9, 0.9])
    assert gains_by_fading(nodes, p)[:, -1] == pytest.approx(-nodes.work[:, -1] / FADING_WORK / left)


def test_a_torque_that_runs_straight_is_met_at_any_delay() -> None:
    samples, start = samples_of_a_braking(40)
    samples.torque[:] = 1000.0 * samples.time
    nodes = node_signals(CarConstants(CAR, WHEELS), samples, start, np.full(4, 0.01), True).subset(slice(5, 30))
    for delay in (0.0, 0.0013, 0.0025, 0.01):
        torque, rate = delayed(samples, nodes, start, delay)
        assert torque[0] == pytest.approx(1000.0 * (nodes.time + delay))
        assert rate[0] == pytest.approx(1000.0)


def test_the_balance_of_a_car_that_brakes_as_it_reads_is_level() -> None:
    vehicle = replace(CAR, drag_area=0.0, rolling_resistance=0.0)
    car = CarConstants(vehicle, WHEELS)
    samples = BrakingSamples(4, 60)
    deceleration = 1400.0 / (0.3 * 1500.0) / (1.0 + 4.0 / (0.3**2 * 1500.0))
    for k in range(60):
        speed = 25.0 - deceleration * 0.005 * k
        torque = np.full(4, 350.0)
        samples.append(0.005 * k, np.full(4, speed / 0.3), torque, -deceleration, -deceleration * 0.005, True)
    start = Start(0.0, 25.0, -deceleration, 0.0)
    nodes = node_signals(car, samples, start, np.full(4, 0.01), False)
    p = car_prior(vehicle, WHEELS, SHAPE_PRIORS[Family.PACEJKA], 0.023, True).mean
    p[Unknown.PITCH_READING] = 0.0
    moved = motion(car, nodes, p, Carried())
    torque = np.full((4, 59), 350.0)
    tyres = tyre_slips(car, nodes, moved, torque, Family.PACEJKA, p, None)
    errors, rows = car_balance(car, nodes, moved, tyres, torque, np.zeros((4, 59, len(OF_TORQUE))), p)
    assert errors == pytest.approx(0.0, abs=0.02)
    assert rows.shape == (len(errors), SHARED + 4)


@pytest.mark.parametrize("family", Family)
def test_the_torque_of_a_locked_wheel_moves_nothing_but_that_of_the_others_does(family: Family) -> None:
    """Its brake holds with less than its pressure would make, which no equation may believe."""
    p = car_prior(CAR, WHEELS, SHAPE_PRIORS[family], 0.023, True)
    rear = 2

    def cost(torque: float, wheel: int) -> tuple[float, Array]:
        samples, start = samples_of_a_braking()
        samples.wheel_speed[rear, 60:75] = 0.0
        samples.torque[wheel, 64:71] = torque
        car = CarConstants(CAR, WHEELS)
        nodes = node_signals(car, samples, start, np.full(4, 0.01), True)
        found = CurveFit(car, p, family, 5.0, True).linearise(samples, nodes, start)
        return found.cost, found.gradient

    for torque in (700.0, 3000.0):
        assert cost(torque, rear)[0] == pytest.approx(cost(350.0, rear)[0])
        assert cost(torque, rear)[1] == pytest.approx(cost(350.0, rear)[1])
    assert cost(3000.0, 0)[0] > 1.1 * cost(700.0, 0)[0]


def test_a_wheel_may_stand_where_no_tooth_comes_between_two_samples() -> None:
    car = CarConstants(CAR, WHEELS)
    samples, start = samples_of_a_braking()
    one_tooth = 2.0 * pi / (48 * 0.005)
    samples.wheel_speed[2, 60:63] = 0.9 * one_tooth, 0.0, 0.9 * one_tooth
    samples.wheel_speed[3, 60:63] = 1.1 * one_tooth
    counted = node_signals(car, samples, start, np.full(4, 0.01), True)
    assert set(np.flatnonzero(~counted.turning[2])) == set(range(57, 65))
    assert counted.turning[[0, 1, 3]].all()


def test_what_a_file_does_not_state_has_a_stated_deviation_and_zero_means_exactly() -> None:
    exact = replace(CAR, deviations={"mass": Deviation(0.0, SharedBy.ALL)})
    silent = replace(CAR, deviations={})
    assert car_prior(exact, WHEELS, SHAPE_PRIORS[Family.PACEJKA], 0.0, True).stddev[Unknown.LOG_MASS] == 0.0
    assert car_prior(silent, WHEELS, SHAPE_PRIORS[Family.PACEJKA], 0.0, True).stddev[Unknown.LOG_MASS] == pytest.approx(
        STATED["mass"]
    )


def test_no_family_alone_is_sure_while_the_peak_has_not_been_seen() -> None:
    near, far = np.zeros(SHARED + 4), np.zeros(SHARED + 4)
    far[Unknown.LOG_LAMBDA_MAX] = 1.0
    covariance = np.eye(SHARED + 4) * 1e-4
    unseen = mixture([near, far], [covariance] * 2, [0.0, -1000.0], 0.0, False)
    seen = mixture([near, far], [covariance] * 2, [0.0, -1000.0], 0.0, True)
    assert max(unseen.weights) < 0.9 < max(seen.weights)
    assert unseen.log_lambda_stddev > seen.log_lambda_stddev


def test_a_fit_that_still_moves_is_not_known_to_better_than_its_steps() -> None:
    known, covariance = np.zeros(SHARED + 4), np.eye(SHARED + 4) * 1e-4
    still = mixture([known] * 2, [covariance] * 2, [0.0, 0.0], 0.0, False, [0.0, 0.0])
    moving = mixture([known] * 2, [covariance] * 2, [0.0, 0.0], 0.0, False, [0.3, 0.3])
    assert still.log_mu_stddev < 0.03
    assert moving.log_mu_stddev > 0.3
    assert moving.log_lambda_stddev == still.log_lambda_stddev


@pytest.mark.parametrize("log_stddev", [0.02, 0.3, 0.8])
def test_an_interval_reaches_as_far_up_as_that_of_the_logarithm(log_stddev: float) -> None:
    assert 1.0 + 1.96 * reaching_up(log_stddev) == pytest.approx(exp(1.96 * log_stddev))


@pytest.mark.parametrize("log_stddev", [11.0, 400.0, 1e9])
def test_a_deviation_of_which_nothing_is_known_is_huge_and_no_error(log_stddev: float) -> None:
    """Slip that jumps by many lambda_max from sample to sample, on a peak that is fitted as nearly zero."""
    assert reaching_up(5.0) < reaching_up(log_stddev) < inf


@pytest.mark.parametrize("continued", [False, True])
def test_noise_is_whitened_and_corrections_of_the_wheel_speeds_are_the_most_likely_ones(continued: bool) -> None:
    """Against dense matrices: white torque noise, wheel speeds that two errors share, and a load that lasts 20 ms."""
    samples, start = samples_of_a_braking(12)
    nodes = node_signals(CarConstants(CAR, WHEELS), samples, start, np.full(4, 0.05), False)
    n = nodes.time.size
    rng = np.random.default_rng(5)
    error, by_slip = rng.normal(0.0, 3.0, (4, n)), rng.normal(50.0, 30.0, (4, n))
    fixed, load = rng.uniform(1.0, 5.0, (4, n)), rng.uniform(1e3, 1e4, (4, n))
    unused = np.zeros((4, n, 0))
    noise = EquationNoise(nodes, WheelEquation(error, unused, fixed, load, error, by_slip, None), continued)
    factor = noise.factor(3)  # 0.03
    white = noise.whitened(factor, error.reshape(-1, 1).copy())[:, 0]
    found = noise.correction(factor, white)
    keep = np.exp(-nodes.interval[1:] / 0.02)
    expected = 0.0
    for wheel in range(4):
        a = np.zeros((n, n + 1))
        for k in range(n):
            a[k, k : k + 2] = 0.5 * by_slip[wheel, k] + np.array([-1.0, 1.0]) / nodes.interval[k]
        innovations = 0.03**2 * load[wheel] * np.append(1.0, 1.0 - keep**2)
        if continued:
            innovations[0] += 1e8
        lasting = np.linalg.inv(np.eye(n) - np.diag(keep, -1))
        variance = np.diag(nodes.wheel_noise[wheel] ** 2)
        whole = np.diag(fixed[wheel] + 0.03**2 * load[wheel]) + a @ variance @ a.T
        whole += lasting @ np.diag(innovations) @ lasting.T
        by_error = np.linalg.solve(whole, error[wheel])
        expected += float(error[wheel] @ by_error)
        assert found[wheel] == pytest.approx(-(variance @ a.T @ by_error), rel=1e-5, abs=1e-9)
    assert float(white @ white) == pytest.approx(expected)


def test_one_unknown_far_from_the_vehicle_file_is_a_surprise_where_little_is_found() -> None:
    """Counted over all 28 unknowns, most of which a gentle braking does not move, 6 deviations of one were none."""
    samples, start = samples_of_a_braking()
    car = CarConstants(CAR, WHEELS)
    nodes = node_signals(car, samples, start, np.full(4, 0.01), True)
    fit = CurveFit(car, car_prior(CAR, WHEELS, SHAPE_PRIORS[Family.PACEJKA], 0.023, True), Family.PACEJKA, 5.0, True)
    fit.step(samples, nodes.subset(slice(0, 80)), start)
    fit.z = np.zeros(SHARED + 4)
    assert fit.surprise < 0.0
    fit.z[Unknown.LOG_INERTIA] = 6.0
    assert fit.surprise > 3.0


def test_a_peak_that_is_crossed_in_few_samples_is_not_resolved() -> None:
    slow, fast = (np.linspace(0.0, 0.3, n)[np.newaxis] for n in (61, 7))
    assert unresolved(slow, 0.13) < 0.01
    assert 0.2 < unresolved(fast, 0.13) < 0.4
    assert unresolved(np.full((4, 10), 0.05), 0.13) == 0.0


@FAMILIES
def test_evidence_without_the_newest_nodes_is_that_of_a_fit_that_has_not_seen_them(family: Family) -> None:
    samples, start = samples_of_a_braking()
    car = CarConstants(CAR, WHEELS)
    nodes = node_signals(car, samples, start, np.full(4, 0.01), True)

    def fit(count: int) -> CurveFit:
        made = CurveFit(car, car_prior(CAR, WHEELS, SHAPE_PRIORS[family], 0.023, True), family, 5.0, False)
        for _ in range(8):
            made.step(samples, nodes.subset(slice(0, count)), start)
        return made

    early, late = fit(76), fit(80)
    missing = early.log_evidence - late.log_evidence_until(late.newest)
    left = early.log_evidence - late.log_evidence_until(early.newest)
    assert early.log_evidence_until(early.newest) == early.log_evidence
    assert abs(left) < 0.2 * abs(missing)


def test_a_fit_that_begins_again_takes_all_but_the_shape_from_the_other() -> None:
    samples, start = samples_of_a_braking()
    car = CarConstants(CAR, WHEELS)
    nodes = node_signals(car, samples, start, np.full(4, 0.01), True)
    fits = [CurveFit(car, car_prior(CAR, WHEELS, SHAPE_PRIORS[each], 0.023, True), each, 5.0, True) for each in Family]
    fits[0].step(samples, nodes.subset(slice(0, 80)), start)
    fits[1].begin_at(fits[0])
    shared = [each for each in range(SHARED + 4) if each not in (Unknown.SHAPE_1, Unknown.SHAPE_2)]
    assert (fits[1].unknowns[shared] == fits[0].unknowns[shared]).all()
    shape = fits[1].unknowns[[Unknown.SHAPE_1, Unknown.SHAPE_2]]
    assert tuple(shape) == SHAPE_PRIORS[Family.PACEJKA].mean


def test_a_fit_forgets_what_older_samples_said_but_not_how_its_car_moved() -> None:
    samples, start = samples_of_a_braking()
    car = CarConstants(CAR, WHEELS)
    nodes = node_signals(car, samples, start, np.full(4, 0.01), True)
    fits = [
        CurveFit(car, car_prior(CAR, WHEELS, SHAPE_PRIORS[Family.PACEJKA], 0.023, True), Family.PACEJKA, 5.0, True)
        for _ in range(2)
    ]
    for fit in fits:
        fit.step(samples, nodes.subset(slice(0, 80)), start)
        fit.fold(samples, nodes, start, 20, 1.0)
    samples.drop_oldest(20)
    rest = node_signals(car, samples, start, np.full(4, 0.01), True)
    fits[0].fold(samples, rest, start, 20, 1.0)
    fits[1].forget(rest, 20)
    assert fits[0].past.information.any()
    assert np.flatnonzero(fits[1].past.information).tolist() == [Unknown.START_SPEED * (SHARED + 5)]
    assert not fits[1].past.gradient.any()
    assert fits[1].carried.slip == pytest.approx(fits[0].carried.slip)
    assert fits[1].carried.pitched == fits[0].carried.pitched


def test_a_path_that_begins_to_bend_anew_stays_as_bent_as_it_was() -> None:
    """What is known of the bend when samples leave the window stays, and how it will grow is known less."""
    samples, start = samples_of_a_braking()
    car = CarConstants(CAR, WHEELS)
    nodes = node_signals(car, samples, start, np.full(4, 0.01), True)
    prior = car_prior(CAR, WHEELS, SHAPE_PRIORS[Family.BURCKHARDT], 0.023, True)
    fit = CurveFit(car, prior, Family.BURCKHARDT, 5.0, True)
    fit.step(samples, nodes.subset(slice(0, 80)), start)
    told = fit.linearise(samples, nodes.subset(slice(0, 40)), start, adapt=False).information
    fit.fold(samples, nodes, start, 40, 1.0)

    def stddev(information: Array, time: float) -> float:
        along = np.zeros_like(prior.stddev)
        along[Unknown.CURVE] = prior.stddev[Unknown.CURVE]
        along[Unknown.CURVE_RATE] = time * prior.stddev[Unknown.CURVE_RATE]
        return float(np.sqrt(along @ np.linalg.solve(information + np.eye(along.size), along)))

    left = float(nodes.time[40])
    unchanged, later = (stddev(told, time) for time in (left, left + 1.0))
    assert stddev(fit.past.information, left) == pytest.approx(unchanged, rel=0.05)
    assert stddev(fit.past.information, left + 1.0) > 1.01 * later


def test_intervals_after_going_astray_count_how_far_the_formulas_are_apart() -> None:
    low, high, covariance = np.zeros(SHARED + 4), np.zeros(SHARED + 4), np.eye(SHARED + 4) * 1e-4
    high[[Unknown.LOG_LAMBDA_MAX, Unknown.LOG_MU_MAX]] = 0.2, 0.06
    before, after = (
        mixture([low, high], [covariance] * 2, [0.0, -50.0], 0.0, True, gone_astray=each) for each in (False, True)
    )
    assert (after.log_lambda_max, after.log_mu_max) == (before.log_lambda_max, before.log_mu_max)
    assert before.log_lambda_stddev < 0.1 and after.log_lambda_stddev > 0.2
    assert before.log_mu_stddev < 0.03 and after.log_mu_stddev > 0.06


@pytest.mark.parametrize(("slip", "within", "expected"), [(0.1, 0.1, True), (0.1, 0.6, False), (0.03, 0.1, False)])
def test_a_wheel_departs_from_its_car_by_much_slip_within_a_tenth_of_a_second(
    slip: float, within: float, expected: bool
) -> None:
    samples = BrakingSamples(4, 200)
    for k in range(200):
        speed = 25.0 - 5.0 * 0.005 * k
        slips = np.array([slip, 0.0, 0.0, 0.0]) * min(0.005 * k / within, 1.0)
        samples.append(0.005 * k, speed * (1.0 - slips) / 0.3, np.full(4, 400.0), -5.0, -0.025, True)
    nodes = node_signals(CarConstants(CAR, WHEELS), samples, Start(0.0, 25.0, -5.0, -0.025), np.full(4, 0.01), False)
    assert departs(CarConstants(CAR, WHEELS), nodes) is expected
