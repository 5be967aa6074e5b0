"""The driver's stops of section 8.2.3, in a car whose measured friction differs from the static curve (Figure 8.9)."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from corner_sim.driver import DriverProfile
from corner_sim.plant import SAMPLE_TIME, SAMPLE_TIME_NS, Plant, PlantSample, SlopeCrossings
from corner_sim.road import Road
from corner_sim.ros import messages
from corner_sim.sensors import CHAPTER_NOISE, Sensors
from friction_runtime.processor import Output
from vehicle_models import burckhardt
from vehicle_models.brake_actuator import ActuatorParameters, Command
from vehicle_models.constants import AIR_DENSITY, GRAVITY
from vehicle_models.vehicle import Vehicle, four_wheels
from vehicle_models.vehicle_file import load_vehicle
from vehicle_models.wheel_forces import axle_loads

Array = NDArray[np.float64]

VEHICLE = "chapter_car"
_SUBSTEPS = 25
"""Steps of integration within a sample."""
_PROPORTIONING = np.array([1.0, 1.0, 0.375, 0.375])
"""Line pressure of each wheel over the driver's: a proportioning valve reduces that of the rear axle."""
_SPEED = 25.0
_DURATION = 2.5
ACCELERATION_VARIANCE = 0.01
"""Noise of the accelerometer [m^2/s^4]."""


class SprungCar:
    """A car whose tyres relax and whose load moves through springs; arrays in the order of four_wheels, shape (4,).

    With the slip s that the contact has built up, and the load q moved to the front axle:

        L s_dot = v (lambda - s),    Fx_i = Fz_i mu(s_i)                         (relaxation length L of a tyre)
        q_ddot = w^2 (q_ss - q) - 2 z w q_dot,    q_ss = m h |a| / wheelbase

    The load of the front axle overshoots, so that Fx over the quasi-static load exceeds the static curve before it
    settles (Figure 8.9). No rolling resistance and no grade; the car must not come to rest.
    """

    def __init__(self, vehicle: Vehicle, speed: float) -> None:
        """Start free rolling at `speed` [m/s].

        Raises:
            ValueError: the vehicle does not have four wheels.
        """
        wheels = four_wheels(vehicle)
        self._vehicle = vehicle
        self._radius = np.array([wheel.radius for wheel in wheels])
        self._inertia = np.array([wheel.inertia for wheel in wheels])
        self._relaxation_length = np.array([wheel.relaxation_length for wheel in wheels])
        self._state = np.concatenate([[speed], speed / self._radius, np.zeros(6)])
        self._distance = 0.0

    @property
    def speed(self) -> float:
        """Speed of the car [m/s]."""
        return float(self._state[0])

    @property
    def distance(self) -> Array:
        """Distance of each wheel from where the front axle started [m], shape (4,)."""
        return self._distance - np.array([0.0, 0.0, self._vehicle.wheelbase, self._vehicle.wheelbase])

    @property
    def wheel_speed(self) -> Array:
        """Wheel speeds [rad/s], shape (4,)."""
        return np.asarray(self._state[1:5])

    @property
    def slip(self) -> Array:
        """Slips lambda [-], shape (4,)."""
        return 1.0 - self._radius * self.wheel_speed / self.speed

    @property
    def radius(self) -> Array:
        """Radii [m], shape (4,)."""
        return self._radius

    @property
    def inertia(self) -> Array:
        """Wheel inertias [kg m^2], shape (4,)."""
        return self._inertia

    def peak_torque(self, theta: Array) -> float:
        """Quasi-static brake torque [N m] that holds a front wheel at the peak while all wheels are at theirs."""
        car, radius, inertia = self._vehicle, float(self._radius[0]), float(self._inertia[0])
        lambda_max, mu_max = burckhardt.peak(theta)
        front, _ = axle_loads(-mu_max * GRAVITY, car.mass, car.front_load_share, car.height_ratio, GRAVITY)
        return float(mu_max * radius * (0.5 * front) + inertia * (1.0 - lambda_max) * mu_max * GRAVITY / radius)

    def friction(self, theta: Array) -> Array:
        """Friction coefficients Fx / Fz [-] of the relaxed tyres, shape (4,)."""
        return np.asarray(burckhardt.friction(theta, self._state[5:9]))

    def vertical_load(self, theta: Array) -> Array:
        """Loads [N], shape (4,)."""
        return self._loads(self._state)

    def acceleration(self, theta: Array) -> float:
        """Acceleration [m/s^2]."""
        return float(self._rate(self._state, theta, np.zeros(4))[0])

    def wheel_acceleration(self, theta: Array, brake_torque: Array) -> Array:
        """Wheel accelerations [rad/s^2], shape (4,)."""
        return np.asarray(self._rate(self._state, theta, brake_torque)[1:5])

    def step(self, torque_begin: Array, torque_end: Array, theta: Array, dt: float) -> None:
        """Advance by dt [s] with the midpoint rule; the wheels must not stand."""
        h = dt / _SUBSTEPS
        for k in range(_SUBSTEPS):
            torque = torque_begin + (torque_end - torque_begin) * (k + 0.5) / _SUBSTEPS
            middle = self._state + 0.5 * h * self._rate(self._state, theta, torque)
            self._distance += h * float(middle[0])
            self._state = self._state + h * self._rate(middle, theta, torque)
            self._state[1:5] = np.maximum(self._state[1:5], 0.0)

    def _loads(self, state: Array) -> Array:
        car = self._vehicle
        weight = car.mass * GRAVITY
        front, rear = weight * car.front_load_share + state[9], weight * (1.0 - car.front_load_share) - state[9]
        return 0.5 * np.array([front, front, rear, rear])

    def _rate(self, state: Array, theta: Array, torque: Array) -> Array:
        """Rates of speed, wheel speeds, built-up slips, moved load and its rate."""
        car = self._vehicle
        speed, wheel_speed, built_up = state[0], state[1:5], state[5:9]
        force = self._loads(state) * burckhardt.friction(theta, built_up)
        drag = 0.5 * AIR_DENSITY * car.drag_area * speed**2
        acceleration = -(np.sum(force) + drag) / car.mass
        slip = 1.0 - self._radius * wheel_speed / speed
        moved = -car.mass * acceleration * car.centre_of_gravity_height / car.wheelbase
        frequency = 2.0 * np.pi * car.pitch_frequency
        pitch = frequency**2 * (moved - state[9]) - 2.0 * car.pitch_damping * frequency * state[10]
        return np.concatenate(
            [
                [acceleration],
                (self._radius * force - torque) / self._inertia,
                speed / self._relaxation_length * (slip - built_up),
                [state[10], pitch],
            ]
        )


