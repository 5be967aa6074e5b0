"""Brake pressures by prescription: the estimators are judged, not a controller, so these know the truth."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

from corner_sim.car.car import Car
from corner_sim.car.car_parameters import GRAVITY, CarParameters


def peak_pressures(parameters: CarParameters) -> list[float]:
    """Pressures [Pa] that hold the wheels at the peak in a steady stop, all wheels at theirs."""
    p = parameters
    mean = (p.tyres[0].peak[1] + p.tyres[1].peak[1] + p.tyres[2].peak[1] + p.tyres[3].peak[1]) / 4.0
    moved = mean * p.height / p.wheelbase
    shares = [0.5 * (p.front_load_share + moved)] * 2 + [0.5 * (1.0 - p.front_load_share - moved)] * 2
    return [p.tyres[i].peak[1] * p.radius[i] * p.mass * GRAVITY * shares[i] / p.brake_gain[i] for i in range(4)]


LOOK_AHEAD = 0.03
"""Time over which slips are extrapolated [s]: beyond the peak a wheel loses half its speed before its torque falls."""
MAX_SLIP = 0.55
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
    passes: float = inf
    """Number of falls after which the pressure stays at half the peak's; infinite: never."""


class SlipCycle:
    """Pressure of each wheel that rises until its slip is beyond the peak and falls until it is below again."""

    def __init__(self, parameters: CarParameters, cycling: Cycling) -> None:
        """Begin without pressure."""
        self._cycling = cycling
        self._peak_pressure = peak_pressures(parameters)
        self._lambda_max = [tyre.peak[0] for tyre in parameters.tyres]
        self._pressure = [0.0] * 4
        self._last_slip = [0.0] * 4
        self._falls = [0] * 4
        self._falling = [False] * 4

    def pressure(self, time: float, dt: float, car: Car) -> list[float]:
        """Pressures [Pa] of the step of dt [s] from `time` [s], by the slips of the tyres, shape (4,)."""
        c = self._cycling
        if time < c.start:
            return self._pressure
        for i, slip in enumerate(car.tyre_slip):
            ratio = slip / self._lambda_max[i]
            growth = (slip - self._last_slip[i]) * LOOK_AHEAD / dt
            self._last_slip[i] = slip
            if not self._falling[i] and slip + growth > min(c.upper * self._lambda_max[i], MAX_SLIP):
                self._falling[i] = True
                self._falls[i] += 1
            elif ratio < c.lower:
                self._falling[i] = False
            peak = self._peak_pressure[i]
            top = 0.5 * peak if self._falls[i] >= c.passes else inf
            time_scale = -c.release if self._falling[i] else (c.reapply if self._falls[i] else c.ramp)
            self._pressure[i] = min(max(self._pressure[i] + dt * peak / time_scale, 0.0), top)
        return self._pressure


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
