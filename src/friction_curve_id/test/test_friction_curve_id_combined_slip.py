"""Curves: slips across from the forces of the axles, their way into the Jacobian, and stops of a car that steers."""

from collections.abc import Iterator
from dataclasses import replace
from math import exp, log, nan

import numpy as np
import pytest
from numpy.typing import NDArray

from corner_sim.car.car import STEP
from corner_sim.car.cornering_car import CorneringCar
from corner_sim.car.driving import SlipCycle
from corner_sim.car.measured_car import MeasuredCar
from corner_sim.car.random_car import random_car
from friction_curve_id.car import CarEstimator, CarSample
from friction_curve_id.car.braking_samples import BrakingSamples
from friction_curve_id.car.car_constants import CarConstants
from friction_curve_id.car.car_model import Carried, motion
from friction_curve_id.car.combined_slip import TyreSlips, shows_friction, tyre_slips
from friction_curve_id.car.curve_family import SHAPE_PRIORS, Family
from friction_curve_id.car.node_signals import Nodes, Start, delayed, node_signals, turning_beside_brakes
from friction_curve_id.car.prior import car_prior
from friction_curve_id.car.rear_slip import rear_slip
from friction_curve_id.car.unknowns import Unknown
from friction_curve_id.car.wheel_equation import wheel_equation
from friction_curve_id.interface import CurveEstimate
from vehicle_models.constants import GRAVITY
from vehicle_models.lateral_forces import ACROSS
from vehicle_models.vehicle_file import load_vehicle

Array = NDArray[np.float64]
CAR = load_vehicle("compact_car")
WHEELS = (0, 1, 2, 3)
FAMILIES = pytest.mark.parametrize("family", list(Family))
LEFTWARD = 4.0


def braking_in_a_curve(count: int = 90) -> tuple[BrakingSamples, Start]:
    samples, speed = BrakingSamples(4, count), 25.0
    yaw_rate = LEFTWARD / speed
    for k in range(count):
        force = min(max(k - 30, 0) / 30.0, 1.0)
        ground = speed - np.array([0.75, -0.75, 0.75, -0.75]) * yaw_rate
        omega = ground * (1.0 - np.array([0.08, 0.07, 0.05, 0.05]) * (0.02 + force)) / 0.3
        torque = np.array([700.0, 700.0, 350.0, 350.0]) * force
        samples.append(0.005 * k, omega, torque, -6.0 * force, -6.0 * force * 0.005, k >= 5)
        samples.turn(yaw_rate, LEFTWARD, (LEFTWARD - speed * yaw_rate) * 0.005 * k, LEFTWARD)
        speed -= 6.0 * force * 0.005
    return samples, Start(0.0, 25.0, 0.0, 0.0)


def signals(samples: BrakingSamples, start: Start) -> Nodes:
    return node_signals(CarConstants(CAR, WHEELS), samples, start, np.full(4, 0.01), True).subset(slice(0, 80))


def in_a_curve(family: Family) -> Array:
    p = car_prior(CAR, WHEELS, SHAPE_PRIORS[family], 0.023, True, 25.0).mean
    p[Unknown.LOG_MU_MAX], p[Unknown.ENGINE_DRAG] = log(1.0), 30.0
    return p


def slips_at(samples: BrakingSamples, start: Start, nodes: Nodes, family: Family, p: Array) -> TyreSlips:
    car = CarConstants(CAR, WHEELS)
    torque, _ = delayed(samples, nodes, start, float(p[Unknown.PRESSURE_DELAY]))
    moved = motion(car, nodes, p, Carried())
    found = tyre_slips(car, nodes, moved, torque, family, p, None)
    for _ in range(3):
        found = tyre_slips(car, nodes, moved, torque, family, p, found.across)
    return found


@FAMILIES
def test_the_lateral_forces_of_the_tyres_are_those_that_the_axles_need(family: Family) -> None:
    samples, start = braking_in_a_curve()
    nodes, p = signals(samples, start), in_a_curve(family)
    tyres = slips_at(samples, start, nodes, family, p)
    assert tyres.across is not None
    assert (tyres.across[0] == tyres.across[1]).all() and (tyres.across[2] == tyres.across[3]).all()
    car = CarConstants(CAR, WHEELS)
    moved = motion(car, nodes, p, Carried())
    load = moved.load
    force = ACROSS * exp(p[Unknown.LOG_MU_MAX]) * load * tyres.curve.value * tyres.across / np.abs(tyres.size)
    torque, _ = delayed(samples, nodes, start, float(p[Unknown.PRESSURE_DELAY]))
    backward = ((torque + car.inertia * nodes.wheel_acceleration) / car.radius)[:2].sum(axis=0)
    steering = CAR.wheelbase * nodes.yaw_rate / moved.speed + tyres.across[0] - tyres.across[2]
    assert force.sum(axis=0) == pytest.approx(CAR.mass * LEFTWARD + backward * steering, rel=0.003)
    assert (backward * steering).max() > 0.01 * CAR.mass * LEFTWARD
    assert np.all(load[1] > load[0])


