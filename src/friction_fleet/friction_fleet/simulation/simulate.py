"""`simulate`: bags of a fleet of unknown cars in a town, with the friction of every cell as truth."""

from __future__ import annotations

import json
from argparse import ArgumentParser, Namespace
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from os import cpu_count
from pathlib import Path
from shutil import rmtree

from friction_bags.bag_io.bag_writer import write_bag
from friction_bags.bag_vehicle import VEHICLE_NOTE
from friction_bags.progress_bars import bars
from friction_fleet.simulation.drives import DriveJob, messages
from friction_fleet.simulation.town import Town
from friction_fleet.task import VEHICLE_ID
from friction_parameters.command_line import count, positive
from vehicle_models.vehicle_file import load_vehicle

_VEHICLE = "compact_car"


def add_arguments(parser: ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("--cars", type=count, default=20, help="unknown cars")
    parser.add_argument("--drives", type=count, default=50, help="drives of each")
    parser.add_argument("--seconds", type=positive, default=120.0, help="length of a drive [s]")
    parser.add_argument("--seed", type=int, default=0, help="same seed, same town, cars and drives")
    parser.add_argument("--jobs", type=count, default=cpu_count() or 1, help="processes at once")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="drives that are there stay")


def run(options: Namespace) -> int:
    """Make the drives that are not there yet, DIR/town.csv (truth) and DIR/fleet.json (options)."""
    out: Path = options.out
    out.mkdir(parents=True, exist_ok=True)
    Town(options.seed).write_truth(out / "town.csv")
    made_of = {name: getattr(options, name) for name in ("cars", "drives", "seconds", "seed")}
    (out / "fleet.json").write_text(json.dumps(made_of) + "\n", encoding="utf-8")
    jobs = [
        DriveJob(car, number, options.seed, options.seconds)
        for number in range(options.drives)  # the first of every car first: what is there early is of all cars
        for car in range(options.cars)
    ]
    missing = [job for job in jobs if not (out / job.name).exists()]
    pool = ProcessPoolExecutor(options.jobs, mp_context=get_context("spawn"))
    with pool, bars([f"{len(missing)} drives"]) as show:
        for done, future in enumerate(as_completed([pool.submit(make, out, job) for job in missing])):
            future.result()
            show(0, (done + 1) / len(missing))
    print(f"{out}: {len(missing)} drives made, {len(jobs) - len(missing)} were there")
    return 0


def make(out: Path, job: DriveJob) -> None:
    """Write the bag of a drive; it appears under its name when it is complete.

    Raises:
        BagError: it cannot be written.
    """
    part = out / f".{job.name}" / job.name
    rmtree(part.parent, ignore_errors=True)
    notes = {VEHICLE_NOTE: _VEHICLE, VEHICLE_ID: f"car{job.car:03d}"}
    write_bag(part, messages(job, load_vehicle(_VEHICLE)), notes)
    part.rename(out / job.name)
    part.parent.rmdir()
