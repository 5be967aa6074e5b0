"""The car's estimator on the independent plant, and on streams that no car sends."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from math import inf, nan
from typing import Any

import numpy as np
import pytest

from corner_sim.car.car import Car
from corner_sim.car.car_parameters import CarParameters, SensorParameters
from corner_sim.car.driving import Cycling, OrdinaryDriver, PressureProfile, SlipCycle, Surroundings, peak_pressures
from corner_sim.car.random_car import random_car
from corner_sim.car.recording import Recording, record
from corner_sim.car.tyres import TYRES
from friction_curve_id.car import CarEstimator, CarEstimatorParameters, CarSample
from friction_curve_id.interface import CurveEstimate, Refusal, RestartCause
from vehicle_models import burckhardt
from vehicle_models.reason import Reason
from vehicle_models.surfaces import SURFACES
from vehicle_models.vehicle import Deviation, SharedBy
from vehicle_models.vehicle_file import load_vehicle

CAR = load_vehicle("compact_car")
ROADS = ("dry", "wet", "cobblestone", "snow")
Answers = Sequence[CurveEstimate | Refusal]
AFTER = 0.4
"""Time after the first wheel has passed its peak at which estimates are judged [s]."""


@cache
def stop(seed: int, road: str) -> Recording:
    """A stop of a random car, until a little after it is judged; every second car has Pacejka's tyres."""
    car = random_car(seed, road, ("burckhardt", "pacejka")[seed % 2])
    return record(car.parameters, SlipCycle(car.parameters, car.cycling), seed, duration=2.6)


def believed_car(family: str, road: str, sample_rate: int = 200, **changes: Any) -> CarParameters:
    """The car of the vehicle file, on tyres of a road."""
    sensors = SensorParameters(sample_rate=sample_rate, encoder_teeth=48, acceleration_delay=0.005)
    tyres = (TYRES[family][road],) * 4
    return CarParameters(
        tyres, relaxation_length=(0.3,) * 4, damper_share=0.5, pitch_gain=0.0026, sensors=sensors, **changes
    )


def passing(run: Recording) -> float:
    return float(run.time[(run.tyre_slip > run.lambda_max).any(axis=1).argmax()])


def samples(run: Recording, until: float = inf) -> list[CarSample]:
    return [
        CarSample(float(run.time[k]), run.wheel_speed[k], run.brake_pressure[k], float(run.acceleration[k]))
        for k in range(int(np.searchsorted(run.time, until)))
    ]


def follow(stream: Sequence[CarSample], estimator: CarEstimator | None = None) -> list[Answers]:
    estimator = estimator or CarEstimator(CAR)
    return [estimator.update(sample) for sample in stream]


def estimates(found: Sequence[Answers]) -> list[CurveEstimate]:
    return [answers[0] for answers in found if isinstance(answers[0], CurveEstimate)]


def test_intervals_hold_the_peaks_of_cars_that_nobody_knows() -> None:
    """Of 12 cars; with a coverage of 90 % nine or fewer are inside in 2.6 % of such sets, of each quantity."""
    inside, seen = np.zeros(2), 0
    for number in range(12):
        run = stop(70_000 + number, ROADS[number % 4])
        last = estimates(follow(samples(run, passing(run) + AFTER)))[-1]
        seen += last.valid
        inside += (
            abs(last.lambda_max - run.lambda_max[0]) < 1.96 * last.lambda_max_stddev,
            abs(last.mu_max - run.mu_max[-1, 0]) < 1.96 * last.mu_max_stddev,
        )
    assert inside.min() >= 9
    assert seen >= 9


def test_nothing_is_valid_before_the_peak_or_just_after_it() -> None:
    for number in range(4):
        run = stop(70_000 + number, ROADS[number])
        too_early = estimates(follow(samples(run, passing(run) + 0.05)))
        assert not any(each.valid for each in too_early)


