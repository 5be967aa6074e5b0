"""Tyres that roll on less under more load: in a curve neither speed nor slips take that for worn tyres."""

from dataclasses import replace

import numpy as np

from corner_sim.car.car import STEP, Car
from corner_sim.car.car_parameters import CarParameters
from vehicle_models.vehicle import Deviation, SharedBy, Vehicle
from vehicle_models.vehicle_file import load_vehicle
from wheel_slip.estimator import SlipEstimator

LOSS = 0.023


def told(loss: float, stddev: float) -> Vehicle:
    nominal = load_vehicle("compact_car")
    of_tyre = {"radius_loss": Deviation(stddev, SharedBy.ALL)}
    wheels = tuple(replace(w, radius_loss=loss, deviations={**w.deviations, **of_tyre}) for w in nominal.wheels)
    return replace(nominal, wheels=wheels)


def curve(vehicle: Vehicle) -> tuple[float, float, float]:
    """RMS errors of speed [m/s] and slips, and the coverage of their intervals, through 9 s of 0.5 to 0.9 g."""
    car, estimator = Car(CarParameters(radius_loss=LOSS), 25.0, 1), SlipEstimator(vehicle)
    random = np.random.default_rng(1)
    of_speed, of_slip, inside = [], [], []
    for k in range(14_000):
        share = min(max((k * STEP - 3.0) / 2.0, 0.0), 1.0) * min(max((14.0 - k * STEP) / 2.0, 0.0), 1.0)
        car.step([0.0] * 4, 170.0, curvature=0.008 * share)
        if k % 5 != 4:
            continue
        wheels = np.array(car.wheel_speed) + random.normal(0.0, 0.03, 4)
        reading, yaw_rate = car.acceleration + random.normal(0.0, 0.05), car.yaw_rate + random.normal(0.0, 0.005)
        found = estimator.update((k + 1) * 1_000_000, wheels.tolist(), reading, yaw_rate=yaw_rate)
        if k * STEP > 1.0:
            of_speed.append(estimator.car.speed - car.speed)
            errors = [each.slip - slip for each, slip in zip(found, car.slip, strict=True)]
            of_slip += errors
            inside += [abs(e) < 1.96 * each.slip_variance**0.5 for e, each in zip(errors, found, strict=True)]
    return float(np.mean(np.square(of_speed)) ** 0.5), float(np.mean(np.square(of_slip)) ** 0.5), float(np.mean(inside))


def test_the_load_of_a_curve_is_no_wear() -> None:
    speed, slip, inside = curve(told(LOSS, 0.007))
    assert speed < 0.03 and slip < 0.002 and inside > 0.95
    speed_untold, slip_untold, _ = curve(told(0.0, 0.0))
    assert speed_untold > 3.0 * speed and slip_untold > 2.0 * slip
