"""A recorded stop in place of its plant."""

from dataclasses import fields

import numpy as np
import pytest

from corner_sim.models import build_model
from corner_sim.plant import Plant, PlantSample
from corner_sim.recorded_plant import RecordedPlant
from corner_sim.road import Road
from vehicle_models.brake_actuator import ActuatorParameters, Command
from vehicle_models.vehicle_file import load_vehicle

DEMAND = 4e6
FREE_ROLLING = 10
"""Samples before the driver brakes."""
LENGTH = 120


def plant() -> Plant:
    vehicle = load_vehicle("chapter_corner")
    return Plant(build_model("single_corner", vehicle, 30.0), Road(("dry",), (0.0,)), ActuatorParameters(), vehicle)


def drive(through: Plant | RecordedPlant, commands: list[Command]) -> list[PlantSample]:
    samples = [through.sample()]
    for number, command in enumerate(commands):
        through.advance(DEMAND if number >= FREE_ROLLING else 0.0, [int(command)])
        samples.append(through.sample())
    return samples


def assert_same(found: list[PlantSample], expected: list[PlantSample]) -> None:
    for one, other in zip(found, expected, strict=True):
        for each in fields(PlantSample):
            np.testing.assert_array_equal(getattr(one, each.name), getattr(other, each.name), each.name)


@pytest.fixture
def recorded() -> list[PlantSample]:
    return drive(plant(), [Command.NONE] * LENGTH)


@pytest.mark.parametrize("command", [Command.HOLD, Command.DECREASE])
@pytest.mark.parametrize("sample", [0, 15, 80])
def test_a_command_that_changes_the_pressure_goes_on_with_the_plant_where_the_record_was_left(
    recorded: list[PlantSample], command: Command, sample: int
) -> None:
    """At 15 the pressure still rises, and a command is under way for two samples."""
    commands = [Command.INCREASE] * sample + [command] * 10 + [Command.INCREASE] * (LENGTH - sample - 10)
    assert_same(drive(RecordedPlant(plant(), recorded), commands), drive(plant(), commands))


def test_a_stop_that_only_the_driver_brakes_does_not_need_its_plant(
    recorded: list[PlantSample], monkeypatch: pytest.MonkeyPatch
) -> None:
    commands = [Command.NONE, Command.INCREASE] * (LENGTH // 2)
    expected = drive(plant(), commands)
    monkeypatch.delattr(Plant, "advance")
    assert_same(drive(RecordedPlant(plant(), recorded), commands), expected)


def test_a_record_that_ends_goes_on_with_the_plant(recorded: list[PlantSample]) -> None:
    commands = [Command.NONE] * LENGTH
    assert_same(drive(RecordedPlant(plant(), recorded[:40]), commands), recorded)