def test_a_fast_rise_has_an_interval_that_holds_before_half_of_the_friction_is_used() -> None:
    """Rises of 0.18 and 0.23 s: the first answer came 0.08 s after the brakes acted, too late for both."""
    for seed in (120_003, 120_007):
        car = random_car(seed, "wet", "burckhardt")
        run = record(car.parameters, SlipCycle(car.parameters, car.cycling), seed, duration=1.0)
        half = int((run.mu[:, 0] > 0.5 * run.mu_max[-1, 0]).argmax())
        found = follow(samples(run, float(run.time[half]) + 1e-6))[-1][0]
        assert isinstance(found, CurveEstimate) and not found.valid
        assert abs(found.mu_max - run.mu_max[-1, 0]) < 1.96 * found.mu_max_stddev


def test_slips_on_the_way_to_a_wheel_that_stands_count_as_beyond_the_peak() -> None:
    """On cobblestone they are most of what is surely beyond it: this stop was not valid in time."""
    car = random_car(120_021, "cobblestone", "pacejka")
    run = record(car.parameters, SlipCycle(car.parameters, car.cycling), 120_021, duration=2.0)
    found = estimates(follow(samples(run, passing(run) + AFTER)))
    right = [
        abs(each.lambda_max - run.lambda_max[0]) < 1.96 * each.lambda_max_stddev
        and abs(each.mu_max - run.mu_max[-1, 0]) < 1.96 * each.mu_max_stddev
        for each in found
        if each.valid
    ]
    assert right
    assert all(right)


def test_a_flat_peak_that_one_formula_alone_has_below_the_slip_makes_no_alarm() -> None:
    """On Pacejka's snow, true peak 0.31: 0.20 by Burckhardt, 0.27 by Pacejka, at a slip of 0.25."""
    car = random_car(121_001, "snow", "pacejka")
    run = record(car.parameters, SlipCycle(car.parameters, car.cycling), 121_001, duration=1.5)
    found = [each for answers in follow(samples(run, passing(run) - 0.025))[-10:] for each in answers]
    assert all(isinstance(each, CurveEstimate) and each.probability_beyond_peak < 0.9 for each in found)


def test_ordinary_braking_never_shows_a_peak() -> None:
    for seed, road, share in ((70_100, "wet", 0.5), (70_101, "dry", 0.4), (70_102, "snow", 0.6)):
        car = random_car(seed, road, ("burckhardt", "pacejka")[seed % 2]).parameters
        most = share * min(peak_pressures(car))
        profile = PressureProfile((0.7, 1.0, 2.5, 2.8, 4.0, 4.1, 6.0), (0.0, most, most, 0.0, 0.0, most, most))
        run = record(car, profile, seed, duration=6.0)
        found = follow(samples(run))
        assert len(estimates(found)) > 200
        assert not any(each.valid for each in estimates(found))


def test_a_driver_who_begins_to_turn_while_he_brakes_shows_no_peak() -> None:
    # the path bends more and more: wheels left and right part as they do on a curve that has no more to give
    car = replace(random_car(40_479, "snow", "pacejka").parameters, slope=0.0)
    driver = OrdinaryDriver(car, 40_479)
    run = record(car, driver, 40_479, speed=15.0, duration=3.0, surroundings=driver.surroundings)
    found = estimates(follow(samples(run)))
    assert len(found) > 250
    assert not any(each.valid or each.probability_beyond_peak > 0.9 for each in found)
    last = found[-1]
    assert abs(last.lambda_max - run.lambda_max[0]) < 1.96 * last.lambda_max_stddev
    assert last.slip == pytest.approx(float(run.slip[-1, 0]), abs=0.01)


def test_without_accelerometer_and_with_one_wheel_the_interval_is_wider_and_holds() -> None:
    run = stop(70_000, "dry")
    stream = samples(run, passing(run) + AFTER)
    whole = estimates(follow(stream))[-1]
    one = np.array([0.0, nan, nan, nan])
    for degraded in (
        [each._replace(acceleration=nan) for each in stream],
        [each._replace(brake_pressure=each.brake_pressure + one, acceleration=nan) for each in stream],
    ):
        found = estimates(follow(degraded))[-1]
        assert found.mu_max_stddev > 1.5 * whole.mu_max_stddev
        assert abs(found.lambda_max - run.lambda_max[0]) < 1.96 * found.lambda_max_stddev
        assert abs(found.mu_max - run.mu_max[-1, 0]) < 1.96 * found.mu_max_stddev


