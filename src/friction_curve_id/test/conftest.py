"""Braking for the tests: manoeuvre B of the evaluation protocol on one surface, noise-free or with the
chapter's noise."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from corner_sim.corner import SingleCorner
from corner_sim.sensors import CHAPTER_NOISE, NO_NOISE, SensorNoise
from friction_curve_id.interface import Sample
from vehicle_models.surfaces import surface
from vehicle_models.vehicle_file import load_vehicle

CORNER = load_vehicle("chapter_corner").corner("front_left")
HOLD_TORQUE = {"dry": 857.0, "wet": 598.0, "cobblestone": 805.0, "snow": 153.0}
"""[N m]"""
_INTERVAL = 0.005
"""[s]"""
_RAMP = 0.25


@dataclass(frozen=True)
class Manoeuvre:
    """Measured samples, and the truth at each."""

    samples: Sequence[Sample]
    slip: NDArray[np.float64]
    friction: NDArray[np.float64]


@cache
def _truth(name: str, count: int) -> NDArray[np.float64]:
    theta = surface(name)
    corner = SingleCorner(CORNER, [30.0])
    rows = []
    for k in range(count):
        torque, following = (HOLD_TORQUE[name] * min(t / _RAMP, 1.0) for t in (k * _INTERVAL, (k + 1) * _INTERVAL))
        slip, friction = float(corner.slip[0]), float(corner.friction(theta)[0])
        rows.append((k * _INTERVAL, float(corner.wheel_speed[0]), float(corner.speed[0]), torque, slip, friction))
        corner.step(torque, following, theta, _INTERVAL)
    return np.array(rows)


def brake(name: str, noise: SensorNoise, seed: int, count: int) -> Manoeuvre:
    """Brake from 30 m/s: torque up to its level within 0.25 s, then held."""
    table, generator = _truth(name, count).copy(), np.random.default_rng(seed)
    for column, variance in ((1, noise.wheel_speed_variance), (2, noise.speed_variance), (3, noise.torque_variance)):
        table[:, column] += generator.normal(0.0, variance**0.5, count)
    samples = [Sample(*row[:4]) for row in table.tolist()]
    return Manoeuvre(samples, table[:, 4], table[:, 5])


Brake = Callable[..., Manoeuvre]


@pytest.fixture(scope="session")
def clean() -> Brake:
    """Manoeuvre B without noise: clean(surface, count=100)."""
    return lambda name, count=100: brake(name, NO_NOISE, 0, count)


@pytest.fixture(scope="session")
def noisy() -> Brake:
    """Manoeuvre B with the noise of section 8.3.2: noisy(surface, seed, count=100)."""
    return lambda name, seed, count=100: brake(name, CHAPTER_NOISE, seed, count)
