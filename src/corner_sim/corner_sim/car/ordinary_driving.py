"""A driver in ordinary traffic: accelerating, cruising, braking gently, in curves and over hills."""

from math import cos, pi, sin

import numpy as np

from corner_sim.car.car import Car
from corner_sim.car.car_parameters import CarParameters
from corner_sim.car.recording import Surroundings
from vehicle_models.constants import AIR_DENSITY, GRAVITY

LOWEST, HIGHEST = 6.0, 33.0
"""Speeds between which the driver keeps the car [m/s]."""
HILL = 0.04
"""Steepest slope of the hills (sine of the angle) where friction is 0.5 or more, less in proportion below."""
LATERAL = 2.0
"""Largest acceleration in curves [m/s^2]."""


class OrdinaryDriver:
    """Pressures, engine and road of a drive; it never needs more than 60 % of the friction there is.

    Each phase has an acceleration, drawn: 0.05-0.25 g forward, none, or braking at 0.05-0.5 g with a share of the
    gentle; it lasts 2-10 s and ends early at LOWEST or HIGHEST. Pedals take 0.3 s.
    """

    PEDAL = 0.3
    """Time constant of the pedals [s]."""

    def __init__(self, parameters: CarParameters, seed: int) -> None:
        """Draw the drive from `seed`."""
        self._p = parameters
        self._rng = np.random.default_rng([seed, 3])
        friction = min(tyre.peak[1] for tyre in parameters.tyres)
        self._most = 0.6 * friction * GRAVITY
        self._hill = HILL * min(friction / 0.5, 1.0)
        driven_load = 0.5 * parameters.mass * GRAVITY * (1.0 - parameters.front_load_share)
        self._most_torque = 0.6 * friction * driven_load * parameters.radius[2]
        self._phase_end, self._goal, self._now = 0.0, 0.0, 0.0
        self._torque, self._pressure = 0.0, 0.0
        self._hill_length = float(self._rng.uniform(400.0, 1500.0))
        self._curve_time = float(self._rng.uniform(5.0, 20.0))
        self._distance = 0.0
        self._last_time = 0.0

    def surroundings(self, time: float, car: Car) -> Surroundings:
        """Engine, hill and curve at `time` [s]; call it once each step, before `pressure`."""
        dt, self._last_time = time - self._last_time, time
        self._distance += dt * car.speed
        if time >= self._phase_end or (car.speed < LOWEST and self._goal < 0.0):
            self._begin_phase(time, car.speed)
        elif car.speed > HIGHEST:
            self._goal = min(self._goal, 0.0)
        self._now += (self._goal - self._now) * min(dt / self.PEDAL, 1.0)
        p = self._p
        slope = self._hill * sin(2.0 * pi * self._distance / self._hill_length)
        resistance = p.mass * GRAVITY * (slope + p.slope + p.rolling_resistance)
        resistance += 0.5 * AIR_DENSITY * p.drag_area * car.speed**2
        force = p.mass * self._now + resistance
        if self._now < -0.05:  # the foot is on the brake, and what the road does not take is left to it
            dragged = 2.0 * p.engine_drag / p.radius[2]
            self._torque = 0.0
            self._pressure = max(-force - dragged, 0.0) * p.radius[0] / sum(p.brake_gain)
        else:
            self._pressure = 0.0
            self._torque = min(max(0.5 * force * p.radius[2], 0.0), self._most_torque)
        lateral = min(LATERAL, 0.5 * self._most) * sin(2.0 * pi * time / self._curve_time) * cos(time / 31.0)
        return Surroundings(self._torque, slope, lateral / max(car.speed, LOWEST) ** 2)

    def pressure(self, time: float, dt: float, car: Car) -> list[float]:
        """Pressures [Pa] of the step of dt [s] from `time` [s], shape (4,)."""
        return [self._pressure] * 4

    def _begin_phase(self, time: float, speed: float) -> None:
        kind, share = self._rng.choice(4), float(self._rng.uniform())
        if speed < LOWEST + 2.0 or (kind == 0 and speed < HIGHEST):
            self._goal = min((0.05 + 0.2 * share) * GRAVITY, 0.5 * self._most)
        elif kind == 1:
            self._goal = 0.0
        else:
            self._goal = -min((0.05 + 0.45 * share * share) * GRAVITY, self._most)
        self._phase_end = time + float(self._rng.uniform(2.0, 10.0))
