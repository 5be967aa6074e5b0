"""The sign by the position of the slip: against stops of another plant, and where it has to be silent."""

from collections.abc import Iterator
from dataclasses import replace
from math import nan
from typing import Any

import numpy as np
import pytest
from friction_msgs.msg import FrictionSlope, WheelSlip
from numpy.typing import NDArray
from sensor_msgs.msg import FluidPressure, Imu, JointState
from std_msgs.msg import Header

from corner_sim.car.car_parameters import WHEELS, CarParameters
from corner_sim.car.cornering_car import CorneringCar
from corner_sim.car.driving import Cycling, SlipCycle
from corner_sim.car.recording import Recording, record
from corner_sim.car.tyres import BRUSH_TYRES, TYRES, Tyre
from friction_runtime.messages import from_nanoseconds, validity
from friction_runtime.processor import Level
from friction_slope.parameters import FrictionSlopeParameters
from friction_slope.ros.car_processor import CarProcessor
from friction_slope.slip_position.detector import CarDetector
from friction_slope.slip_position.estimator import CarSample
from vehicle_models.reason import Reason
from vehicle_models.vehicle_file import load_vehicle

Array = NDArray[np.float64]
VEHICLE = load_vehicle("compact_car")
P = FrictionSlopeParameters()
CYCLING = Cycling(upper=1.5, lower=0.5)
GAIN = np.array([wheel.brake_gain for wheel in VEHICLE.wheels])


def stop(tyre: Tyre, seed: int, *, relaxation: float = 0.3) -> Recording:
    car = CarParameters(tyres=(tyre,) * 4, relaxation_length=(relaxation,) * 4, load_variation=0.03)
    return record(car, SlipCycle(car, CYCLING), seed, duration=2.2)


def samples(run: Recording, slip_stddev: float = 0.002) -> Iterator[CarSample]:
    """What is measured of a stop; slip and speed are known, as wheel_slip is tested on its own."""
    for k in range(1, len(run.time)):
        yield CarSample(
            stamp=round(run.time[k] * 1e9),
            wheel_speed=run.wheel_speed[k],
            torque=GAIN * run.brake_pressure[k],
            slip=run.slip[k],
            slip_stddev=np.full(4, slip_stddev),
            ground_speed=np.full(4, run.speed[k]),
            forward=float(run.acceleration[k]),
        )


def signs(run: Recording, **changes: Any) -> tuple[Array, NDArray[np.bool_]]:
    """Valid signs of a stop, 0 where none, and which wheels are truly beyond the peak; from 0.1 s of braking on."""
    detector = CarDetector(VEHICLE, P.detector)
    found = []
    for sample in samples(run):
        estimates = detector.update(replace(sample, **changes))
        found.append([each.sign if each.reason is Reason.OK else 0 for each in estimates])
    late = run.time[1:] > CYCLING.start + 0.1
    return np.array(found)[late], (run.tyre_slip > run.lambda_max)[1:][late]


@pytest.mark.parametrize("road", ["dry", "wet", "cobblestone", "snow"])
@pytest.mark.parametrize("family", ["burckhardt", "pacejka", "brush"])
def test_most_samples_of_a_stop_have_a_sign_and_nearly_all_signs_are_right(family: str, road: str) -> None:
    found, beyond = signs(stop((BRUSH_TYRES if family == "brush" else TYRES[family])[road], 3))
    assert np.mean(beyond[found < 0]) > 0.95
    assert np.mean(~beyond[found > 0]) > 0.97
    assert np.mean(found[beyond] < 0) > 0.35
    assert np.mean(found[~beyond] > 0) > 0.7


def test_gentle_braking_is_stable_and_never_beyond_the_peak() -> None:
    run = stop(TYRES["burckhardt"]["dry"], 5)
    gentle = run.time < CYCLING.start + 0.5 * CYCLING.ramp
    found, _ = signs(replace(run, **{name: getattr(run, name)[gentle] for name in vars(run) if _over_time(run, name)}))
    assert not (found < 0).any()


