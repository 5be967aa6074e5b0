"""Bags for the tests of this package: short drives of a generated fleet, and bags that are broken."""

from __future__ import annotations

from pathlib import Path
from shutil import copytree

import pytest

SECONDS = 4.0
SEED = 5


@pytest.fixture(scope="session")
def bags(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Make three drives of 4 s of three cars, one of them twice, and four broken bags."""
    pytest.importorskip("h3")
    pytest.importorskip("pyarrow")
    pytest.importorskip("fsspec")
    from friction_fleet.simulation.drives import DriveJob
    from friction_fleet.simulation.simulate import make

    directory = tmp_path_factory.mktemp("fleet") / "bags"
    directory.mkdir()
    jobs = [DriveJob(car, 0, SEED, SECONDS) for car in range(3)]
    for job in jobs:
        make(directory, job)
    copytree(directory / jobs[0].name, directory / "again")
    _break(directory, directory / jobs[1].name)
    return directory


def _break(directory: Path, sound: Path) -> None:
    """Make an empty bag, one of noise, one that was cut off, and one whose car nobody knows."""
    empty, noise, cut, strange = (directory / name for name in ("empty", "noise", "cut", "strange"))
    empty.mkdir()
    (empty / "empty_0.mcap").write_bytes(b"")
    noise.mkdir()
    (noise / "noise_0.mcap").write_bytes(b"\xff" * 10_000)
    for copy in (cut, strange):
        copytree(sound, copy)
    storage = next(cut.glob("*.mcap"))
    storage.write_bytes(storage.read_bytes()[: storage.stat().st_size // 2])
    metadata = strange / "metadata.yaml"
    metadata.write_text(metadata.read_text(encoding="utf-8").replace("compact_car", "no_such_car"), encoding="utf-8")
