"""Examples in the READMEs: they run as they stand, and their numbers are those of the plant."""

from __future__ import annotations

import re
from functools import cache
from math import nan
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from corner_sim.car.car_parameters import CarParameters
from corner_sim.car.driving import Cycling, SlipCycle
from corner_sim.car.recording import Recording, record
from corner_sim.smart_tyre.tyre_ring import TyreRing
from corner_sim.smart_tyre.tyre_signal import AccelerometerParameters, EncoderParameters, TyreSignalSource
from friction_bringup.graph import plant_calibration
from vehicle_models.constants import GRAVITY
from vehicle_models.vehicle_file import load_vehicle

ROOT = Path(__file__).parents[1]
SECOND = 1_000_000_000


def printed(package: str, **given: Any) -> list[str]:
    """Run the Python example of a package's README with these names; return what it prints."""
    readme = ROOT / "src" / package / "README.md"
    (code,) = re.findall(r"```python\n(.*?)```", readme.read_text(encoding="utf-8"), re.DOTALL)
    lines: list[str] = []
    exec(compile(code, str(readme), "exec"), {"print": lines.append, **given})
    return lines


@cache
def stop() -> Recording:
    car = CarParameters()
    return record(car, SlipCycle(car, Cycling()), 1, duration=1.5)


def test_wheel_slip() -> None:
    run, names = stop(), load_vehicle("compact_car").wheel_names
    stamps = [round(time * SECOND) + SECOND for time in run.time]
    found = printed("wheel_slip", samples=zip(stamps, run.wheel_speed, run.acceleration.tolist(), strict=True))
    assert len(found) > 4 * 200
    name, slip, _, stddev = found[-1].split()
    assert abs(float(slip) - run.slip[-1, names.index(name)]) < 3.0 * float(stddev) + 0.005


def test_friction_grip() -> None:
    run = stop()
    stamps = [round(time * SECOND) + SECOND for time in run.time]
    unknown = [nan] * run.time.size
    torques = [[nan] * 4] * run.time.size
    rows = zip(stamps, run.speed, run.acceleration, unknown, unknown, torques, run.wheel_speed, strict=True)
    found = printed("friction_grip", samples=rows)
    assert len(found) > 20
    _, used, _, stddev = found[-1].split()
    true = -np.mean(run.true_acceleration[run.time > run.time[-1] - 0.2]) / GRAVITY
    assert abs(float(used) - true) < 3.0 * float(stddev)


def test_smart_tyre_forces() -> None:
    ring = TyreRing()
    source = TyreSignalSource(ring, AccelerometerParameters(), EncoderParameters(), wheel_seed=1, noise_seed=2)
    block = source.advance(np.full(160_000, 8.0 / ring.radius), 0.0, ring.static_load)
    blocks = [(0, block.encoder_voltage, block.radial_acceleration)]
    wheel = load_vehicle("smart_tyre_car").wheel("front_left")
    found = printed("smart_tyre_forces", file=plant_calibration(), wheel=wheel, blocks=blocks)
    assert found
    load, stddev = re.findall(r"Fz (\d+) \+- (\d+)", found[-1])[0]
    assert abs(float(load) - ring.static_load) < 3.0 * float(stddev)


def test_plot_of_a_bag(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "bags").symlink_to(ROOT / "bags")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    assert printed("friction_report") == []
    assert (tmp_path / "slip.png").read_bytes().startswith(b"\x89PNG")
