"""The option that gives the car is the same in every command."""

from argparse import ArgumentParser

import pytest

from friction_parameters.parameter import ParameterError
from vehicle_models.vehicle_file import add_vehicle_argument, shipped_vehicles, vehicle_choices, vehicle_path


def test_help_names_the_shipped_cars_and_the_one_without_the_option() -> None:
    parser = ArgumentParser()
    add_vehicle_argument(parser, "that of the bag")
    shown = " ".join(parser.format_help().split())
    assert "--vehicle NAME|FILE" in shown
    assert all(name in shown for name in shipped_vehicles())
    assert "(default: that of the bag)" in shown
    assert parser.parse_args([]).vehicle == ""


def test_help_and_refusal_name_the_choices_alike() -> None:
    with pytest.raises(ParameterError, match=r"'/elsewhere\.yaml': give ") as refused:
        vehicle_path("/elsewhere.yaml")
    assert str(refused.value).endswith(vehicle_choices())
