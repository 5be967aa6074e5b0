"""`map`: the friction of every cell that a fleet has driven through, at a time."""

from __future__ import annotations

import json
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from datetime import datetime, timezone
from pathlib import Path

from friction_fleet.dataset import Dataset
from friction_fleet.evidence import read_evidence
from friction_fleet.export import geojson, page, write_parquet, zones
from friction_fleet.fusion import CHANGE_TIME, FrictionMap
from friction_parameters.command_line import UserError, positive


def add_arguments(parser: ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("dataset", metavar="URL", help="directory of the tables")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="for map.parquet, map.geojson, map.html")
    parser.add_argument(
        "--at", type=time_of, metavar="TIME", help="ISO 8601, UTC where it names no zone (default: last evidence)"
    )
    parser.add_argument(
        "--change-time",
        type=positive,
        default=CHANGE_TIME,
        metavar="H",
        help="mean time between changes of a road, and of the weather [h]",
    )


def run(options: Namespace) -> int:
    """Make the map; return 0.

    Raises:
        UserError: the tables have no evidence with a place, before the time.
    """
    evidence = read_evidence(Dataset(options.dataset))
    if options.at is not None:
        evidence = [each for each in evidence if each.stamp <= options.at]
    if not evidence:
        raise UserError(f"{options.dataset} has no evidence with a place: bags need a topic of sensor_msgs/NavSatFix")
    stamp = evidence[-1].stamp if options.at is None else options.at
    road = FrictionMap(options.change_time)
    road.update_all(evidence)
    cells = list(road.at(stamp).values())
    options.out.mkdir(parents=True, exist_ok=True)
    write_parquet(options.out / "map.parquet", cells, stamp)
    (options.out / "map.geojson").write_text(json.dumps(geojson(cells, stamp)) + "\n", encoding="utf-8")
    (options.out / "map.html").write_text(page(cells, stamp), encoding="utf-8")
    print(f"{len(cells)} cells, {len(zones(cells))} slippery zones, {len(evidence)} pieces of evidence")
    print(f"page  {options.out / 'map.html'}")
    return 0


def time_of(text: str) -> float:
    """Return a time of the command line [s since 1970]."""
    try:
        read = datetime.fromisoformat(text.replace("Z", "+00:00"))
    except ValueError:
        raise ArgumentTypeError(f"{text} is no time such as 2026-01-15T08:00") from None
    return (read if read.tzinfo else read.replace(tzinfo=timezone.utc)).timestamp()
