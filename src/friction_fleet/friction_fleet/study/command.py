"""`study`: judges a map against the truth of a generated town, and the engine by its throughput and under kills."""

from __future__ import annotations

import json
from argparse import ArgumentParser, Namespace
from pathlib import Path

from rich.console import Console
from rich.table import Table

from friction_fleet.dataset import Dataset
from friction_fleet.evidence import read_evidence
from friction_fleet.simulation.town import Town
from friction_fleet.study.drawn_evidence import VALID, drawn_evidence
from friction_fleet.study.engine_study import measure_engine
from friction_fleet.study.kill_study import measure_kills
from friction_fleet.study.map_study import judge
from friction_fleet.study.town_truth import read_truth
from friction_parameters.command_line import UserError, count, not_negative, positive

_SECONDS = 120.0


def add_arguments(parser: ArgumentParser) -> None:
    """Describe the command line."""
    text = "tables; drawn evidence; bags a second; tables with and without killed workers"
    parser.add_argument("what", choices=["map", "drawn-map", "engine", "kills"], help=text)
    parser.add_argument("--dataset", metavar="URL", help="map: tables of the bags of `simulate`")
    parser.add_argument("--truth", type=Path, metavar="FILE", help="map: town.csv of `simulate`")
    parser.add_argument("--cars", type=count, default=20, help="drawn-map: cars")
    parser.add_argument("--drives", type=count, default=50, help="drawn-map: drives of each, of 2 minutes")
    parser.add_argument(
        "--valid", type=not_negative, default=VALID, help="drawn-map: share of passed peaks that are curves"
    )
    parser.add_argument(
        "--seed", type=int, default=0, help="drawn-map: same seed, same evidence; kills: of the victims"
    )
    parser.add_argument("--bags", metavar="GLOB", help="engine, kills: bags to process")
    parser.add_argument("--every", type=positive, default=30.0, metavar="S", help="kills: time between two of them")
    parser.add_argument("--rounds", type=count, default=2, help="engine: the best of them counts")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="for the rows as study.json")


def run(options: Namespace) -> int:
    """Run a study; return 0.

    Raises:
        UserError: options are missing, or there is no evidence.
    """
    options.out.mkdir(parents=True, exist_ok=True)
    rows = _measure(options) if options.what in ("engine", "kills") else _judge(options)
    (options.out / "study.json").write_text(json.dumps({"rows": rows}, indent=1) + "\n", encoding="utf-8")
    table = Table(*rows[0], box=None)
    for row in rows:
        table.add_row(*(each if isinstance(each, str) else f"{each:.4g}" for each in row.values()))
    Console(width=240).print(table)
    return 0


def _measure(options: Namespace) -> list[dict[str, str | float]]:
    if not options.bags:
        raise UserError(f"study {options.what} needs --bags")
    if options.what == "engine":
        return measure_engine(options.bags, options.out, options.rounds)
    return measure_kills(options.bags, options.out, options.every, options.seed)


def _judge(options: Namespace) -> list[dict[str, str | float]]:
    if options.what == "drawn-map":
        truth = options.out / "town.csv"
        Town(options.seed).write_truth(truth)
        evidence = drawn_evidence(options.seed, options.cars, options.drives, _SECONDS, options.valid)
    else:
        if not (options.dataset and options.truth):
            raise UserError("study map needs --dataset and --truth")
        truth, evidence = options.truth, read_evidence(Dataset(options.dataset))
    if not evidence:
        raise UserError("there is no evidence with a place")
    return judge(evidence, read_truth(truth))
