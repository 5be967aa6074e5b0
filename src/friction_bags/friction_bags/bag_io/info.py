"""`info`: what a bag holds."""

import json
from argparse import ArgumentParser, Namespace
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from friction_bags.bag_io.bag_format import Topic
from friction_bags.bag_io.bag_reader import BagReader
from friction_runtime.installed import UnknownTypeError, message_class

_NANOSECONDS = 1_000_000_000
"""Nanoseconds in a second; repeated here, as reading bags imports nothing of the graph."""
_WIDTH = 160
"""Width of the output where it does not go to a terminal."""


def add_arguments(parser: ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("bag", type=Path, help="directory of a bag, or an .mcap or .db3 file")
    parser.add_argument("--json", action="store_true", help="print JSON")


def run(args: Namespace) -> int:
    """Print what the bag holds.

    Returns:
        Exit code: 0, 1 when the bag is damaged.

    Raises:
        BagError: nothing can be read.
    """
    with BagReader(args.bag) as reader:
        found = describe(reader)
    if args.json:
        print(json.dumps(found, indent=1))
    else:
        _show(found)
    return 1 if found["problems"] else 0


def describe(reader: BagReader) -> dict[str, Any]:
    """Return the contents of a bag as plain data; times in seconds."""
    duration = (reader.end - reader.start) / _NANOSECONDS
    return {
        "bag": str(reader.bag),
        "storage": reader.storage,
        "start": reader.start / _NANOSECONDS,
        "duration": duration,
        "messages": reader.message_count,
        "topics": [_describe_topic(topic, count, duration) for topic, count in _by_name(reader)],
        "notes": reader.custom_data,
        "problems": reader.problems,
    }


def _by_name(reader: BagReader) -> list[tuple[Topic, int]]:
    return sorted(reader.counts.items(), key=lambda item: (item[0].name, item[0].type))


def _describe_topic(topic: Topic, count: int, duration: float) -> dict[str, Any]:
    try:
        message_class(topic.type)
        missing = ""
    except UnknownTypeError as error:
        missing = str(error)
    return {
        "name": topic.name,
        "type": topic.type,
        "messages": count,
        "rate": (count - 1) / duration if duration > 0.0 and count > 1 else 0.0,
        "reliability": ", ".join(sorted({qos.reliability.name.lower() for qos in topic.qos})),
        "definition": topic.definition_encoding,
        "not_installed": missing,
    }


def _show(found: dict[str, Any]) -> None:
    table = Table("topic", "type", "messages", "rate [1/s]", "reliability", "definition", "installed", box=None)
    for topic in found["topics"]:
        table.add_row(
            topic["name"],
            topic["type"],
            str(topic["messages"]),
            f"{topic['rate']:.1f}",
            topic["reliability"],
            topic["definition"] or "none",
            "no" if topic["not_installed"] else "yes",
        )
    console = Console()
    if not console.is_terminal:
        console.width = _WIDTH
    begun = datetime.fromtimestamp(found["start"], tz=timezone.utc)
    console.print(
        f"{found['bag']}: {found['storage']}, {found['messages']} messages, {found['duration']:.3f} s from "
        f"{begun:%Y-%m-%d %H:%M:%S} UTC",
        highlight=False,
    )
    console.print(table)
    for name, note in found["notes"].items():
        console.print(f"{name}: {note}", highlight=False)
    for problem in found["problems"]:
        console.print(f"damaged: {problem}", highlight=False)
