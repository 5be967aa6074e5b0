"""Parameters: typed, ranged, refused by name."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from friction_runtime.parameters import ParameterError, check_wheels, from_mapping, load, parameter, per_wheel


@dataclass(frozen=True)
class ExampleParameters:
    wheels: tuple[str, ...] = parameter(("front_left",), "names", read_only=True)
    radius: tuple[float, ...] = parameter((0.3,), "radius", unit="m", minimum=0.05, maximum=2.0)
    deadline: float = parameter(0.05, "deadline", unit="s", minimum=0.0, maximum=1.0)
    method: str = parameter("slip", "method", choices=("slip", "no_slip"))
    samples: int = parameter(5, "samples", minimum=2, maximum=99)

    def __post_init__(self) -> None:
        if not self.wheels:
            raise ValueError("parameter 'wheels' is empty")


def test_values_are_converted_and_the_rest_keeps_its_default() -> None:
    made = from_mapping(ExampleParameters, {"radius": [0.3, 1], "deadline": 0})
    assert made.radius == (0.3, 1.0)
    assert made.deadline == 0.0
    assert made.method == "slip"


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({"radius": [0.3, -1.0]}, r"parameter 'radius' = -1.0 m is outside \[0.05, 2.0\]"),
        ({"deadline": float("nan")}, "parameter 'deadline'"),
        ({"deadline": "soon"}, "parameter 'deadline' = 'soon' must be of type float"),
        ({"samples": 2.5}, "parameter 'samples' = 2.5 must be of type int"),
        ({"samples": True}, "must be of type int"),
        ({"method": "guess"}, "parameter 'method' = 'guess' must be one of slip, no_slip"),
        ({"wheels": "front_left"}, "must be a list"),
        ({"wheels": []}, "parameter 'wheels' is empty"),
        ({"radios": 0.3}, "unknown parameter 'radios'"),
    ],
)
def test_bad_value_is_refused_with_the_name_of_the_parameter(values: dict[str, Any], text: str) -> None:
    with pytest.raises(ParameterError, match=text):
        from_mapping(ExampleParameters, values)


@pytest.mark.parametrize("section", ["example", "/example", "/**/example"])
def test_file_section_of_the_node_overrides_the_general_one(tmp_path: Path, section: str) -> None:
    file = tmp_path / "p.yaml"
    file.write_text(
        "/**:\n  ros__parameters: {deadline: 0.1, samples: 7, use_sim_time: true}\n"
        f"{section}:\n  ros__parameters: {{deadline: 0.2}}\n",
        encoding="utf-8",
    )
    made = load(ExampleParameters, file, "example")
    assert (made.deadline, made.samples) == (0.2, 7)


def test_file_without_the_node_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "p.yaml"
    file.write_text("other:\n  ros__parameters: {deadline: 0.1}\n", encoding="utf-8")
    with pytest.raises(ParameterError, match="no section 'example'"):
        load(ExampleParameters, file, "example")


def test_one_value_serves_all_wheels_and_a_wrong_count_is_refused() -> None:
    assert per_wheel("k", (2.0,), ("a", "b")) == {"a": 2.0, "b": 2.0}
    assert per_wheel("k", (2.0, 3.0), ("a", "b")) == {"a": 2.0, "b": 3.0}
    with pytest.raises(ParameterError, match="parameter 'k' has 3 values for 2 wheels"):
        per_wheel("k", (1.0, 2.0, 3.0), ("a", "b"))


@pytest.mark.parametrize("wheels", [(), ("a", ""), ("a", "b", "a")])
def test_wheels_without_a_name_or_named_twice_are_refused(wheels: tuple[str, ...]) -> None:
    with pytest.raises(ParameterError, match=r"parameter 'wheels' = .* must name at least one wheel, each once"):
        check_wheels(wheels)
