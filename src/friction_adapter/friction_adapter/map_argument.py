"""The option of a command that gives the signal map."""

from argparse import ArgumentParser

from friction_adapter.map_file import map_choices


def add_map_argument(parser: ArgumentParser) -> None:
    """Add `--map`, empty by default."""
    text = f"signal map of what is no topic of this graph: {map_choices()}"
    parser.add_argument("--map", default="", metavar="NAME|FILE", help=text)
