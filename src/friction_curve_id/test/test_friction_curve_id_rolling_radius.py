"""Tyres that roll on less under more load: the peak is right with their loss in the vehicle file."""

from dataclasses import replace

import pytest

from corner_sim.car.car_parameters import CarParameters, SensorParameters
from corner_sim.car.driving import Cycling, SlipCycle
from corner_sim.car.recording import record
from friction_curve_id.car import CarEstimator, CarSample
from friction_curve_id.interface import CurveEstimate
from vehicle_models.vehicle_file import load_vehicle

LOSS = 0.023
CAR = CarParameters(
    relaxation_length=(0.3,) * 4,
    damper_share=0.5,
    pitch_gain=0.0026,
    radius_loss=LOSS,
    sensors=SensorParameters(encoder_teeth=48, acceleration_delay=0.005),
)


def lambda_errors(loss: float, seed: int) -> list[float]:
    """Relative errors of the valid lambda_max of a stop on dry, where the file says `loss`."""
    nominal = load_vehicle("compact_car")
    told = replace(nominal, wheels=tuple(replace(each, radius_loss=loss) for each in nominal.wheels))
    run, estimator, errors = record(CAR, SlipCycle(CAR, Cycling()), seed, duration=2.2), CarEstimator(told), []
    for k, time in enumerate(run.time.tolist()):
        sample = CarSample(time, run.wheel_speed[k], run.brake_pressure[k], float(run.acceleration[k]))
        answer = estimator.update(sample)[0]
        if isinstance(answer, CurveEstimate) and answer.valid:
            errors.append(abs(answer.lambda_max / float(run.lambda_max[0]) - 1.0))
    return errors


@pytest.mark.parametrize("seed", [1, 4])
def test_a_loss_that_the_file_states_costs_no_accuracy(seed: int) -> None:
    told, untold = lambda_errors(LOSS, seed), lambda_errors(0.0, seed)
    assert len(told) > 50
    assert max(told) < 0.05
    assert sum(told) / len(told) < 0.5 * sum(untold) / len(untold)