def _over_time(run: Recording, name: str) -> bool:
    value = getattr(run, name)
    return isinstance(value, np.ndarray) and len(value) == len(run.time)


def test_a_locked_wheel_is_beyond_the_peak_of_any_road() -> None:
    detector = CarDetector(VEHICLE, P.detector)
    for k in range(1, 200):
        locked = np.array([1.0, 0.0, 0.0, 0.0])
        found = detector.update(
            CarSample(
                stamp=k * 5_000_000,
                wheel_speed=(1.0 - locked) * 20.0 / 0.3,
                torque=np.array([3000.0, 0.0, 0.0, 0.0]),
                slip=locked,
                slip_stddev=np.full(4, 0.002),
                ground_speed=np.full(4, 20.0),
            )
        )
    assert (found[0].sign, found[0].reason) == (-1, Reason.OK)
    assert [each.reason for each in found[1:]] == [Reason.NOT_BRAKING] * 3


def test_friction_that_no_curve_explains_gives_no_sign() -> None:
    run = stop(TYRES["burckhardt"]["dry"], 6)
    rng = np.random.default_rng(1)
    shaken = 1.0 + 0.5 * np.repeat(rng.normal(size=(len(run.time) // 10 + 1, 4)), 10, axis=0)[: len(run.time)]
    found, _ = signs(replace(run, brake_pressure=run.brake_pressure * shaken))
    assert (found[200:] != 0).mean() < 0.1


def test_slip_that_is_not_known_gives_no_sign_and_one_that_comes_back_does() -> None:
    run = stop(TYRES["burckhardt"]["dry"], 7)
    detector = CarDetector(VEHICLE, P.detector)
    reasons = []
    for k, sample in enumerate(samples(run)):
        lost = 200 <= k < 220
        reasons.append(detector.update(replace(sample, slip=sample.slip * nan) if lost else sample)[0])
    assert {each.reason for each in reasons[200:220]} == {Reason.NO_SLIP}
    assert all(each.sign == 0 and np.isnan(each.probability) for each in reasons[200:220])
    assert any(each.reason is Reason.OK for each in reasons[220:240])


def test_crossings_are_counted_at_slips_near_that_of_the_peak() -> None:
    run = stop(TYRES["burckhardt"]["wet"], 8)
    detector = CarDetector(VEHICLE, P.detector)
    for sample in samples(run):
        last = detector.update(sample)
    for each, lambda_max in zip(last, run.lambda_max, strict=True):
        assert each.crossings >= 4
        assert each.slip_at_crossing == pytest.approx(lambda_max, rel=0.5)


def fed(run: Recording) -> Iterator[tuple[str, Any]]:
    """Messages of a stop."""
    for k in range(1, len(run.time)):
        stamp = round(run.time[k] * 1e9)
        header = Header(stamp=from_nanoseconds(stamp))
        motion = Imu(header=header)
        motion.linear_acceleration.x = float(run.acceleration[k])
        motion.angular_velocity_covariance[0] = -1.0
        yield "imu/data", motion
        for i, wheel in enumerate(WHEELS):
            pressure = float(run.brake_pressure[k, i])
            yield f"{wheel}/brake_pressure", FluidPressure(header=header, fluid_pressure=pressure)
            slip = WheelSlip(header=header, wheel=wheel, slip=float(run.slip[k, i]), slip_stddev=0.002)
            slip.vehicle_speed = float(run.speed[k])
            slip.validity = validity(wheel, Reason.OK, "")
            yield f"{wheel}/slip", slip
        yield "wheel_states", JointState(header=header, name=list(WHEELS), velocity=run.wheel_speed[k].tolist())


def test_processor_publishes_probability_and_sign_of_every_wheel_at_every_stamp() -> None:
    processor = CarProcessor(VEHICLE, P)
    run = stop(TYRES["burckhardt"]["dry"], 9)
    answers: dict[str, list[FrictionSlope]] = {wheel: [] for wheel in WHEELS}
    for topic, message in fed(run):
        for _, answer in processor.process(topic, message):
            answers[answer.wheel].append(answer)
    for of_wheel in answers.values():
        assert len(of_wheel) >= len(run.time) - 10
        valid = [each for each in of_wheel if each.validity.valid]
        assert {each.sign for each in valid} == {-1, 1}
        for each in of_wheel:
            assert each.method == "slip_position"
            certain = max(each.probability_beyond_peak, 1.0 - each.probability_beyond_peak) >= 0.95
            assert each.validity.valid == (each.sign != 0) == bool(certain)
    assert processor.health().level is Level.OK


def test_missing_pressure_of_one_wheel_leaves_the_others_their_signs() -> None:
    processor = CarProcessor(VEHICLE, P)
    last: dict[str, FrictionSlope] = {}
    told: set[str] = set()
    for topic, message in fed(stop(TYRES["burckhardt"]["dry"], 10)):
        if topic == "front_left/brake_pressure":
            continue
        for _, answer in processor.process(topic, message):
            last[answer.wheel] = answer
            told |= {answer.wheel} if answer.validity.valid else set()
    assert last["front_left"].validity.reason == Reason.NO_PRESSURE
    assert "front_left/brake_pressure" in last["front_left"].validity.text
    assert told == {"front_right", "rear_left", "rear_right"}
    assert processor.health().level is Level.ERROR


def corner(lateral: float, measured: bool, tyres: tuple[Tyre, Tyre]) -> tuple[Array, NDArray[np.bool_]]:
    """Signs and truth of a stop from 20 m/s in a curve of `lateral` [m/s^2], on tyres of the left and right wheels.

    Lateral acceleration and yaw rate are `measured`, or not.
    """
    car = CarParameters(tyres=tyres * 2, relaxation_length=(0.3,) * 4)
    moving = CorneringCar(car, 20.0, 1)
    pedal, detector = SlipCycle(car, CYCLING), CarDetector(VEHICLE, P.detector)
    peaks = np.array([tyre.peak[0] for tyre in car.tyres])
    pressure = np.zeros(4)
    found, beyond = [], []
    for step in range(2600):
        if step % 5 == 0:
            slip, omega = np.array(moving.slip), np.array(moving.wheel_speed)
            sample = CarSample(
                stamp=(step + 1) * 1_000_000,
                wheel_speed=omega,
                torque=GAIN * pressure,
                slip=slip,
                slip_stddev=np.full(4, 0.002),
                ground_speed=np.maximum(np.array(car.radius) * omega / np.maximum(1.0 - slip, 0.01), 1.0),
                forward=moving.acceleration,
                leftward=moving.lateral_acceleration if measured else nan,
                yaw_rate=moving.yaw_rate if measured else nan,
            )
            estimates = detector.update(sample)
            if step > 800:
                found.append([each.sign if each.reason is Reason.OK else 0 for each in estimates])
                beyond.append(np.abs(moving.tyre_slip) > peaks)
        pressure = np.array(pedal.pressure(0.001 * step, 0.001, moving))
        moving.step((GAIN * pressure).tolist(), curvature=lateral * min(step / 500.0, 1.0) / 400.0)
    return np.array(found), np.array(beyond)


SNOW, DRY = TYRES["burckhardt"]["snow"], TYRES["burckhardt"]["dry"]


@pytest.mark.parametrize(
    ("lateral", "measured", "tyres", "told"),
    [
        (1.2, True, (SNOW, SNOW), 0.5),
        (1.2, False, (SNOW, SNOW), 0.0),
        (5.0, True, (DRY, DRY), 0.5),
        (5.0, False, (DRY, DRY), 0.2),
        (0.0, True, (DRY, SNOW), 0.1),  # until the car spins
    ],
)
def test_in_curves_and_on_a_split_road_signs_are_right_or_there_are_none(
    lateral: float, measured: bool, tyres: tuple[Tyre, Tyre], told: float
) -> None:
    found, beyond = corner(lateral, measured, tyres)
    assert np.mean(~beyond[found > 0]) > 0.95
    assert not (found < 0).any() or np.mean(beyond[found < 0]) > 0.95
    assert (found != 0).mean() >= told
