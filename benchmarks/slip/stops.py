"""Stops of a car on two axles from 30 m/s with the supervisor in the loop, and the signals of its sensors.

The car cruises first (the engine holds the speed on the slope), then the driver demands 1.5 times the peak torque,
split between the wheels in proportion to their gains. Every wheel has its own detector of votes and
supervisor, with the shipped parameters. Its states command the brake without the envelope: the stops are manoeuvres
with strong slip for the estimators, and say nothing about the supervisor. Sensor noise is drawn per run from its seed.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite
from statistics import fmean

import numpy as np
from numpy.typing import NDArray

from abs_supervisor.fsm import COMMANDS
from abs_supervisor.supervisor import Evidence, Supervisor
from benchmarks.closed_loop.controller import shipped
from benchmarks.closed_loop.panic_plant import DEMAND_RATIO
from benchmarks.protocol import ACCELERATION_STDDEV, DT, SPEED, STEP
from friction_slope.detector import SlopeDetector
from friction_slope.estimate import Method, SlopeSample
from vehicle_models import burckhardt
from vehicle_models.brake_actuator import ActuatorParameters, BrakeActuator
from vehicle_models.constants import GRAVITY
from vehicle_models.sensor_noise import CHAPTER_NOISE
from vehicle_models.straight_forces import drag
from vehicle_models.surfaces import surface
from vehicle_models.two_axle import TwoAxleCar, four_wheels, peak_torque, split_torque
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle

Array = NDArray[np.float64]

CAR = load_vehicle("compact_car")
CRUISE = 10.0
"""Time before the brake onset [s]."""
END_SPEED = 3.0
"""[m/s]"""
ACCELERATION_OFFSET = 0.15
"""[m/s^2]"""
GRADE = 0.02
"""Road slope [-], uphill for even seeds and downhill for odd ones."""
_WARM_UP = 40
"""Samples the detectors see before the brake onset."""
_LONGEST = 12_000
"""Samples after which a stop is given up: one minute."""


@dataclass
class Stop:
    """One run: sensors and truth at every sample, n of them, until the end speed."""

    onset: int
    """Index of the first sample with brake demand."""
    wheel_speed: Array
    """Measured [rad/s], shape (n, 4)."""
    acceleration: Array
    """Measured [m/s^2], shape (n,)."""
    torque: Array
    """Brake torque [N m], true, shape (n, 4)."""
    speed: Array
    """True [m/s], shape (n,)."""
    slip: Array
    """True [-], shape (n, 4)."""


def stops(
    name: str,
    seeds: range,
    *,
    grade_step: float = 0.0,
    vehicle: Vehicle = CAR,
    progress: Callable[[int], None] = lambda _done: None,
) -> list[Stop]:
    """Brake once for each seed, side by side.

    Args:
        name: of the road.
        seeds: of the noise.
        grade_step: change of road slope half a braking time (by peak friction) after the onset.
        vehicle: the car, of four wheels; arrays per wheel are in the order of `four_wheels`. Its accelerometer is as
            late as it says, in whole samples.
        progress: called with the number of runs that have just ended.

    Raises:
        ValueError: the car has not four wheels, or none is driven.
    """
    count, theta = len(seeds), surface(name)
    grade = np.where(np.array(seeds) % 2 == 0, GRADE, -GRADE)
    wheels = four_wheels(vehicle)
    car = TwoAxleCar(vehicle, np.full(count, SPEED), grade=np.arctan(grade))
    demand = DEMAND_RATIO * split_torque(vehicle, np.asarray(peak_torque(vehicle, theta).sum()))
    actuators = [BrakeActuator(count, DT, ActuatorParameters()) for _ in wheels]
    controllers = _controllers(count, vehicle)
    generators = [np.random.default_rng(seed) for seed in seeds]
    onset = round(CRUISE / DT)
    step_at = onset + round(0.5 * SPEED / (GRAVITY * float(burckhardt.peak(theta)[1])) / DT)
    cruise = cruise_torque(vehicle, grade)
    torque: Array = np.zeros((count, len(wheels)))
    kept: list[list[Array]] = [[] for _ in range(5)]
    ends = np.full(count, -1)
    for k in range(_LONGEST):
        if k == step_at:
            car.grade = np.arctan(grade + grade_step)
        draws = np.stack([generator.standard_normal(9) for generator in generators])
        measured = car.wheel_speed + np.sqrt(CHAPTER_NOISE.wheel_speed_variance) * draws[:, :4]
        acceleration = car.specific_force(theta) + ACCELERATION_OFFSET + ACCELERATION_STDDEV * draws[:, 4]
        for store, values in zip(kept, (measured, acceleration, torque, car.speed, car.slip), strict=True):
            store.append(values.copy())
        ended = (ends < 0) & (car.speed <= END_SPEED)
        ends[ended] = k
        progress(int(ended.sum()))
        if np.all(ends >= 0):
            break
        commands = np.zeros((count, len(wheels)), dtype=np.int64)
        if k >= onset - _WARM_UP:
            felt = torque + np.sqrt(CHAPTER_NOISE.torque_variance) * draws[:, 5:]
            for i in np.flatnonzero(ends < 0).tolist():
                for j, controller in enumerate(controllers[i]):
                    commands[i, j] = controller.command((k + 1) * STEP, measured[i, j], felt[i, j], k >= onset)
        demanded = demand if k >= onset else np.zeros(len(wheels))
        after = np.stack([actuators[j].step(demanded[j], commands[:, j]) for j in range(len(wheels))], axis=1)
        car.step(torque, after, theta, DT, cruise if k < onset else 0.0)
        torque = after
    late = round(vehicle.accelerometer.delay / DT)
    kept[1] = [kept[1][0]] * late + kept[1][: len(kept[1]) - late]
    arrays = [np.stack(store) for store in kept]
    return [Stop(onset, *(array[: end if end >= 0 else None, i] for array in arrays)) for i, end in enumerate(ends)]


class _Controller:
    """The shipped algorithms of vote and abs_supervisor of one wheel."""

    def __init__(self, detector: SlopeDetector, supervisor: Supervisor) -> None:
        self._detector = detector
        self._supervisor = supervisor

    def command(self, stamp: int, wheel_speed: float, torque: float, braking: bool) -> int:
        """Pass one sample through; return the command for it."""
        estimate = self._detector.update(SlopeSample(stamp, float(wheel_speed), float(torque)))
        evidence = Evidence(estimate.h, estimate.indicator, isfinite(estimate.indicator), False, braking)
        self._supervisor.update(stamp, evidence)
        return int(COMMANDS[self._supervisor.state])


def _controllers(count: int, vehicle: Vehicle) -> list[list[_Controller]]:
    slope, supervisor = shipped()
    voting = slope.vote.detector(slope.detector)
    return [
        [
            _Controller(
                SlopeDetector(vehicle.corner(wheel.name), Method.NO_SLIP, voting, slope.vote.no_slip),
                Supervisor(supervisor.thresholds, supervisor.tolerance),
            )
            for wheel in four_wheels(vehicle)
        ]
        for _ in range(count)
    ]


def cruise_torque(vehicle: Vehicle, grade: Array) -> Array:
    """Drive torque [N m] that holds SPEED on the slope.

    Raises:
        ValueError: no wheel is driven.
    """
    driven = [wheel.radius for wheel in vehicle.wheels if wheel.driven]
    if not driven:
        raise ValueError(f"no wheel of '{vehicle.name}' is driven ('driven'): it cannot cruise")
    weight = vehicle.mass * GRAVITY
    resistance = drag(vehicle, SPEED) + weight * (np.sin(np.arctan(grade)) + vehicle.rolling_resistance)
    return np.asarray(fmean(driven) * resistance)