def test_rear_wheels_that_lock_do_not_spoil_the_curve() -> None:
    """Once they have stood, mu_max was above its interval in a third of the messages."""
    car = believed_car("burckhardt", "cobblestone")
    inside = []
    for seed in range(72_000, 72_005):
        run = record(car, SlipCycle(car, Cycling()), seed, duration=4.0)
        locked = (run.slip[:, 2:] > 0.99).any(axis=1)
        assert locked.sum() > 5
        after = estimates(follow(samples(run)))[-(len(run.time) - int(locked.argmax())) :]
        inside += [abs(each.mu_max - run.mu_max[-1, 0]) < 1.96 * each.mu_max_stddev for each in after if each.valid]
    assert len(inside) > 50
    assert np.mean(inside) > 0.95


def test_pads_that_fade_leave_the_curve_valid_and_right() -> None:
    """Without an unknown of its own the fading made three quarters of these answers invalid."""
    car = believed_car("burckhardt", "dry", fading=0.2)
    valid, inside = [], []
    for seed in (73_000, 73_001):
        run = record(car, SlipCycle(car, Cycling()), seed, duration=2.4)
        found = estimates(follow(samples(run, passing(run) + 1.2)))
        late = found[-round(0.8 * car.sensors.sample_rate) :]
        valid += [each.valid for each in late]
        for each in late:
            if each.valid:
                inside.append(
                    abs(each.mu_max - run.mu_max[-1, 0]) < 1.96 * each.mu_max_stddev
                    and abs(each.lambda_max - run.lambda_max[0]) < 1.96 * each.lambda_max_stddev
                )
    assert np.mean(valid) > 0.6
    assert np.mean(inside) > 0.9


def test_wheels_that_slip_under_their_engine_before_the_brakes_act_are_not_the_speed_of_the_car() -> None:
    """By their mean the car was 0.3 m/s too slow on soft snow: none of these stops became valid."""
    car = believed_car("pacejka", "snow", engine_drag=80.0)
    for seed in (74_000, 74_001):
        run = record(car, SlipCycle(car, Cycling()), seed, duration=2.4)
        valid = [each for each in estimates(follow(samples(run, passing(run) + AFTER))) if each.valid]
        assert valid
        assert abs(valid[-1].lambda_max - run.lambda_max[0]) < 1.96 * valid[-1].lambda_max_stddev
        assert abs(valid[-1].mu_max - run.mu_max[-1, 0]) < 1.96 * valid[-1].mu_max_stddev


def test_the_slip_does_not_depend_on_which_formula_was_fitted_last() -> None:
    """They take turns: the speed of the other one was too old by a step, and the slip went up and down by 0.0015."""
    car = believed_car("burckhardt", "dry")
    half = [0.5 * each for each in peak_pressures(car)]
    run = record(car, PressureProfile((0.7, 1.0), (0.0, half[0])), 74_100, duration=1.8)
    error = np.array([each.slip for each in estimates(follow(samples(run)))[-120:]]) - run.slip[-120:, 0]
    assert error.std() < 7e-4


def test_a_pressure_that_comes_late_on_snow_leaves_the_formula_of_the_tyre_the_likelier_one() -> None:
    """A delay of 20 ms is found from the passing on, in large steps: the other formula, 25 % off, was believed."""
    car = believed_car("burckhardt", "snow")
    car = replace(car, sensors=replace(car.sensors, pressure_delay=0.02))
    for seed in (300_017, 300_019):
        run = record(car, SlipCycle(car, Cycling()), seed, duration=2.0)
        last = estimates(follow(samples(run, passing(run) + AFTER)))[-1]
        assert abs(last.lambda_max - run.lambda_max[0]) < 1.96 * last.lambda_max_stddev
        assert abs(last.lambda_max / run.lambda_max[0] - 1.0) < 0.15


