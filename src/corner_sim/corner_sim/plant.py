"""Corners, brake lines and road, advanced one sample at a time; no middleware and no clock."""

from collections import deque
from dataclasses import dataclass
from math import nan
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from corner_sim.road import Road
from vehicle_models import burckhardt
from vehicle_models.brake_actuator import ActuatorParameters, BrakeActuator
from vehicle_models.nanoseconds import NANOSECOND
from vehicle_models.vehicle import Vehicle

Array = NDArray[np.float64]

SAMPLE_TIME_NS = 5_000_000
"""Sample time of the plant and its sensors [ns]: 200 Hz."""
SAMPLE_TIME = SAMPLE_TIME_NS * NANOSECOND
"""The same [s]."""
SLIP_MIN_SPEED = 0.1
"""Below this speed [m/s] slip and its rate are not defined."""


class VehicleModel(Protocol):
    """A vehicle with n braked wheels; arrays have shape (n,), theta has shape (n, 3)."""

    @property
    def speed(self) -> float:
        """Vehicle speed v [m/s], >= 0."""

    @property
    def distance(self) -> Array:
        """Distance covered by each wheel [m]."""

    @property
    def wheel_speed(self) -> Array:
        """Wheel speed omega [rad/s], >= 0."""

    @property
    def slip(self) -> Array:
        """Slip lambda [-], braking positive."""

    @property
    def radius(self) -> Array:
        """Effective rolling radius r [m]."""

    @property
    def inertia(self) -> Array:
        """Wheel inertia J [kg m^2]."""

    def peak_torque(self, theta: Array) -> float:
        """Brake torque [N m] that holds the first wheel at the peak of the road theta, shape (3,)."""

    def vertical_load(self, theta: Array) -> Array:
        """Load Fz of each wheel [N]."""

    def acceleration(self, theta: Array) -> float:
        """Vehicle acceleration [m/s^2], negative in braking."""

    def wheel_acceleration(self, theta: Array, brake_torque: Array) -> Array:
        """Wheel acceleration [rad/s^2]."""

    def step(self, torque_begin: Array, torque_end: Array, theta: Array, dt: float) -> None:
        """Advance by dt [s] under brake torques [N m] that change linearly."""


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
    pressure_torque: Array
    """Brake torque as the pressure signals show it: delayed by their age [N m]."""
    slip: Array
    """[-], braking positive."""
    tyre_slip: Array
    """Slip of the tyre, of which friction is a function; the same unless it has a relaxation length [-]."""
    slip_rate: Array
    """[1/s]; NaN below SLIP_MIN_SPEED."""
    theta: Array
    """Burckhardt parameters under each wheel [-], shape (n, 3); NaN of a tyre of another family."""
    peak: Array
    """Slip lambda_max and friction mu_max of the peak under each wheel [-], shape (n, 2)."""
    surface: NDArray[np.int64]
    """Index of the surface under each wheel in the road's list; the one after its last is that of the right wheels."""
    vertical_load: Array
    """[N]"""
    friction: Array
    """Friction coefficient mu [-]."""
    slope: Array
    """mu_1 = d mu / d slip [-]."""
    h: Array
    """H of (8.3), (r Fz / J) mu_1 slip_rate [rad/s^3]; NaN where slip_rate is."""
    yaw_moment: float = nan
    """Of the braking forces about the vertical [N m], to the left positive; NaN of a model without sides."""


