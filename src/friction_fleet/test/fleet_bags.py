"""Short bags of a generated fleet, and bags that are broken, for the tests of this package."""

from __future__ import annotations

from pathlib import Path
from shutil import copytree

from friction_fleet.simulation.drives import DriveJob
from friction_fleet.simulation.simulate import make

SECONDS = 4.0
SEED = 5


def short_drives(directory: Path, cars: int) -> list[Path]:
    """Make a drive of each car."""
    jobs = [DriveJob(car, 0, SEED, SECONDS) for car in range(cars)]
    directory.mkdir()
    for job in jobs:
        make(directory, job)
    return [directory / job.name for job in jobs]


def broken_bags(directory: Path, sound: Path) -> list[Path]:
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
    return [empty, noise, cut, strange]
