"""Brake gain over mass, learned from braking to braking: drives in closed form, and cars of an independent plant."""

from dataclasses import replace
from math import inf, isfinite, nan
from typing import Any

import numpy as np
import pytest

from corner_sim.car.driving import OrdinaryDriver
from corner_sim.car.random_car import random_car
from corner_sim.car.recording import record
from friction_curve_id.car.car_sample import Checked
from friction_curve_id.car.gain_over_mass import GainOverMass, GainOverMassLearner
from vehicle_models.reason import Reason
from vehicle_models.vehicle import FRONT, Deviation, SharedBy, Vehicle
from vehicle_models.vehicle_file import load_vehicle

CAR = load_vehicle("compact_car")
NOMINAL = [CAR.wheels[k].brake_gain / CAR.mass for k in (0, 2)]
RATE = 200


class Drive:
    """Straight drive of a car without slip whose true gains over mass are known; front and rear pressures differ."""

    def __init__(self, front: float, rear: float, seed: int = 1, offset: float = 0.0) -> None:
        """`front`, `rear`: true gain over mass over that of the vehicle file; `offset` of the accelerometer [m/s^2]."""
        self.rng = np.random.default_rng(seed)
        self.factor, self.offset = np.array([front, front, rear, rear]), offset
        self.time, self.speed = 0.0, 30.0
        self.pressure, self.pitched = np.zeros(4), 0.0

    def samples(self, duration: float, front: float, rear: float, fault: float = 0.0) -> list[Checked]:
        """Drive for `duration` [s] with the pressures [Pa]; `fault`: deceleration that no brake makes [m/s^2]."""
        found, radii, goal = [], np.array(CAR.radii), np.array([front, front, rear, rear])
        gain = np.array([wheel.brake_gain for wheel in CAR.wheels]) * self.factor
        spinning = sum(wheel.inertia / wheel.radius**2 for wheel in CAR.wheels) / CAR.mass
        pitch = 9.81 * CAR.accelerometer.pitch_gain
        for _ in range(round(duration * RATE)):
            self.pressure = self.pressure + (goal - self.pressure) / (0.1 * RATE)  # a driver's foot
            resistance = CAR.rolling_resistance * 9.81 + 0.6 * CAR.drag_area / CAR.mass * self.speed**2
            force = float((gain * self.pressure / radii).sum()) / CAR.mass + resistance + fault
            acceleration = -force / (1.0 + spinning)
            self.speed += acceleration / RATE
            self.pitched += (acceleration - self.pitched) / (0.1 * RATE)
            reading = acceleration + pitch * self.pitched + self.offset + self.rng.normal(0.0, 0.05)
            wheel_speed = self.speed / radii + self.rng.normal(0.0, 0.02, 4)
            found.append(Checked(self.time, wheel_speed, self.pressure, reading, not self.time))
            self.time += 1.0 / RATE
        return found

    def braking(self, front: float = 3e6, rear: float = 3e6, fault: float = 0.0) -> list[Checked]:
        """A braking of 2 s between two rests of 1 s."""
        self.speed = 30.0
        return [*self.samples(1.0, 0.0, 0.0), *self.samples(2.0, front, rear, fault), *self.samples(1.0, 0.0, 0.0)]


def teach(learner: GainOverMassLearner, samples: list[Checked]) -> GainOverMass:
    for sample in samples:
        learner.update(sample)
    return learner.found


def taught(drive: Drive, brakings: int, vehicle: Vehicle = CAR) -> GainOverMassLearner:
    """Learner of brakings whose share of the front axle differs, as those with ABS or on slopes."""
    learner = GainOverMassLearner(vehicle)
    for k in range(brakings):
        teach(learner, drive.braking(3e6 + 1e6 * (k % 2), 3e6 - 1.5e6 * (k % 2)))
    return learner


def inside(found: GainOverMass, front: float, rear: float) -> bool:
    pairs = zip((found.front, found.rear), (found.front_stddev, found.rear_stddev), (front, rear), NOMINAL, strict=True)
    return all(abs(value - truth * nominal) < 1.96 * stddev for value, stddev, truth, nominal in pairs)


def test_nothing_is_learned_before_the_first_braking() -> None:
    found = GainOverMassLearner(CAR).found
    assert (found.front, found.rear) == pytest.approx(NOMINAL)
    assert found.reason is Reason.NOTHING_LEARNED
    assert found.front_stddev / found.front == pytest.approx(np.hypot(130.0 / 1500.0, 7.5 / 130.0), rel=0.02)


@pytest.mark.parametrize(("front", "rear"), [(1.0, 1.0), (0.94, 1.05), (1.15, 1.1)])
@pytest.mark.parametrize("offset", [-0.2, 0.2])
def test_a_drive_teaches_the_gains_within_their_interval(front: float, rear: float, offset: float) -> None:
    found = taught(Drive(front, rear, offset=offset), 8).found
    assert found.reason is Reason.OK and found.brakings == 8 and found.refused == 0
    assert inside(found, front, rear)
    assert found.front_stddev / found.front < 0.035


def test_an_error_of_the_scale_does_not_average_out() -> None:
    deviations = [taught(Drive(1.0, 1.0), brakings).found.front_stddev / NOMINAL[0] for brakings in (1, 12)]
    assert 0.012 < deviations[1] < deviations[0]


def test_a_wrong_vehicle_file_is_overcome() -> None:
    found = taught(Drive(1.3, 1.3), 8).found
    assert inside(found, 1.3, 1.3)
    assert found.front / NOMINAL[0] > 1.22


