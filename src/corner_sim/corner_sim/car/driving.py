"""Brake pressures by prescription, and a driver in ordinary traffic; both know the truth, as no controller does."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import cos, inf, pi, sin

import numpy as np

from corner_sim.car.car import Car
from corner_sim.car.car_parameters import CarParameters
from corner_sim.car.tyres import Tyre
from vehicle_models.constants import AIR_DENSITY, GRAVITY


def peak_pressures(parameters: CarParameters) -> list[float]:
    """Pressures [Pa] that hold the wheels at the peak in a steady stop, all wheels at theirs."""
    p = parameters
    peaks = [tyre.peak for tyre in p.tyres]
    mean = sum(mu_max for _, mu_max in peaks) / 4.0
    moved = mean * p.height / p.wheelbase
    shares = [0.5 * (p.front_load_share + moved)] * 2 + [0.5 * (1.0 - p.front_load_share - moved)] * 2
    pressures = []
    for i, (lambda_max, mu_max) in enumerate(peaks):
        tyre = p.radius[i] * mu_max * p.mass * GRAVITY * shares[i]
        spin = p.inertia[i] * (1.0 - lambda_max) * mean * GRAVITY / p.radius[i]  # the brake slows the wheel, too
        pressures.append((tyre + spin) / p.brake_gain[i])
    return pressures


LOOK_AHEAD = 0.02
"""Time over which slips are extrapolated [s]: beyond the peak a wheel loses half its speed before its torque falls."""
MAX_SLIP = 0.7
"""Slip at which pressure falls at the latest: on cobblestone twice lambda_max is nearly a locked wheel."""


@dataclass(frozen=True)
class Cycling:
    """How slip is cycled through the peak."""

    start: float = 0.7
    """Begin of braking [s]."""
    ramp: float = 0.3
    """Time of the first rise from nothing to the peak's pressure [s], 0.1 to 5."""
    reapply: float = 0.25
    """The same of the rises after it [s]."""
    release: float = 0.1
    """Time of a fall from the peak's pressure to nothing [s]."""
    upper: float = 1.8
    """Slip over lambda_max, as it will be LOOK_AHEAD later, at which pressure falls."""
    lower: float = 0.6
    """Slip over lambda_max at which it rises again."""


class _Swing:
    """A wheel that is taken through its peak and back, by a brake or an engine."""

    def __init__(self, cycling: Cycling) -> None:
        """Begin with the first rise."""
        self._cycling = cycling
        self._falling = self._fell = False

    def turn(self, above: bool, below: bool) -> None:
        """Begin to fall where the slip will be `above` the upper turn, to rise where it is `below` the lower one."""
        if not self._falling and above:
            self._falling = self._fell = True
        elif below:
            self._falling = False

    def rate(self, rise: float, fall: float) -> float:
        """Change per second, where `rise` and `fall` are changed in the times of the cycling."""
        c = self._cycling
        return -fall / c.release if self._falling else rise / (c.reapply if self._fell else c.ramp)


class SlipCycle:
    """Pressure of each wheel that rises until its slip is beyond the peak and falls until it is below again.

    The peak is that of the road on which the wheel is now.
    """

    def __init__(self, parameters: CarParameters, cycling: Cycling) -> None:
        """Begin without pressure."""
        self._parameters, self._cycling = parameters, cycling
        self._tyres = list(parameters.tyres)
        self._peak_pressure = peak_pressures(parameters)
        self._fall = self._peak_pressure
        """Pressures that fall within the time of a release [Pa]."""
        self._lambda_max = [tyre.peak[0] for tyre in parameters.tyres]
        self._pressure = [0.0] * 4
        self._last_slip = [0.0] * 4
        self._swings = [_Swing(cycling) for _ in range(4)]

    def pressure(self, time: float, dt: float, car: Car, most: float = inf) -> list[float]:
        """Pressures [Pa] of the step of dt [s] from `time` [s], by the slips of the tyres, shape (4,).

        None is above `most` [Pa], the driver's: so it is an anti-lock brake.
        """
        c = self._cycling
        if time < c.start:
            return self._pressure
        if car.tyres != self._tyres:
            self._change_road(car.tyres)
        for i, slip in enumerate(car.tyre_slip):
            ratio = slip / self._lambda_max[i]
            growth = (slip - self._last_slip[i]) * LOOK_AHEAD / dt
            self._last_slip[i] = slip
            above = slip + growth > min(c.upper * self._lambda_max[i], MAX_SLIP)
            self._swings[i].turn(above, ratio < c.lower)
            rate = self._swings[i].rate(self._peak_pressure[i], self._fall[i])
            self._pressure[i] = min(max(self._pressure[i] + dt * rate, 0.0), most)
        return self._pressure

    def _change_road(self, tyres: list[Tyre]) -> None:
        self._tyres = list(tyres)
        first, second, third, fourth = tyres
        before = self._peak_pressure
        self._peak_pressure = peak_pressures(replace(self._parameters, tyres=(first, second, third, fourth)))
        self._fall = [max(each) for each in zip(before, self._peak_pressure, strict=True)]
        self._lambda_max = [tyre.peak[0] for tyre in tyres]


