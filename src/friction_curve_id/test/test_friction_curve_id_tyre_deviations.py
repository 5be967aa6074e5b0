"""The tolerance of a single tyre is in the interval of its wheel."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
import pytest

from corner_sim.car.car_parameters import CarParameters
from corner_sim.car.driving import SlipCycle
from corner_sim.car.random_car import random_car
from corner_sim.car.recording import Recording, record
from corner_sim.car.tyres import BRUSH_TYRES, Scaled
from friction_curve_id.car import CarEstimator, CarEstimatorParameters, CarSample
from friction_curve_id.interface import CurveEstimate, Refusal
from vehicle_models.vehicle_file import load_vehicle


def follow(run: Recording, family: str = "any") -> Iterator[Sequence[CurveEstimate | Refusal]]:
    estimator = CarEstimator(load_vehicle("compact_car"), CarEstimatorParameters(family=family))
    for k, time in enumerate(run.time.tolist()):
        yield estimator.update(CarSample(time, run.wheel_speed[k], run.brake_pressure[k], float(run.acceleration[k])))


def with_brushes(car: CarParameters) -> CarParameters:
    return replace(car, tyres=(BRUSH_TYRES["dry"],) * 4)


def with_load_sensitivity(car: CarParameters) -> CarParameters:
    return replace(car, load_sensitivity=0.1)


def with_other_rear_tyres(car: CarParameters) -> CarParameters:
    front, rear = car.tyres[0], Scaled(car.tyres[2], 1.08, 1.1)
    return replace(car, tyres=(front, front, rear, rear))


@pytest.mark.parametrize("changed", [with_brushes, with_load_sensitivity, with_other_rear_tyres])
def test_intervals_of_all_wheels_hold_on_tyres_that_the_fit_knows_nothing_of(
    changed: Callable[[CarParameters], CarParameters],
) -> None:
    """Without deviations of the tyres themselves these intervals cover half to four fifths of the messages."""
    inside: list[tuple[bool, bool]] = []
    for seed in (500_000, 500_001, 500_005):
        car = random_car(seed, "dry", ("burckhardt", "pacejka")[seed % 2])
        parameters = changed(car.parameters)
        run = record(parameters, SlipCycle(parameters, car.cycling), seed, duration=2.6)
        for k, answers in enumerate(follow(run)):
            for wheel, each in enumerate(answers):
                if isinstance(each, CurveEstimate) and each.valid:
                    lambda_error = abs(each.lambda_max - run.lambda_max[wheel])
                    mu_error = abs(each.mu_max - run.mu_max[k, wheel])
                    inside.append((lambda_error < 1.96 * each.lambda_max_stddev, mu_error < 1.96 * each.mu_max_stddev))
    assert len(inside) > 100
    assert np.mean(inside, axis=0).min() > 0.9


def test_load_that_moves_widens_the_interval_and_a_stated_formula_leaves_tyres_no_doubt() -> None:
    car = random_car(71_004, "dry", "burckhardt")
    parameters = replace(car.parameters, load_variation=0.0)
    run = record(parameters, SlipCycle(parameters, car.cycling), 71_004, duration=2.2)

    def last(family: str) -> list[CurveEstimate]:
        *_, answers = follow(run, family)
        return [each for each in answers if isinstance(each, CurveEstimate)]

    relative = {family: [each.mu_max_stddev / each.mu_max for each in last(family)] for family in ("any", "burckhardt")}
    moved = np.abs(run.vertical_load[-1] / run.vertical_load[0] - 1.0)
    assert moved.min() > 0.2
    assert (np.array(relative["any"]) > np.hypot(0.03, 0.08 * moved)).all()
    assert max(relative["burckhardt"]) < 0.03