@dataclass(frozen=True)
class Stop:
    """A stop that the driver breaks off beyond the peak."""

    note: str
    """Description of the stop."""
    surface: str
    """Name of the road."""
    level: float
    """Brake torque of a front wheel in multiples of its quasi-static peak torque."""


def _stop(surface: str, level: float) -> Stop:
    note = "stop by the driver's brake as in 8.2.3, with load transfer, suspension and tyre relaxation"
    return Stop(f"{surface}: {note} (the overshoot of Figure 8.9); four wheels", surface, level)


STOPS = {"high_grip_stop": _stop("high_grip", 1.02), "low_grip_stop": _stop("off_road", 1.03)}


def car_of_the_stops() -> Vehicle:
    """Return the car, its wheels in the order of the arrays."""
    vehicle = load_vehicle(VEHICLE)
    return replace(vehicle, wheels=four_wheels(vehicle))


def drive(stop: Stop, vehicle: Vehicle) -> Iterator[tuple[PlantSample, float]]:
    """Yield the true samples of a stop, SAMPLE_TIME apart, and the pressure [Pa] that the driver demands at each.

    Args:
        stop: the stop.
        vehicle: the car, its wheels in the order of four_wheels.
    """
    car = SprungCar(vehicle, _SPEED)
    road = Road((stop.surface,), (0.0,))
    plant = Plant(car, road, ActuatorParameters(), vehicle)
    pressure = stop.level * car.peak_torque(road.theta(0.0)) / vehicle.wheels[0].brake_gain
    driver = DriverProfile(pressure, start=0.5, rise=0.4, hold=0.35, release=0.1)
    for index in range(round(_DURATION / SAMPLE_TIME) + 1):
        demand = driver.demand(index * SAMPLE_TIME)
        sample = plant.sample()
        yield replace(sample, friction=car.friction(sample.theta)), demand
        plant.advance(demand * _PROPORTIONING, Command.NONE)


def simulate(stop: Stop, start_stamp: int, seed: int = 0) -> Iterator[Output]:
    """Yield absolute topics and messages of a stop; the first sample is at `start_stamp` [ns]."""
    vehicle = car_of_the_stops()
    sensors = Sensors(CHAPTER_NOISE, ACCELERATION_VARIANCE, 0.0, vehicle, seed)
    crossings = SlopeCrossings(len(vehicle.wheels))
    for sample, demand in drive(stop, vehicle):
        stamp = start_stamp + sample.index * SAMPLE_TIME_NS
        crossings.update(sample, stamp)
        measured = sensors.measure(sample)
        outputs = messages.truth(stamp, vehicle.wheel_names, sample, crossings)
        outputs.append(("brake_demand", messages.brake_demand(stamp, demand)))
        outputs += messages.sensors(stamp, vehicle, measured, CHAPTER_NOISE, ACCELERATION_VARIANCE)
        yield from ((f"/{topic}", message) for topic, message in outputs)
