"""The sprung car: load transfer with its overshoot, relaxation of the tyres, balance of momentum."""

from dataclasses import replace

import numpy as np
import pytest

from friction_bags.experiments.stops import SprungCar
from vehicle_models import burckhardt
from vehicle_models.constants import GRAVITY
from vehicle_models.surfaces import SURFACES, surface
from vehicle_models.vehicle_file import load_vehicle
from vehicle_models.wheel_forces import WheelLoad

CAR = replace(load_vehicle("compact_car"), drag_area=0.0)
DRY = np.tile(SURFACES["dry"], (4, 1))


def test_the_load_settles_at_the_quasi_static_transfer_and_overshoots_on_the_way() -> None:
    car = SprungCar(CAR, 60.0)
    torque = np.full(4, 300.0)
    loads = []
    for _ in range(500):
        car.step(torque, torque, DRY, 0.005)
        loads.append(car.vertical_load(DRY))
    settled = np.asarray(loads[-1])
    weight = CAR.mass * GRAVITY
    assert settled.sum() == pytest.approx(weight)
    transfer = -CAR.mass * car.acceleration(DRY) * CAR.height_ratio
    assert settled[0] + settled[1] - 0.5 * weight == pytest.approx(transfer, rel=0.02)
    # a second-order system of damping z overshoots a step by exp(-pi z / sqrt(1 - z^2)) = 37 %
    highest = max(load[0] for load in loads) - 0.25 * weight
    assert 1.25 < highest / (settled[0] - 0.25 * weight) < 1.38


def test_the_contact_builds_up_its_slip_over_the_relaxation_length() -> None:
    ice = DRY * np.array([1e-9, 1.0, 1e-9])
    car = SprungCar(replace(CAR, wheels=tuple(replace(wheel, inertia=1e9) for wheel in CAR.wheels)), 20.0)
    car._state[1:5] *= 0.99
    time = CAR.wheels[0].relaxation_length / 20.0
    for _ in range(3):
        car.step(np.zeros(4), np.zeros(4), ice, time / 3.0)
    built_up = car._state[5:9]
    assert built_up == pytest.approx(np.full(4, 0.01 * (1.0 - np.exp(-1.0))), rel=1e-4)
    assert car.friction(DRY) == pytest.approx(burckhardt.friction(DRY, built_up))


def test_what_the_tyres_take_the_car_loses() -> None:
    car = SprungCar(CAR, 30.0)
    torque = np.array([500.0, 500.0, 200.0, 200.0])
    impulse = 0.0
    for _ in range(200):
        before = float(np.sum(car.vertical_load(DRY) * car.friction(DRY)))
        car.step(torque, torque, DRY, 0.001)
        impulse += 0.0005 * (before + float(np.sum(car.vertical_load(DRY) * car.friction(DRY))))
    assert CAR.mass * (30.0 - car.speed) == pytest.approx(impulse, rel=1e-3)


def test_load_and_rate_follow_those_of_a_car_on_springs() -> None:
    theta = np.tile(surface("high_grip"), (4, 1))
    car = replace(load_vehicle("chapter_car"), drag_area=0.0, pitch_frequency=1.3, pitch_damping=0.4)
    plant, load = SprungCar(car, 25.0), WheelLoad(car, "front_left")
    previous = 0.0
    for k in range(200):
        load.update((k + 1) * 5_000_000, plant.acceleration(theta))
        truth = float(plant.vertical_load(theta)[0])
        assert load.load == pytest.approx(truth, abs=2.0)
        if k:
            assert load.rate == pytest.approx((truth - previous) / 0.005, abs=60.0)
        previous = truth
        torque = np.full(4, min(k * 5.0, 700.0))
        plant.step(torque, torque, theta, 0.005)
