"""Cramér-Rao bound of a random car, with all perturbations as nuisance parameters.

Wheel equations of the four wheels and the sum of forces against the accelerometer are linearised about the true motion,

    e_i = J omega_dot + kappa_i T(t + tau) + T_drag - r Fz mu f(s / lambda_max)
    0   = (a - b) / (1 + c) + sum (J omega_dot + kappa T + T_drag) / (r m) + roll + drag

with the information of the ranges from which the cars are drawn (normal, of the same deviation). The family of the tyre
is known, its shape is not. The noise of e is that of the torque and the load varied by the road with its true spectrum,
which no estimator knows: none can be better, and hardly one as good.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from benchmarks.real_car.stops import JUDGED
from benchmarks.runner import Row, not_judged
from corner_sim.car.car import BAND
from corner_sim.car.car_parameters import WHEELS
from corner_sim.car.driving import SlipCycle
from corner_sim.car.random_car import random_car
from corner_sim.car.recording import Recording, record
from corner_sim.car.tyres import Burckhardt, Pacejka, Tyre
from vehicle_models.constants import GRAVITY

Array = NDArray[np.float64]

_UNIFORM = 1.0 / sqrt(3.0)
"""Deviation of a uniform distribution over its half width."""
_TORQUE = 5.0
"""Deviation of the torque at a sample besides what the load does [N m]."""
_BALANCE = 0.05
"""Deviation of the sum of forces in a mean over _MEAN [m/s^2]."""
_MEAN = 0.04
"""[s]"""
_PRIOR = {
    "ln mu_max": 0.8,
    "ln lambda_max": 0.7,
    "shape": 1.0,
    "ln mass": 0.15 * _UNIFORM,
    "ln inertia": 0.15 * _UNIFORM,
    "ln gain front": 0.1 * _UNIFORM,
    "ln gain rear": 0.1 * _UNIFORM,
    "pressure delay": 0.01 * _UNIFORM,
    "ln relaxation": 0.6,
    "speed": 0.05,
    "bias": 0.3 * _UNIFORM,
    "gravity of the slope": 0.04 * GRAVITY * _UNIFORM,
    "scale and radius": sqrt(0.02**2 + 0.01**2 + 0.013**2) * _UNIFORM,
    "acceleration delay": 0.005 * _UNIFORM,
    "engine drag": 40.0 * _UNIFORM,
    "ln height": 0.1 * _UNIFORM,
    "load share": 0.02 * _UNIFORM,
    "ln lag of the load": 0.27,
    **{f"slip of {wheel}": 5e-4 for wheel in WHEELS},
}
"""Deviations of the unknowns before the stop; of the shape in units of `_shape_sensitivity`."""


@dataclass(frozen=True)
class Bound:
    """Car of which the bound is asked."""

    seed: int
    road: str
    family: str


def bound(car: Bound) -> tuple[float, float]:
    """Relative deviations of lambda_max and mu_max [-] that are left JUDGED after the first wheel has passed."""
    drawn = random_car(car.seed, car.road, car.family)
    p = replace(drawn.parameters, load_variation=0.0)  # its own motion would be taken for known
    run = record(p, SlipCycle(p, drawn.cycling), car.seed)
    beyond = (run.tyre_slip > run.lambda_max).any(axis=1)
    n = int(np.searchsorted(run.time, run.time[beyond.argmax()] + JUDGED))
    names = list(_PRIOR)
    information = np.diag([1.0 / deviation**2 for deviation in _PRIOR.values()])
    wheel_parts, balance = _sensitivities(run, n)
    forces = run.vertical_load[:n] * run.mu[:n]
    for wheel in range(4):
        torque = p.radius[wheel] * forces[:, wheel]
        noise = _TORQUE**2 * np.eye(n)
        noise += drawn.parameters.load_variation**2 * _correlation(run.time[:n]) * np.outer(torque, torque)
        columns = np.array([wheel_parts[name][:, wheel] for name in names]).T
        information += columns.T @ np.linalg.solve(noise, columns)
    width = max(round(_MEAN / float(run.time[1])), 1)
    whole = n // width * width
    means = np.array([balance[name][:whole].reshape(-1, width).mean(axis=1) for name in names]).T
    information += means.T @ means / _BALANCE**2
    covariance = np.linalg.inv(information)
    left = np.sqrt(np.diag(covariance))
    return float(left[names.index("ln lambda_max")]), float(left[names.index("ln mu_max")])


def bound_rows(road: str, left: Sequence[tuple[float, float]]) -> list[Row]:
    """Rows of the bounds of many cars on a road; RMS over the cars, to be held against the RMSE."""
    rows: list[Row] = []
    for name, values in zip(("lambda_max", "mu_max"), np.array(left).T, strict=True):
        start = {"case": "random cars", "road": road, "stops": len(left)}
        quantity = f"bound with all perturbations, {name} [%]"
        median = {"median_pct": 100.0 * float(np.median(values))}
        rows.append(start | {"quantity": quantity} | not_judged(100.0 * float(np.sqrt(np.mean(values**2)))) | median)
    return rows


def _correlation(time: Array) -> Array:
    """Autocorrelation of the load, whose spectrum is flat in BAND, shape (n, n)."""
    apart = time[:, np.newaxis] - time
    low, high = BAND
    return (high * np.sinc(2.0 * high * apart) - low * np.sinc(2.0 * low * apart)) / (high - low)


def _sensitivities(run: Recording, n: int) -> tuple[dict[str, Array], dict[str, Array]]:
    """Derivatives by every unknown of e, shape (n, 4) [N m], and of the sum of forces, shape (n,) [m/s^2]."""
    p, time = run.parameters, run.time[:n]
    dt = float(time[1] - time[0])
    radius, inertia, relaxation = np.array(p.radius), np.array(p.inertia), np.array(p.relaxation_length)
    speed, slip = run.speed[:n, np.newaxis], run.slip[:n]
    omega = speed * (1.0 - slip) / radius
    load, friction = run.vertical_load[:n], run.mu[:n]
    tyre_torque = radius * load * friction
    spin = inertia * np.gradient(omega, dt, axis=0)
    drag = np.array([0.0, 0.0, p.engine_drag, p.engine_drag])
    brake = tyre_torque - spin - drag
    a = run.true_acceleration[:n]
    slope = np.array([[tyre.friction(s)[1] for s, tyre in zip(row, p.tyres, strict=True)] for row in run.tyre_slip[:n]])

    def by_slip(kinematic: Array) -> Array:
        """e by a change of the kinematic slip, shape (n, 4), which the tyre follows."""
        followed = np.zeros((n, 4))
        keep = np.exp(-dt * speed / relaxation)
        for k in range(1, n):
            followed[k] = keep[k] * followed[k - 1] + (1.0 - keep[k]) * 0.5 * (kinematic[k] + kinematic[k - 1])
        return -radius * load * slope * followed

    def by_speed(change: Array) -> Array:
        return by_slip((1.0 - slip) * change[:, np.newaxis] / speed)

    nothing, none = np.zeros((n, 4)), np.zeros(n)
    front, rear = np.array([1.0, 1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0, 1.0])
    gained = np.cumsum(a) * dt
    moved = load - load[0]  # the road is smooth here
    lag = 2.0 * p.pitch_damping / (2.0 * np.pi * p.pitch_frequency)
    lagging = -lag * np.gradient(moved, dt, axis=0)
    shared = 0.5 * p.mass * GRAVITY * (front - rear)

    def force(torque: Array) -> Array:
        """Sum of forces over the mass of torques, shape (n,)."""
        return np.asarray((torque / radius).sum(axis=1) / p.mass)

    wheels = {
        "ln mu_max": -tyre_torque,
        "ln lambda_max": radius * load * slope * run.tyre_slip[:n],
        "shape": -radius * load * _shape_sensitivity(p.tyres[0], run.tyre_slip[:n]),
        "ln mass": -tyre_torque,
        "ln inertia": spin,
        "ln gain front": brake * front,
        "ln gain rear": brake * rear,
        "pressure delay": np.gradient(brake, dt, axis=0),
        "ln relaxation": by_slip(-relaxation * np.gradient(run.tyre_slip[:n], dt, axis=0) / speed),
        "speed": by_speed(none + 1.0),
        "bias": by_speed(-time),
        "gravity of the slope": by_speed(-time),
        "scale and radius": by_speed(-gained),
        "acceleration delay": by_speed(a - a[0]),
        "engine drag": nothing + rear,
        "ln height": -radius * friction * moved,
        "load share": -radius * friction * shared,
        "ln lag of the load": -radius * friction * lagging,
        **{f"slip of {name}": by_slip(nothing + (np.arange(4) == k)) for k, name in enumerate(WHEELS)},
    }
    balance = dict.fromkeys(_PRIOR, none) | {
        "ln mass": -force(tyre_torque),
        "ln inertia": force(spin),
        "ln gain front": force(brake * front),
        "ln gain rear": force(brake * rear),
        "pressure delay": force(np.gradient(brake, dt, axis=0)),
        "bias": none - 1.0,
        "scale and radius": -a,
        "acceleration delay": np.gradient(a, dt),
        "engine drag": force(nothing + rear),
    }
    return wheels, balance


def _shape_sensitivity(tyre: Tyre, slip: Array) -> Array:
    """Change of mu at a slip, shape (n, 4), by one deviation of the shape of the family with the peak held.

    The shape of Pacejka's is taken to be C: E bends the same part of the curve.
    """
    lambda_max, mu_max = tyre.peak
    x = slip / lambda_max
    if isinstance(tyre, Burckhardt):
        # k - ln k has a deviation of 0.45 between roads
        k = tyre.th2 * lambda_max
        return mu_max * (_burckhardt(x, k + 0.01) - _burckhardt(x, k)) / 0.01 * 0.45 * k / (k - 1.0)
    assert isinstance(tyre, Pacejka)
    by_c = (_pacejka(x, tyre.C + 0.01, tyre.E) - _pacejka(x, tyre.C, tyre.E)) / 0.01
    return mu_max * by_c * 0.25


def _burckhardt(x: Array, k: float) -> Array:
    """Curve with its peak at (1, 1)."""
    return np.asarray((1.0 - np.exp(-k * x) - k * np.exp(-k) * x) / (1.0 - np.exp(-k) - k * np.exp(-k)))


def _pacejka(x: Array, C: float, E: float) -> Array:
    """Curve with its peak at (1, 1)."""
    y = x * Pacejka(1.0, C, 1.0, E).peak[0]
    return np.asarray(np.sin(C * np.arctan(y - E * (y - np.arctan(y)))))