def test_garbage_is_refused_by_name_and_leaves_the_fit_as_it_was() -> None:
    run = stop(70_001, "wet")
    stream = samples(run, passing(run) + 0.2)
    clean, disturbed = CarEstimator(CAR), CarEstimator(CAR)
    wheels = np.ones(4)
    for sample in stream:
        before = clean.update(sample)
        for bad, name in (
            (sample._replace(time=nan), "time"),
            (sample._replace(wheel_speed=wheels * inf), "front_left"),
            (sample._replace(brake_pressure=np.array([0.0, 0.0, inf, 0.0])), "rear_left"),
            (sample._replace(acceleration=1e9), "acceleration"),
            (sample._replace(wheel_speed=np.ones(3)), "4 wheel speeds"),
            (sample._replace(wheel_speed="fast"), "numbers"),
        ):
            refused = disturbed.update(bad)[0]
            assert isinstance(refused, Refusal) and refused.reason is Reason.BAD_INPUT and name in refused.text
        after = disturbed.update(sample)
    repeated = disturbed.update(stream[-1])[0]
    assert isinstance(repeated, Refusal) and "repeats" in repeated.text
    assert repr(before) == repr(after)


def test_a_missing_acceleration_in_a_braking_is_named() -> None:
    run = stop(70_001, "wet")
    stream = samples(run, passing(run))
    estimator = CarEstimator(CAR)
    follow(stream, estimator)
    refused = estimator.update(stream[-1]._replace(time=stream[-1].time + 0.005, acceleration=nan))[0]
    assert isinstance(refused, Refusal) and refused.reason is Reason.NO_ACCELERATION


def test_a_gap_in_a_braking_ends_the_estimate_until_the_brakes_are_released() -> None:
    run = stop(70_000, "dry")
    stream = [each for each in samples(run) if not 1.2 < each.time < 1.6]
    found = follow(stream)
    last = found[-1][0]
    assert isinstance(last, Refusal) and last.reason is Reason.NO_EXCITATION
    assert "waiting for the next braking" in last.text


def test_a_car_that_is_first_heard_with_its_brakes_on_is_followed_once_they_are_released() -> None:
    estimator, speed, said = CarEstimator(CAR), 20.0, []
    for k in range(200):
        force = 1.5 if k < 60 else 0.0
        speed -= force * 0.005
        refused = estimator.update(CarSample(0.005 * k, np.full(4, speed / 0.3), np.full(4, force * 5.6e5), -force))[0]
        assert isinstance(refused, Refusal)
        said.append(refused.text)
    assert "waiting for the next braking" in said[50]
    assert said[-1] == "waiting for a braking"


def test_memory_and_answers_stay_bounded_in_a_long_braking() -> None:
    estimator, speed = CarEstimator(CAR), 30.0
    for k in range(3000):
        time, force = 0.005 * k, 0.0 if k < 100 else 1.5
        speed -= force * 0.005
        omega = np.full(4, speed * (1.0 - 0.005 * force) / 0.3)
        found = estimator.update(CarSample(time, omega, np.full(4, force * 5.6e5), -force))
    assert isinstance(found[0], CurveEstimate)
    assert found[0].samples <= 260
    assert not found[0].valid


@pytest.mark.parametrize("rate", [50, 500])
def test_other_rates_are_counted_in_time(rate: int) -> None:
    """With a coverage of 90 % four or fewer of six are inside in 11 % of such sets; three or fewer in 1.6 %."""
    inside = np.zeros(2)
    for number in range(6):
        car = random_car(70_000 + number, ROADS[number % 4], ("burckhardt", "pacejka")[number % 2])
        parameters = replace(car.parameters, sensors=replace(car.parameters.sensors, sample_rate=rate))
        run = record(parameters, SlipCycle(parameters, car.cycling), 70_000 + number, duration=2.6)
        found = estimates(follow(samples(run, passing(run) + AFTER)))
        assert found[-1].samples <= 260
        inside += (
            abs(found[-1].lambda_max - run.lambda_max[0]) < 1.96 * found[-1].lambda_max_stddev,
            abs(found[-1].mu_max - run.mu_max[-1, 0]) < 1.96 * found[-1].mu_max_stddev,
        )
    assert inside.min() >= 4


def test_a_peak_that_slips_cross_within_a_sample_has_an_interval_that_holds() -> None:
    """On wet at 50 Hz, lambda_max was 1.7 to 2.2 deviations too high in these stops (median), and up to 4.3."""
    car = believed_car("burckhardt", "wet", sample_rate=50)
    inside = []
    for seed in (141_000, 141_006, 141_008):
        run = record(car, SlipCycle(car, Cycling()), seed, duration=2.8)
        inside += [
            abs(each.lambda_max - run.lambda_max[0]) < 1.96 * each.lambda_max_stddev
            for each in estimates(follow(samples(run)))
            if each.valid
        ]
    assert len(inside) > 20
    assert np.mean(inside) > 0.9


