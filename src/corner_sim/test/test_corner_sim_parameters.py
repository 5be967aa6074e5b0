"""The shipped parameter file and the refusals."""

from pathlib import Path

import pytest

from corner_sim.parameters import SHIPPED, SimParameters
from corner_sim.ros.simulation import Simulation
from friction_parameters.generated import parameter_file
from friction_parameters.parameter import ParameterError, from_mapping
from friction_parameters.parameter_file import load
from vehicle_models.vehicle_file import load_vehicle

FILE = Path(__file__).parents[1] / "config" / "corner_sim.yaml"


def test_the_shipped_file_holds_every_parameter_at_its_default() -> None:
    assert load(SimParameters, FILE, "corner_sim") == SimParameters()
    assert FILE.read_text(encoding="utf-8") == parameter_file("corner_sim", SHIPPED["corner_sim"])


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("model", "bicycle"),
        ("initial_speed", float("inf")),
        ("surfaces", ["ice"]),
        ("surface_distances", [-1.0]),
        ("surface_distances", [0.0, 40.0]),
        ("demand_source", "nobody"),
        ("demand_level", -0.1),
        ("actuator.delay", -0.01),
        ("actuator.apply_rate", 0.0),
        ("actuator.release_rate", float("nan")),
        ("acceleration_variance", -1.0),
        ("noise", "loud"),
        ("seed", -1),
        ("seed", 1.5),
        ("real_time_factor", 0.0),
        ("real_time_factor", float("nan")),
        ("lock_step_timeout", 0.0),
    ],
)
def test_a_bad_value_is_refused_by_the_name_of_its_parameter(name: str, value: object) -> None:
    with pytest.raises(ValueError, match=name):
        Simulation(from_mapping(SimParameters, {name: value}), load_vehicle("chapter_corner"), 1)


def test_an_unknown_parameter_is_refused_by_name() -> None:
    with pytest.raises(ParameterError, match="surfcae"):
        from_mapping(SimParameters, {"surfcae": "dry"})
