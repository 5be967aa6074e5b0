"""The sprung car: load transfer with its overshoot, relaxation of the tyres, balance of momentum."""

from dataclasses import replace

import numpy as np
import pytest

from vehicle_models import burckhardt
from vehicle_models.constants import GRAVITY
from vehicle_models.sprung_car import SprungCar
from vehicle_models.surfaces import SURFACES
from vehicle_models.vehicle_file import load_vehicle

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
