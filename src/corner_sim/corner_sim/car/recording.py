"""Recording of a run: sensor signals and truth as arrays."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from corner_sim.car.car import STEP, Car
from corner_sim.car.car_parameters import CarParameters
from corner_sim.car.driving import Surroundings
from corner_sim.car.measured_car import MeasuredCar

Array = NDArray[np.float64]
END_SPEED = 3.0
"""A recording ends at this speed [m/s]: slip is ill-defined below."""
SPUN = 0.35
"""Lateral over forward speed at which a car has spun, and a recording ends [-]."""


class Prescription(Protocol):
    """Pressures of the brake lines over time."""

    def pressure(self, time: float, dt: float, car: Car) -> list[float]:
        """Pressures [Pa] of the step of dt [s] from `time` [s], shape (4,)."""


_NOTHING = Surroundings()


@dataclass(frozen=True)
class Recording:
    """A run of N samples; arrays per wheel are in the order of WHEELS."""

    time: Array
    """Stamps [s], (N,)."""
    wheel_speed: Array
    """As measured [rad/s], (N, 4)."""
    brake_pressure: Array
    """As measured [Pa], (N, 4)."""
    acceleration: Array
    """As measured [m/s^2], forward positive, (N,)."""
    speed: Array
    """Truth [m/s], (N,)."""
    slip: Array
    """True kinematic slip, braking positive, (N, 4)."""
    tyre_slip: Array
    """True slip of the tyre, which follows `slip` over the relaxation length and decides the friction, (N, 4)."""
    mu: Array
    """True Fx / Fz, braking positive, (N, 4)."""
    vertical_load: Array
    """Truth [N], (N, 4)."""
    true_acceleration: Array
    """Of the body [m/s^2], (N,)."""
    yaw_rate: Array
    """Truth [rad/s], counter-clockwise positive, (N,)."""
    lambda_max: Array
    """Peak slip of each tyre on its road, (4,)."""
    mu_max: Array
    """Peak friction of each tyre on its road, at its load without the road's unevenness, (N, 4)."""
    parameters: CarParameters


def record(
    parameters: CarParameters,
    prescription: Prescription,
    seed: int,
    *,
    speed: float = 25.0,
    duration: float = 30.0,
    surroundings: Callable[[float, Car], Surroundings] | None = None,
    car: Car | None = None,
) -> Recording:
    """Drive a car and record it, from rolling freely to END_SPEED, until it has spun, or for `duration`.

    Args:
        parameters: the car as it is.
        prescription: pressures of the brake lines.
        seed: of noise and road; the same seed gives the same recording.
        speed: at the start [m/s], above END_SPEED.
        duration: longest time [s].
        surroundings: engine, hills and curves by time [s] and car; nothing if not given.
        car: one made of the same parameters, speed and seed; if not given one that stays on its path.

    Raises:
        ValueError: the sample rate is no divisor of 1000 Hz.
    """
    measured = MeasuredCar(parameters, speed, seed, car)
    car = measured.car
    rows = []
    for step in range(round(duration / STEP) + 1):
        if step % measured.steps_per_sample == 0:
            m = measured.measure()
            rows.append(
                [
                    *(m.time, *m.wheel_speed, *m.brake_pressure, m.acceleration),
                    *(car.speed, *car.slip, *car.tyre_slip, *car.friction, *car.vertical_load, car.acceleration),
                    *(*car.grip, car.yaw_rate),
                ]
            )
        if car.speed <= END_SPEED or abs(car.lateral_speed) > SPUN * car.speed:
            break
        around = surroundings(measured.time, car) if surroundings else _NOTHING
        pressure = prescription.pressure(measured.time, STEP, car)
        measured.step(pressure, around.engine_torque, around.slope, around.curvature)
    peaks = np.array([tyre.peak for tyre in parameters.tyres])
    table = np.array(rows)
    return Recording(
        time=table[:, 0],
        wheel_speed=table[:, 1:5],
        brake_pressure=table[:, 5:9],
        acceleration=table[:, 9],
        speed=table[:, 10],
        slip=table[:, 11:15],
        tyre_slip=table[:, 15:19],
        mu=table[:, 19:23],
        vertical_load=table[:, 23:27],
        true_acceleration=table[:, 27],
        yaw_rate=table[:, 32],
        lambda_max=peaks[:, 0],
        mu_max=peaks[:, 1] * table[:, 28:32],
        parameters=parameters,
    )