@dataclass(frozen=True)
class PressureProfile:
    """A driver's pressure over time, the same at all wheels."""

    times: Sequence[float]
    """[s], increasing"""
    pressures: Sequence[float]
    """[Pa] at these times, linear between them, constant outside."""

    def pressure(self, time: float, dt: float, car: Car) -> list[float]:
        """Pressures [Pa] of the step of dt [s] from `time` [s], shape (4,)."""
        times, pressures = self.times, self.pressures
        middle = time + 0.5 * dt
        if middle <= times[0]:
            return [pressures[0]] * 4
        for k in range(1, len(times)):
            if middle <= times[k]:
                share = (middle - times[k - 1]) / (times[k] - times[k - 1])
                return [pressures[k - 1] + share * (pressures[k] - pressures[k - 1])] * 4
        return [pressures[-1]] * 4


@dataclass(frozen=True)
class Surroundings:
    """Actions on the car in addition to its brakes."""

    engine_torque: float = 0.0
    """At each rear wheel [N m], >= 0; 0: throttle closed."""
    slope: float = 0.0
    """Sine of the angle of the road in addition to that of the car's parameters, uphill positive."""
    curvature: float = 0.0
    """Of the path [1/m], positive to the left."""


class EngineCycle:
    """Throttle of a driver, or of a traction control, that lets the rear wheels spin and comes back until they grip."""

    def __init__(self, parameters: CarParameters, cycling: Cycling, most: float = inf, curvature: float = 0.0) -> None:
        """Begin with the throttle closed.

        Args:
            parameters: the car; its times of pressure are those of the engine's torque.
            cycling: how slips are cycled, as of a brake.
            most: largest torque over that at the peak of the rear tyres [-].
            curvature: of the path [1/m].
        """
        p, self._cycling, self._curvature = parameters, cycling, curvature
        self._lambda_max = [tyre.peak[0] for tyre in p.tyres[2:]]
        mu = min(tyre.peak[1] for tyre in p.tyres[2:])
        load = p.mass * GRAVITY * (1.0 - p.front_load_share) / (1.0 - mu * p.height / p.wheelbase)
        self._peak = 0.5 * p.radius[2] * mu * load
        self._most = most * self._peak
        self._torque, self._swing = 0.0, _Swing(cycling)
        self._time, self._last = 0.0, [0.0, 0.0]

    def __call__(self, time: float, car: Car) -> Surroundings:
        """Torque at a time [s], by the slips of the tyres."""
        c, dt = self._cycling, time - self._time
        self._time = time
        if time >= c.start and dt > 0.0:
            ratios = [-slip / top for slip, top in zip(car.tyre_slip[2:], self._lambda_max, strict=True)]
            ahead = [x + (x - last) * LOOK_AHEAD / dt for x, last in zip(ratios, self._last, strict=True)]
            self._last = ratios
            self._swing.turn(max(ahead) > c.upper, max(ratios) < c.lower)
            rate = self._swing.rate(self._peak, self._peak)
            self._torque = min(max(self._torque + dt * rate, 0.0), self._most)
        return Surroundings(engine_torque=self._torque, curvature=self._curvature)


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