def test_a_change_of_load_is_learned_from_one_braking() -> None:
    drive = Drive(1.0, 1.0)
    learner = taught(drive, 6)
    drive.factor = drive.factor * 0.75
    found = teach(learner, drive.braking())
    assert found.restarts == 1 and found.brakings == 1
    assert inside(found, 0.75, 0.75)


def test_pads_that_fade_slowly_are_followed() -> None:
    drive, learner = Drive(1.0, 1.0), GainOverMassLearner(CAR)
    for _ in range(20):
        drive.factor = drive.factor * 0.99
        found = teach(learner, drive.braking())
    assert inside(found, float(drive.factor[0]), float(drive.factor[0]))


def test_what_was_learned_goes_back_to_the_vehicle_file_with_time() -> None:
    drive = Drive(1.2, 1.2)
    learner = taught(drive, 6)
    before = learner.found
    drive.time += 3.0 * 3600.0
    drive.speed = 30.0
    teach(learner, [sample._replace(after_gap=k == 0) for k, sample in enumerate(drive.samples(1.0, 0.0, 0.0))])
    assert learner.found == before  # until there is something else to go by
    teach(learner, drive.samples(0.1, 3e6, 3e6))
    after, file = learner.found, GainOverMassLearner(CAR).found
    assert before.front_stddev / before.front < 0.6 * after.front_stddev / after.front
    assert after.front_stddev / after.front <= file.front_stddev / file.front
    assert file.front < after.front < before.front


def test_a_braking_that_nothing_explains_is_refused_and_changes_no_value() -> None:
    drive = Drive(1.1, 1.1)
    learner = taught(drive, 6)
    before = learner.found
    found = before
    for fault in (-2.0, 2.0):
        drive.speed = 30.0
        samples = drive.samples(1.0, 0.0, 0.0)
        for k in range(8):
            samples += drive.samples(0.25, 3e6, 3e6, fault if k % 2 else -fault)
        found = teach(learner, [*samples, *drive.samples(1.0, 0.0, 0.0)])
    assert found.refused == 2 and found.brakings == before.brakings
    assert found.front == pytest.approx(before.front, rel=0.01)
    assert found.front_stddev > before.front_stddev


@pytest.mark.parametrize("missing", ["wheel_speed", "brake_pressure", "acceleration", "after_gap"])
def test_a_braking_that_is_interrupted_at_once_teaches_nothing(missing: str) -> None:
    drive = Drive(0.9, 0.9)
    learner = taught(drive, 3)
    before = learner.found
    wrong: Any = {"after_gap": True, "acceleration": nan}.get(missing, np.array([1.0, nan, 1.0, 1.0]))
    drive.speed = 30.0
    samples = [*drive.samples(1.0, 0.0, 0.0), *drive.samples(0.2, 3e6, 3e6)]
    samples += [sample._replace(**{missing: wrong}) for sample in drive.samples(2.0, 3e6, 3e6)]
    found = teach(learner, samples)
    assert found.brakings == before.brakings
    assert found.front == pytest.approx(before.front, rel=0.01)


def test_a_reset_forgets_what_was_learned() -> None:
    learner = taught(Drive(1.2, 1.2), 3)
    learner.reset()
    assert learner.found == GainOverMassLearner(CAR).found


def test_what_is_known_exactly_stays() -> None:
    exact = Deviation(0.0, SharedBy.ALL)
    known = dict.fromkeys(("brake_gain", "radius", "inertia"), exact)
    wheels = tuple(replace(wheel, deviations=known) for wheel in CAR.wheels)
    vehicle = replace(CAR, wheels=wheels, deviations={**CAR.deviations, "mass": exact})
    found = taught(Drive(1.0, 1.0), 2, vehicle).found
    assert found.front == pytest.approx(NOMINAL[0])
    assert found.front_stddev == 0.0


def test_a_car_with_one_axle_has_no_rear_gain() -> None:
    wheels = tuple(wheel for wheel in CAR.wheels if wheel.axle == FRONT)
    found = GainOverMassLearner(replace(CAR, wheels=wheels, front_load_share=1.0)).found
    assert isfinite(found.front) and not isfinite(found.rear)


@pytest.mark.parametrize(("seed", "road"), [(72_001, "dry"), (72_002, "wet")])
def test_ordinary_driving_of_a_car_of_another_plant_teaches_its_gain(seed: int, road: str) -> None:
    car = replace(random_car(seed, road, "burckhardt").parameters, slope=0.0)
    driver = OrdinaryDriver(car, seed)
    run = record(car, driver, seed, speed=15.0, duration=60.0, surroundings=driver.surroundings)
    learner = GainOverMassLearner(CAR)
    last = -inf
    for k, time in enumerate(run.time.tolist()):
        learner.update(
            Checked(time, run.wheel_speed[k], np.maximum(run.brake_pressure[k], 0.0), run.acceleration[k], last < 0.0)
        )
        last = time
    truths = [car.brake_gain[k] / car.mass * CAR.wheels[k].radius / car.radius[k] for k in (0, 2)]
    found = learner.found
    assert found.brakings >= 2
    assert abs(found.front - truths[0]) < 1.96 * found.front_stddev
    assert abs(found.rear - truths[1]) < 1.96 * found.rear_stddev
    assert found.front_stddev / found.front < 0.6 * np.hypot(130.0 / 1500.0, 7.5 / 130.0)
