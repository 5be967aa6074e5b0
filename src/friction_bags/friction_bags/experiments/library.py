"""`library`: makes the recorded experiments of bags/ from fixed seeds."""

import shutil
from argparse import ArgumentParser, Namespace
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import Progress

from corner_sim.parameters import SimParameters
from corner_sim.ros.simulation import Simulation
from friction_bags.bag_io.bag_format import METADATA_NAME, BagError
from friction_bags.bag_io.bag_writer import write_bag
from friction_bags.bag_vehicle import VEHICLE_NOTE
from friction_bags.experiments import stops, tyre_runs
from friction_bags.offline.estimators import WHEEL_ESTIMATORS, closed_loop_parameters, make_processors
from friction_parameters.parameter import from_mapping
from friction_runtime.processor import Output, ProcessorGraph, silent
from vehicle_models.vehicle_file import load_vehicle

START_STAMP = 1_000_000_000_000
"""Stamp of the first sample of every experiment [ns]: 1000 s."""
_README = "README.md"
_README_BEGIN = """\
# bags

Recorded experiments. `make bags` (`python3 -m friction_bags library`) makes them from fixed seeds and writes this file.
`python3 -m friction_bags play bags/NAME` and `ros2 bag play bags/NAME` play them; `make demo BAG=bags/NAME` runs the
graph on them. Recording stamps equal header stamps; the experiments begin at 1000 s. Sensor noise is that of section
8.3.2. `truth/...` holds the true values of the plant. The car is a shipped vehicle file; its name is a note in the bag,
which `python3 -m friction_bags process` reads.

| bag | car | what it is |
|---|---|---|
"""
_README_END = """

The smart-tyre bags in the repository are excerpts, too short for smart_tyre_forces to learn the teeth of the encoder
(32 revolutions). `python3 -m friction_bags library --full --out DIR` makes whole runs. The measured bags are not in the
repository: `python3 -m friction_bags import bmw|iac FILE.csv --out DIR`.

On the same machine every file is reproduced byte for byte. On another kind of processor the last bits of messages
differ, because numpy sums in another order and uses other instructions for exponentials.
"""


@dataclass(frozen=True)
class Experiment:
    """A run of corner_sim."""

    note: str
    """Description of the experiment."""
    parameters: Mapping[str, Any] = field(default_factory=dict)
    """Parameters of corner_sim that override its defaults."""
    vehicle: str = "chapter_corner"
    """Vehicle file of the car, or name of a shipped one."""
    closed_loop: bool = False
    """Whether all that the supervisor takes and the supervisor itself are in the loop, and recorded."""


def _ramp_and_hold(surface: str, torque: float) -> Experiment:
    return Experiment(
        f"{surface}: torque ramp over 0.25 s to {torque:.0f} N m, held for 0.3 s, released; one corner, open loop",
        {
            "surfaces": [surface],
            "demand_unit": "torque",
            "demand_level": torque,
            "demand_rise": 0.25,
            "demand_hold": 0.3,
            "end_time": 2.0,
        },
    )


EXPERIMENTS: dict[str, Experiment] = {
    "dry": _ramp_and_hold("dry", 857.0),
    "wet": _ramp_and_hold("wet", 598.0),
    "cobblestone": _ramp_and_hold("cobblestone", 805.0),
    "snow": _ramp_and_hold("snow", 153.0),
    "dry_to_snow": Experiment(
        "dry, from 40 m on snow: panic braking with the supervisor in the loop, 30 to 20 m/s; one corner",
        {"surfaces": ["dry", "snow"], "surface_distances": [0.0, 40.0], "end_speed": 20.0, "end_time": 6.0},
        closed_loop=True,
    ),
    "abs_stop": Experiment(
        "dry: panic braking with the supervisor in the loop, 30 to 5 m/s; one corner",
        {"surfaces": ["dry"], "end_speed": 5.0, "end_time": 8.0},
        closed_loop=True,
    ),
}


_NAMES = (*EXPERIMENTS, *stops.STOPS, *tyre_runs.RUNS)


def add_arguments(parser: ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("--out", type=Path, default=Path("bags"), metavar="DIR", help="where (default: bags)")
    parser.add_argument("--full", action="store_true", help="the smart-tyre runs at full length instead of short cuts")
    parser.add_argument("names", nargs="*", metavar="NAME", help="only these")


def run(args: Namespace) -> int:
    """Make the bags; those of the same name are replaced.

    Returns:
        Exit code: 0.

    Raises:
        BagError: there is no such experiment, or a bag cannot be made.
        OSError: a file cannot be written.
    """
    known = _NAMES
    unknown = [name for name in args.names if name not in known]
    if unknown:
        raise BagError(f"no experiment {', '.join(unknown)}; there are {', '.join(known)}")
    with Progress(console=Console(stderr=True), transient=True) as progress:
        for name in progress.track(args.names or known, description="bags"):
            _replace(args.out / name)
            notes = {
                "note": _note(name, args.full),
                "made_by": f"python3 -m friction_bags library {name}",
                VEHICLE_NOTE: _vehicle(name),
            }
            count = write_bag(args.out / name, _messages(name, args.full), notes)
            print(f"{args.out / name}: {count} messages", flush=True)
    if not args.names:
        (args.out / _README).write_text(_readme(args.full), encoding="utf-8")
    return 0


def simulate(experiment: Experiment, seed: int = 0) -> Iterator[Output]:
    """Yield absolute topics and messages of a run, those of the plant and of the estimators in its loop."""
    vehicle = load_vehicle(experiment.vehicle)
    simulation = Simulation(from_mapping(SimParameters, {**experiment.parameters, "seed": seed}), vehicle, START_STAMP)
    estimators = closed_loop_parameters(WHEEL_ESTIMATORS) if experiment.closed_loop else {}
    graph = ProcessorGraph(make_processors(estimators, vehicle, silent))
    while True:
        for topic, message in simulation.messages():
            yield f"/{topic}", message
            for made, answer in graph.feed(topic, message):
                yield f"/{made}", answer
                if made.endswith("/brake_command"):
                    simulation.take_command(answer.wheel, answer)
        if simulation.end is not None:
            return
        simulation.advance()


def _messages(name: str, full: bool) -> Iterator[Output]:
    if name in EXPERIMENTS:
        return simulate(EXPERIMENTS[name])
    if name in stops.STOPS:
        return stops.simulate(stops.STOPS[name], START_STAMP)
    return tyre_runs.simulate(tyre_runs.RUNS[name], START_STAMP, full)


def _note(name: str, full: bool) -> str:
    if name in EXPERIMENTS:
        return EXPERIMENTS[name].note
    if name in stops.STOPS:
        return stops.STOPS[name].note
    tyre_run = tyre_runs.RUNS[name]
    return tyre_run.note if full else f"{tyre_run.note}; {tyre_run.cut[0]:.1f} to {tyre_run.cut[1]:.1f} s of it"


def _vehicle(name: str) -> str:
    if name in EXPERIMENTS:
        return EXPERIMENTS[name].vehicle
    return stops.VEHICLE if name in stops.STOPS else tyre_runs.VEHICLE


def _replace(bag: Path) -> None:
    """Remove a bag that will be replaced, and nothing else."""
    if (bag / METADATA_NAME).is_file():
        shutil.rmtree(bag)
    bag.parent.mkdir(parents=True, exist_ok=True)


def _readme(full: bool) -> str:
    """Text of the list of bags."""
    rows = [f"| `{name}` | `{_vehicle(name)}` | {_note(name, full)} |" for name in _NAMES]
    return _README_BEGIN + "\n".join(rows) + _README_END
