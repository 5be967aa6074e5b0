"""The option of a command that gives the car."""

from argparse import ArgumentParser

from vehicle_models.vehicle_file import vehicle_choices


def add_vehicle_argument(parser: ArgumentParser, otherwise: str) -> None:
    """Add `--vehicle`, empty by default; `otherwise` names the car that holds without it."""
    text = f"the car: {vehicle_choices()} (default: {otherwise})"
    parser.add_argument("--vehicle", default="", metavar="NAME|FILE", help=text)