class Plant:
    """A vehicle with one brake line per wheel on a road."""

    def __init__(self, model: VehicleModel, road: Road, actuator: ActuatorParameters, vehicle: Vehicle) -> None:
        """Put the vehicle at the start of the road, brakes released.

        Args:
            model: vehicle model in its initial state; the plant advances it.
            road: the surfaces.
            actuator: delay and rate limits of the hydraulics.
            vehicle: brakes, drag of the engine and delay of the pressure signals; wheels in the order of the model.

        Raises:
            ValueError: model and vehicle differ in the number of wheels.
        """
        self._road = road
        self._model = model
        count = len(vehicle.wheels)
        if model.wheel_speed.shape != (count,):
            raise ValueError(f"the model has {model.wheel_speed.size} wheels, '{vehicle.name}' has {count}")
        self._brake_gain = np.array([wheel.brake_gain for wheel in vehicle.wheels])
        self._engine_drag = np.array([vehicle.engine_drag_torque * wheel.driven for wheel in vehicle.wheels])
        self._actuator = BrakeActuator(count, SAMPLE_TIME, actuator)
        self._pressure_lag = vehicle.brake_pressure_delay / SAMPLE_TIME
        self._past_torques = deque([self._actuator.torque], maxlen=int(self._pressure_lag) + 2)
        self._index = 0

    def sample(self) -> PlantSample:
        """Return the true state now."""
        model = self._model
        surface = self._road.index(model.distance)
        theta = self._road.theta(model.distance)
        slip = model.slip
        acceleration = model.acceleration(theta)
        slip_rate = np.full_like(slip, np.nan)
        if model.speed > SLIP_MIN_SPEED:
            wheel_acceleration = model.wheel_acceleration(theta, self._actuator.torque + self._engine_drag)
            slip_rate = ((1.0 - slip) * acceleration - model.radius * wheel_acceleration) / model.speed
        slope = burckhardt.slope(theta, slip)
        vertical_load = model.vertical_load(theta)
        return PlantSample(
            index=self._index,
            speed=model.speed,
            acceleration=acceleration,
            distance=float(model.distance[0]),
            wheel_speed=model.wheel_speed.copy(),
            brake_torque=self._actuator.torque.copy(),
            pressure_torque=self._pressure_torque(),
            slip=slip,
            tyre_slip=slip,
            slip_rate=slip_rate,
            theta=theta,
            peak=np.stack(burckhardt.peak(theta), axis=-1),
            surface=surface,
            vertical_load=vertical_load,
            friction=burckhardt.friction(theta, slip),
            slope=slope,
            h=model.radius * vertical_load / model.inertia * slope * slip_rate,
        )

    def advance(self, demand_pressure: ArrayLike, command: ArrayLike) -> None:
        """Advance by one sample.

        Args:
            demand_pressure: line pressure that the driver demands [Pa], scalar or shape (n,).
            command: vehicle_models.brake_actuator.Command for each wheel, scalar or shape (n,).
        """
        model = self._model
        begin = self._actuator.torque
        end = self._actuator.step(self._brake_gain * np.asarray(demand_pressure, dtype=np.float64), command)
        theta = self._road.theta(model.distance)
        model.step(begin + self._engine_drag, end + self._engine_drag, theta, SAMPLE_TIME)
        self._past_torques.appendleft(end)
        self._index += 1

    def _pressure_torque(self) -> Array:
        """Delayed brake torque, linear between samples; the brakes were released before the first."""
        past = self._past_torques
        whole = int(self._pressure_lag)
        newer, older = (past[min(place, len(past) - 1)] for place in (whole, whole + 1))
        return newer + (self._pressure_lag - whole) * (older - newer)


class SlopeCrossings:
    """Counts, per wheel, how often the sign of the slope mu_1 changed, and where."""

    def __init__(self, count: int) -> None:
        """Start with no crossing on `count` wheels."""
        self.count: NDArray[np.int64] = np.zeros(count, dtype=np.int64)
        """Crossings so far."""
        self.sign: NDArray[np.int64] = np.ones(count, dtype=np.int64)
        """Sign of the slope at the last sample."""
        self.slip: NDArray[np.float64] = np.full(count, np.nan)
        """Slip at the last crossing [-]: lambda_max of the road; NaN before."""
        self.stamp: NDArray[np.int64] = np.zeros(count, dtype=np.int64)
        """Stamp of the last crossing [ns]; 0 before."""
        self.surface_changes: NDArray[np.int64] = np.zeros(count, dtype=np.int64)
        """How often the surface changed."""
        self._previous: PlantSample | None = None

    def update(self, sample: PlantSample, stamp_ns: int) -> None:
        """Take the next sample, with its stamp [ns].

        The time of a crossing is interpolated between the samples. Where the curve itself changed under the wheel, the
        crossing is at the sample and at its slip.
        """
        before, self._previous = self._previous, sample
        sign = np.where(sample.slope < 0.0, -1, 1)
        if before is not None:
            changed = sample.surface != before.surface
            self.surface_changes = self.surface_changes + changed
            for i in np.flatnonzero(sign != self.sign):
                self.count[i] += 1
                self.slip[i], self.stamp[i] = sample.tyre_slip[i], stamp_ns
                if not changed[i]:
                    peak = float(sample.peak[i, 0])
                    remaining = (sample.tyre_slip[i] - peak) / (sample.tyre_slip[i] - before.tyre_slip[i])
                    self.slip[i] = peak
                    self.stamp[i] = stamp_ns - round(remaining * SAMPLE_TIME_NS)
        self.sign = sign
