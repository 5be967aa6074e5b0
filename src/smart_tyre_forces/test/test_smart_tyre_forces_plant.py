"""The plant's own tyre blocks through the processor: the shift follows the force that the plant knows."""

from typing import Any

import numpy as np
import pytest

from corner_sim.parameters import SimParameters
from corner_sim.simulation import Simulation
from friction_runtime.stamps import to_nanoseconds
from smart_tyre_forces.parameters import SmartTyreParameters
from smart_tyre_forces.processor import build
from vehicle_models.tyre_ring import TyreRing

START = 1_000_000_000


@pytest.mark.parametrize("noise", ["none", "chapter"])
def test_braking_of_the_plant_shifts_the_patch_by_its_force(noise: str) -> None:
    plant = SimParameters(
        tyre_signals=True, noise=noise, initial_speed=14.0, demand_start=15.0, demand_level=0.4, end_time=16.4
    )
    simulation = Simulation(plant, START)
    processor = build(SmartTyreParameters(tyre_radius=plant.radius, zero_maximum_speed=15.0))[0]
    patches: list[Any] = []
    truth: list[tuple[int, float]] = []
    while simulation.end is None:
        for topic, message in simulation.messages():
            if topic == "front_left/tyre_signals":
                found = processor.process(topic, message)
                patches += [m for name, m in found if name == "front_left/contact_patch" and np.isfinite(m.shift_raw)]
            elif topic == "truth/front_left/tyre_force":
                truth.append((to_nanoseconds(message.header.stamp), message.fx))
        simulation.advance()
    stamps, forces = np.array(truth).T
    stamp = np.array([to_nanoseconds(p.header.stamp) for p in patches], dtype=np.float64)
    rolling, braking = stamp < START + 15e9, stamp > START + 15.3e9
    assert np.count_nonzero(rolling) > 15 and np.count_nonzero(braking) > 3
    shift = np.array([p.shift_raw for p in patches])
    assert np.degrees(np.mean(shift[rolling])) == pytest.approx(0.0, abs=0.05)
    ring = TyreRing()
    fx = np.interp(stamp[braking], stamps, forces)
    assert np.all(fx < -500.0)
    speed = np.array([p.wheel_speed for p in patches])[braking] * ring.radius
    load = plant.mass * 9.81
    # The plant's delay of 0.2 ms and the tyre's speed trend are not calibrated away here.
    slower = speed - 14.0 / plant.radius * ring.radius
    expected = (
        ring.patch_shift(fx, load, 2e5, slower) - ring.patch_shift(0.0, load, 2e5, 0.0) + 2e-4 * slower / ring.radius
    )
    assert np.degrees(shift[braking] - expected) == pytest.approx(0.0, abs=0.35 if noise == "chapter" else 0.1)