@pytest.mark.parametrize("count", [5, 12, 80])
def test_the_turning_by_lateral_forces_is_free_of_the_moment_of_the_brakes(count: int) -> None:
    samples, start = braking_in_a_curve()
    nodes = signals(samples, start).subset(slice(0, count))
    time = nodes.time
    moment = 3.0 * np.sign(np.sin(90.0 * time))  # brakes that come and go
    by_brakes = np.concatenate([[0.0], np.cumsum(0.5 * (moment[1:] + moment[:-1]) * np.diff(time))])
    nodes = replace(nodes, yaw_rate=0.3 + 0.5 * time - 2.0 * time**2 + by_brakes)
    assert turning_beside_brakes(nodes, moment) == pytest.approx(0.5 - 4.0 * time, abs=1e-9)


def test_a_straight_road_leaves_no_slip_across_and_shows_all_frictions() -> None:
    samples, start = braking_in_a_curve()
    samples.straighten()
    tyres = slips_at(samples, start, signals(samples, start), Family.PACEJKA, in_a_curve(Family.PACEJKA))
    assert tyres.across is None
    assert shows_friction(tyres, 1.0) is True


@FAMILIES
def test_the_jacobian_in_a_curve_is_that_of_the_errors(family: Family) -> None:
    samples, start = braking_in_a_curve()
    car, nodes, p = CarConstants(CAR, WHEELS), signals(samples, start), in_a_curve(family)

    def errors(unknowns: Array) -> tuple[Array, Array, Array, Array]:
        moved = motion(car, nodes, unknowns, Carried())
        torque, rate = delayed(samples, nodes, start, float(unknowns[Unknown.PRESSURE_DELAY]))
        tyres = slips_at(samples, start, nodes, family, unknowns)
        found = wheel_equation(car, nodes, moved, torque, rate, tyres, unknowns, 5.0)
        assert found.across_gradient is not None and tyres.across is not None
        fixed = replace(tyres, across_stddev=0.0)
        of_rear, rows = rear_slip(car, nodes, moved, fixed, found.across_gradient, unknowns)
        return found.error, found.jacobian, of_rear, rows

    _, jacobian, _, rows = errors(p)
    # Gains, delay and inertia also move the yaw moment of the brakes, which is left out.
    for unknown in set(range(p.size)) - {*range(Unknown.LOG_GAIN_FRONT, Unknown.ACCELEROMETER_DELAY), Unknown.FADING}:
        step = 1e-4 * max(abs(p[unknown]), 1e-2)
        up, down = p.copy(), p.copy()
        up[unknown] += step
        down[unknown] -= step
        above, below = errors(up), errors(down)
        change = (above[0] - below[0]) / (2.0 * step)
        scale = float(np.abs(change).max())
        assert jacobian[:, 3:-3, unknown] == pytest.approx(change[:, 3:-3], abs=0.06 * scale + 1e-6), unknown
        if unknown in (Unknown.SIDEWAYS, Unknown.LATERAL_OFFSET, Unknown.LOG_ACROSS, Unknown.LOG_LAMBDA_MAX):
            of_rear = (above[2] - below[2]) / (2.0 * step)
            assert rows[:, unknown] == pytest.approx(of_rear, abs=0.05 * float(np.abs(of_rear).max()))


def stop_in_a_curve(lateral: float, measured: bool) -> Iterator[tuple[float, float, CurveEstimate]]:
    """Time since the first passing of the peak [s], lambda_max and the estimate of the front left wheel."""
    drawn = random_car(41_003, "dry", "burckhardt")
    parameters = drawn.parameters
    car = CorneringCar(parameters, 25.0, 3)
    sensors, pedal = MeasuredCar(parameters, 25.0, 3, car), SlipCycle(parameters, drawn.cycling)
    estimator = CarEstimator(CAR)
    lambda_max, passed = parameters.tyres[0].peak[0], nan
    for step in range(2200):
        time = sensors.time
        if step % sensors.steps_per_sample == 0:
            read = sensors.measure()
            across = (car.lateral_acceleration, car.yaw_rate) if measured else (nan, nan)
            answer = estimator.update(
                CarSample(time, read.wheel_speed, read.brake_pressure, read.acceleration, *across)
            )[0]
            if isinstance(answer, CurveEstimate):
                yield time - passed, lambda_max, answer
        if np.isnan(passed) and max(car.tyre_slip) > lambda_max:
            passed = time
        curvature = lateral * GRAVITY * min(time / 0.5, 1.0) / car.speed**2
        sensors.step(pedal.pressure(time, STEP, car), 0.0, 0.0, curvature)


def test_the_peak_is_known_soon_after_it_was_passed_in_a_curve() -> None:
    valid = [(time, peak, curve) for time, peak, curve in stop_in_a_curve(0.5, measured=True) if curve.valid]
    assert valid and valid[0][0] < 0.6
    for _, lambda_max, curve in valid:
        assert abs(curve.lambda_max - lambda_max) < 1.96 * curve.lambda_max_stddev
        assert abs(curve.mu_max - 1.17) < 1.96 * curve.mu_max_stddev


def test_a_curve_that_nothing_measures_is_refused_with_its_reason() -> None:
    found = [curve for _, _, curve in stop_in_a_curve(0.5, measured=False)]
    assert not any(curve.valid or curve.mu_max_known for curve in found)
    assert any("yaw rate or lateral acceleration is missing" in curve.text for curve in found)