def test_what_leads_the_fits_astray_in_a_slow_rise_does_not_stay_in_what_is_valid() -> None:
    """First rises of 3 s on snow: mu_max was valid and 5 to 8 % too high, half of the time outside of its interval."""
    car = believed_car("burckhardt", "snow")
    for seed in (300_004, 300_010):
        run = record(car, SlipCycle(car, Cycling(ramp=3.0)), seed, duration=5.0)
        found = [each for each in estimates(follow(samples(run))) if each.valid]
        assert found
        assert all(abs(each.mu_max - run.mu_max[-1, 0]) < 1.96 * each.mu_max_stddev for each in found)


def test_snow_is_found_where_the_car_has_led_the_fits_astray() -> None:
    """Its body pitches as fast as none does. Before, the curve of dry stayed: mu_max 1.1 after 0.8 s on snow."""
    dry, snow = TYRES["burckhardt"]["dry"], TYRES["burckhardt"]["snow"]
    car = replace(believed_car("burckhardt", "dry"), pitch_frequency=8.0, pitch_damping=1.0)

    def around(time: float, moved: Car) -> Surroundings:
        moved.tyres = [snow if time > 2.5 + 0.15 * (wheel > 1) else dry for wheel in range(4)]
        return Surroundings()

    run = record(car, SlipCycle(car, Cycling()), 72_100, duration=3.3, surroundings=around)
    found = estimates(follow(samples(run)))
    anew = [each.restart_cause for each in found].index(RestartCause.SURFACE)
    assert 2.5 < run.time[len(run.time) - len(found) + anew] < 2.6
    assert found[anew - 1].mu_max > 0.8
    assert found[-1].mu_max < 0.3
    assert not any(each.valid for each in found[anew:])


def test_the_family_can_be_fixed() -> None:
    run = stop(70_000, "dry")
    estimator = CarEstimator(CAR, CarEstimatorParameters(family="burckhardt"))
    last = estimates(follow(samples(run, passing(run) + AFTER), estimator))[-1]
    assert np.isfinite(last.theta).all()
    assert abs(last.lambda_max - run.lambda_max[0]) < 1.96 * last.lambda_max_stddev


@pytest.mark.parametrize(("road", "largest"), [("dry", 3.0), ("cobblestone", 2.0)])
def test_a_corner_that_is_known_exactly_is_identified_as_well_as_its_noise_allows(
    noisy: Callable[..., Any], road: str, largest: float
) -> None:
    """The largest error of four seeds, over four deviations of the default's [%]; with 100 samples of braking."""
    corner = load_vehicle("chapter_corner")
    zero = Deviation(0.0, SharedBy.ALL)
    of_wheel = dict.fromkeys(("inertia", "brake_gain", "radius", "relaxation_length"), zero)
    wheel = replace(corner.wheels[0], relaxation_length=1e-3, deviations=of_wheel)
    exact = replace(corner, wheels=(wheel,))
    parameters = CarEstimatorParameters(
        family="burckhardt", wheel_speed_is_interval_mean=False, slope_stddev=0.0, torque_stddev=10.0**0.5
    )
    truth = float(burckhardt.peak(np.array([SURFACES[road]]))[0][0])
    for seed in range(4):
        estimator, rng = CarEstimator(exact, parameters), np.random.default_rng([seed, 3])
        for k in range(-40, 0):
            estimator.update(CarSample(0.005 * k, [100.0 + rng.normal(0.0, 0.005**0.5)], [0.0], nan))
        for sample in noisy(road, seed).samples:
            torque = max(sample.brake_torque, 0.0) / wheel.brake_gain
            found = estimator.update(CarSample(sample.time, [sample.wheel_speed], [torque], nan))[0]
        assert isinstance(found, CurveEstimate)
        assert abs(found.lambda_max / truth - 1.0) < 0.01 * largest
        assert abs(found.lambda_max - truth) < 3.0 * found.lambda_max_stddev
