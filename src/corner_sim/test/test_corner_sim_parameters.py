"""The shipped parameter file and the refusals."""

from pathlib import Path

import pytest

from corner_sim.parameters import SimParameters
from corner_sim.simulation import Simulation
from friction_runtime.parameters import ParameterError, from_mapping, load

FILE = Path(__file__).parents[1] / "config" / "corner_sim.yaml"


def test_the_shipped_file_holds_every_parameter_at_its_default() -> None:
    assert load(SimParameters, FILE, "corner_sim") == SimParameters()
    text = FILE.read_text(encoding="utf-8")
    assert all(f"    {name}: " in text for name in SimParameters.__dataclass_fields__)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("wheels", []),
        ("wheels", ["front_left", "front_left"]),
        ("wheels", [""]),
        ("model", "bicycle"),
        ("radius", 0.0),
        ("inertia", float("nan")),
        ("mass", -1.0),
        ("initial_speed", float("inf")),
        ("surfaces", ["ice"]),
        ("surface_distances", [-1.0]),
        ("surface_distances", [0.0, 40.0]),
        ("demand_source", "nobody"),
        ("demand_level", -0.1),
        ("brake_gain", [0.0]),
        ("brake_gain", [1e-4, 1e-4]),
        ("actuator_delay", -0.01),
        ("apply_rate", 0.0),
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
        Simulation(from_mapping(SimParameters, {name: value}), 1)


def test_an_unknown_parameter_is_refused_by_name() -> None:
    with pytest.raises(ParameterError, match="surfcae"):
        from_mapping(SimParameters, {"surfcae": "dry"})
