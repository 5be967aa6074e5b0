"""Every process that runs estimators has one BLAS thread, so that a bag that is processed twice has the same bytes."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
FREE = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
SEVERAL = {**FREE, "OPENBLAS_NUM_THREADS": "4"}
"""Environment of a machine with four cores."""
PROCESSES = (
    *("wheel_slip.ros.node", "friction_slope.ros.node", "friction_curve_id.ros.node", "abs_supervisor.ros.node"),
    *("smart_tyre_forces.ros.node", "friction_bringup.composed", "friction_bags.offline.process"),
    *("friction_bags.offline.run", "vehicle_doctor.__main__", "friction_report.__main__"),
)
"""Module that each process begins with: nodes, commands, workers."""


@pytest.mark.parametrize("module", PROCESSES)
def test_every_process_has_one_blas_thread(module: str) -> None:
    code = f"""
import {module}
import scipy.linalg
from friction_runtime.blas_threads import blas_threads
print(*blas_threads())"""
    done = subprocess.run([sys.executable, "-c", code], env=SEVERAL, capture_output=True, text=True, check=True)
    assert set(done.stdout.split()) <= {"1"}


def test_a_bag_that_is_processed_twice_has_the_same_bytes(tmp_path: Path) -> None:
    for out in ("one", "other"):
        command = [sys.executable, "-m", "friction_bags", "process", str(ROOT / "bags" / "high_grip_stop")]
        subprocess.run([*command, "--out", str(tmp_path / out)], env=SEVERAL, check=True, capture_output=True)
    one, other = (next((tmp_path / out).glob("*.mcap")).read_bytes() for out in ("one", "other"))
    assert one == other
