"""The plant: vehicle, brake lines and road, advanced one sample at a time; no middleware and no clock."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from corner_sim.road import Road
from corner_sim.vehicle import Vehicle
from vehicle_models import burckhardt
from vehicle_models.brake_actuator import ActuatorParameters, BrakeActuator

Array = NDArray[np.float64]

SAMPLE_TIME_NS = 5_000_000
"""Sample time of the plant and its sensors [ns]: 200 Hz."""
SAMPLE_TIME = SAMPLE_TIME_NS * 1e-9
"""The same [s]."""
SLIP_MIN_SPEED = 0.1
"""Below this speed [m/s] slip and its rate are not defined."""


@dataclass(frozen=True)
class PlantSample:
    """True state of the plant at one sample; arrays have shape (n,) over the wheels."""

    index: int
    """Samples since the start of the run."""
    speed: float
    """Vehicle speed [m/s]."""
    acceleration: float
    """Vehicle acceleration [m/s^2], negative in braking."""
    distance: float
    """Distance covered by the first wheel [m]."""
    wheel_speed: Array
    """[rad/s]"""
    brake_torque: Array
    """[N m]"""
    slip: Array
    """[-], braking positive."""
    slip_rate: Array
    """[1/s]; NaN below SLIP_MIN_SPEED."""
    theta: Array
    """Burckhardt parameters under each wheel [-], shape (n, 3)."""
    surface: NDArray[np.int64]
    """Index of the surface under each wheel in the road's list."""
    vertical_load: Array
    """[N]"""
    friction: Array
    """Friction coefficient mu [-]."""
    slope: Array
    """mu_1 = d mu / d slip [-]."""
    h: Array
    """H of (8.3), (r Fz / J) mu_1 slip_rate [rad/s^3]; NaN where slip_rate is."""


class Plant:
    """A vehicle with one brake line per wheel on a road."""

    def __init__(self, vehicle: Vehicle, road: Road, actuator: ActuatorParameters, brake_gain: Array) -> None:
        """Put the vehicle at the begin of the road, brakes released.

        Args:
            vehicle: in its first state; the plant moves it.
            road: the surfaces.
            actuator: delay and rate limits of the hydraulics.
            brake_gain: k of T_b = k p (1.1) [N m/Pa], one per wheel, > 0.

        Raises:
            ValueError: brake_gain does not have one positive value per wheel.
        """
        self._road = road
        self._brake_gain = np.asarray(brake_gain, dtype=np.float64)
        self._vehicle = vehicle
        count = self._vehicle.wheel_speed.size
        if self._brake_gain.shape != (count,) or not np.all(self._brake_gain > 0.0):
            raise ValueError(f"brake_gain must hold {count} values > 0, is {self._brake_gain.tolist()}")
        self._actuator = BrakeActuator(count, SAMPLE_TIME, actuator)
        self._index = 0

    def sample(self) -> PlantSample:
        """Return the true state now."""
        vehicle = self._vehicle
        surface = self._road.index(vehicle.distance)
        theta = self._road.theta(vehicle.distance)
        slip = vehicle.slip
        acceleration = vehicle.acceleration(theta)
        slip_rate = np.full_like(slip, np.nan)
        if vehicle.speed > SLIP_MIN_SPEED:
            wheel_acceleration = vehicle.wheel_acceleration(theta, self._actuator.torque)
            slip_rate = ((1.0 - slip) * acceleration - vehicle.radius * wheel_acceleration) / vehicle.speed
        slope = burckhardt.slope(theta, slip)
        vertical_load = vehicle.vertical_load(theta)
        return PlantSample(
            index=self._index,
            speed=vehicle.speed,
            acceleration=acceleration,
            distance=float(vehicle.distance[0]),
            wheel_speed=vehicle.wheel_speed.copy(),
            brake_torque=self._actuator.torque.copy(),
            slip=slip,
            slip_rate=slip_rate,
            theta=theta,
            surface=surface,
            vertical_load=vertical_load,
            friction=burckhardt.friction(theta, slip),
            slope=slope,
            h=vehicle.radius * vertical_load / vehicle.inertia * slope * slip_rate,
        )

    def advance(self, demand_pressure: ArrayLike, command: ArrayLike) -> None:
        """Advance by one sample.

        Args:
            demand_pressure: line pressure the driver asks for [Pa], scalar or shape (n,).
            command: vehicle_models.brake_actuator.Command for each wheel, scalar or shape (n,).
        """
        vehicle = self._vehicle
        begin = self._actuator.torque
        end = self._actuator.step(self._brake_gain * np.asarray(demand_pressure, dtype=np.float64), command)
        vehicle.step(begin, end, self._road.theta(vehicle.distance), SAMPLE_TIME)
        self._index += 1
