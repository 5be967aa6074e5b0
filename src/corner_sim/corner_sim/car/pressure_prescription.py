"""Brake pressures by prescription: the estimators are judged, not a controller, so these know the truth."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from corner_sim.car.car import Car
from corner_sim.car.car_parameters import CarParameters
from corner_sim.car.tyre import Tyre
from vehicle_models.constants import GRAVITY


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
        self._fell = [False] * 4
        self._falling = [False] * 4

    def pressure(self, time: float, dt: float, car: Car) -> list[float]:
        """Pressures [Pa] of the step of dt [s] from `time` [s], by the slips of the tyres, shape (4,)."""
        c = self._cycling
        if time < c.start:
            return self._pressure
        if car.tyres != self._tyres:
            self._change_road(car.tyres)
        for i, slip in enumerate(car.tyre_slip):
            ratio = slip / self._lambda_max[i]
            growth = (slip - self._last_slip[i]) * LOOK_AHEAD / dt
            self._last_slip[i] = slip
            if not self._falling[i] and slip + growth > min(c.upper * self._lambda_max[i], MAX_SLIP):
                self._falling[i] = True
                self._fell[i] = True
            elif ratio < c.lower:
                self._falling[i] = False
            if self._falling[i]:
                rate = -self._fall[i] / c.release
            else:
                rate = self._peak_pressure[i] / (c.reapply if self._fell[i] else c.ramp)
            self._pressure[i] = max(self._pressure[i] + dt * rate, 0.0)
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
