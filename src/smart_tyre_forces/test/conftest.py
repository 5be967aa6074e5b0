"""Signals of one simulated wheel, shared by the tests."""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from corner_sim.smart_tyre.tyre_ring import TyreRing
from corner_sim.smart_tyre.tyre_signal import AccelerometerParameters, EncoderParameters, TyreBlock, TyreSignalSource
from smart_tyre_forces.patch_tracker import PatchTracker
from smart_tyre_forces.tooth_table import ToothTable
from vehicle_models.vehicle import Wheel
from vehicle_models.vehicle_file import load_vehicle

Simulate = Callable[..., TyreBlock]
RING = TyreRing()


@lru_cache(maxsize=32)
def _simulate(speeds: tuple[float, ...], seconds: float, ideal: bool, fx: float, load: float, seed: int) -> TyreBlock:
    accelerometer = AccelerometerParameters.ideal() if ideal else replace(AccelerometerParameters(), edge_jitter=0.0)
    encoder = EncoderParameters.ideal() if ideal else EncoderParameters()
    source = TyreSignalSource(RING, accelerometer, encoder, wheel_seed=1, noise_seed=seed)
    count = round(seconds * 1e4)
    speed = np.interp(np.linspace(0.0, 1.0, count), np.linspace(0.0, 1.0, len(speeds)), speeds)
    return source.advance(speed / RING.radius, fx, load * RING.static_load)


@pytest.fixture(scope="session")
def simulate() -> Simulate:
    """Signals at speeds [m/s] run through evenly within `seconds`, cached."""

    def call(
        *speeds: float, seconds: float, ideal: bool = False, fx: float = 0.0, load: float = 1.0, seed: int = 0
    ) -> TyreBlock:
        return _simulate(speeds, seconds, ideal, fx, load, seed)

    return call


@pytest.fixture(scope="session")
def wheel() -> Wheel:
    """The wheel that the tyre is on."""
    return load_vehicle("smart_tyre_car").wheel("front_left")


@pytest.fixture(scope="session")
def table(simulate: Simulate, wheel: Wheel) -> ToothTable:
    """Tooth table of the simulated wheel, learned from a drive of its own."""
    block = simulate(15.0, seconds=8.0, seed=77)
    tracker = PatchTracker(wheel)
    tracker.push(0, block.encoder_voltage, block.radial_acceleration)
    assert tracker.wheel.table is not None
    return tracker.wheel.table
