"""Parameters: typed, ranged, nested, refused by name."""

from array import array
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from friction_parameters.parameter import (
    ParameterError,
    changed,
    constant,
    constants,
    declared,
    flattened,
    from_mapping,
    group,
    ignored,
    parameter,
    values_of,
)


@dataclass(frozen=True)
class WindowParameters:
    length: int = parameter(6, "samples", minimum=3, maximum=400)
    lead: float = parameter(0.5, "lead", minimum=0.0)

    def __post_init__(self) -> None:
        if self.lead > self.length:
            raise ValueError(f"'lead' = {self.lead} is longer than 'length' = {self.length}")


@dataclass(frozen=True)
class DetectorParameters:
    window: WindowParameters = group(WindowParameters())
    threshold: float = parameter(-1.0, "threshold", unit="rad/s^3", maximum=0.0)


@dataclass(frozen=True)
class NoSlipParameters:
    eta_margin: float = parameter(0.3, "margin")
    wait: bool = parameter(True, "wait")


@dataclass(frozen=True)
class Tuning:
    memory: float = constant(15.0, "way for which a release is remembered", unit="m")


@dataclass(frozen=True)
class TunedParameters:
    wait: float = parameter(0.1, "wait", minimum=0.0)
    longest: float = constant(0.3, "longest release", unit="s")
    tuning: Tuning = constants(Tuning())


@dataclass(frozen=True)
class ExampleParameters:
    surfaces: tuple[str, ...] = parameter(("dry",), "names", choices=("dry", "wet", "snow"))
    radius: tuple[float, ...] = parameter((0.3,), "radius", unit="m", minimum=0.05, maximum=2.0)
    deadline: float = parameter(0.05, "deadline", unit="s", minimum=0.0, maximum=1.0)
    method: str = parameter("slip", "method", choices=("slip", "no_slip", "both", "all"))
    shadow: bool = parameter(True, "shadow", read_only=True)
    detector: DetectorParameters = group(DetectorParameters(threshold=-2.0))
    no_slip: NoSlipParameters = group(NoSlipParameters(), selector="method", methods=("no_slip", "both", "all"))

    def __post_init__(self) -> None:
        if len(self.surfaces) > len(self.radius):
            raise ValueError("more 'surfaces' than values of 'radius'")


def test_constants_are_no_parameters_and_stay_when_parameters_change() -> None:
    assert values_of(TunedParameters()) == {"wait": 0.1}
    tuned = replace(TunedParameters(), longest=0.2, tuning=Tuning(memory=10.0))
    assert changed(tuned, {"wait": 0.4}) == TunedParameters(0.4, 0.2, Tuning(10.0))
    for name in ("longest", "tuning.memory", "tuning"):
        with pytest.raises(ParameterError, match=f"^unknown parameter '{name}': known are wait$"):
            from_mapping(TunedParameters, {name: 1.0})


def test_names_of_nested_parameters_are_dotted_and_defaults_are_those_of_the_group() -> None:
    known = declared(ExampleParameters)
    assert list(known) == [
        *("surfaces", "radius", "deadline", "method", "shadow"),
        *("detector.window.length", "detector.window.lead", "detector.threshold"),
        *("no_slip.eta_margin", "no_slip.wait"),
    ]
    assert known["detector.threshold"].default == -2.0
    assert known["detector.window.length"].hint is int
    assert known["detector.threshold"].limits["unit"] == "rad/s^3"
    assert known["no_slip.wait"].only == "only with method no_slip, both or all"
    assert not known["detector.threshold"].only
    assert values_of(ExampleParameters()) == {name: each.default for name, each in known.items()}


def test_values_are_converted_and_the_rest_keeps_its_default() -> None:
    made = from_mapping(ExampleParameters, {"radius": [0.3, 1], "deadline": 0, "detector": {"threshold": -3}})
    assert made == from_mapping(ExampleParameters, {"radius": (0.3, 1), "deadline": 0, "detector.threshold": -3})
    assert made.radius == (0.3, 1.0)
    assert made.deadline == 0.0
    assert [type(each) for each in (*made.radius, made.deadline, made.detector.threshold)] == [float] * 4
    assert made.method == "slip"
    assert made.detector.window == WindowParameters()


@pytest.mark.parametrize(
    "values", [array("d", [0.3, 1.0]), np.array([0.3, 1.0]), (0.3, np.float64(1.0)), [0.3, np.int64(1)]]
)
def test_arrays_and_numbers_of_numpy_are_taken(values: Any) -> None:
    made = from_mapping(ExampleParameters, {"radius": values, "detector.window.length": np.int32(7)})
    assert made.radius == (0.3, 1.0)
    assert [type(each) for each in made.radius] == [float, float]
    assert made.detector.window.length == 7


def test_a_change_of_several_values_is_made_at_once_and_leaves_the_others() -> None:
    before = from_mapping(ExampleParameters, {"deadline": 0.2})
    after = changed(before, {"detector.window.length": 3, "detector.window.lead": 2, "method": "both"})
    assert after.detector.window == WindowParameters(3, 2.0)
    assert (after.deadline, after.method, after.detector.threshold) == (0.2, "both", -2.0)
    assert before.detector.window == WindowParameters()


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({"radius": [0.3, -1.0]}, "parameter 'radius' = -1.0 m is outside [0.05, 2.0]"),
        ({"radius": 0.3}, "parameter 'radius' = 0.3 must be a list"),
        ({"radius": []}, "parameter 'radius' is empty"),
        ({"radius": [True]}, "parameter 'radius' = True must be of type float"),
        ({"radius": [[0.3]]}, "parameter 'radius' = [0.3] must be of type float"),
        ({"deadline": float("nan")}, "parameter 'deadline' = nan s is outside [0.0, 1.0]"),
        ({"deadline": "soon"}, "parameter 'deadline' = 'soon' must be of type float"),
        ({"deadline": None}, "parameter 'deadline' = None must be of type float"),
        ({"deadline": 10**400}, "parameter 'deadline' is too large a number"),
        ({"detector.window.length": 2.5}, "parameter 'detector.window.length' = 2.5 must be of type int"),
        ({"detector.window.length": True}, "parameter 'detector.window.length' = True must be of type int"),
        ({"detector.window.length": 2}, "parameter 'detector.window.length' = 2 is outside [3, 400]"),
        ({"detector.window.lead": -1}, "parameter 'detector.window.lead' = -1.0 is outside [0.0, inf]"),
        ({"detector.threshold": 1}, "parameter 'detector.threshold' = 1.0 rad/s^3 is outside [-inf, 0.0]"),
        ({"no_slip.eta_margin": float("inf")}, "parameter 'no_slip.eta_margin' = inf is not a finite number"),
        ({"no_slip.eta_margin": float("nan")}, "parameter 'no_slip.eta_margin' = nan is not a finite number"),
        ({"shadow": 1}, "parameter 'shadow' = 1 must be of type bool"),
        ({"method": "guess"}, "parameter 'method' = 'guess' must be one of slip, no_slip, both, all"),
        ({"surfaces": ["ice"]}, "parameter 'surfaces' = 'ice' must be one of dry, wet, snow"),
        ({"surfaces": "dry"}, "parameter 'surfaces' = 'dry' must be a list"),
        ({"detector": 5}, "unknown parameter 'detector'"),
        ({"method": {"slip": 1}}, "unknown parameter 'method.slip'"),
        ({"a\nb": 5}, "unknown parameter 'a b'"),
    ],
)
def test_bad_value_is_refused_in_one_line_with_the_name_of_the_parameter(values: dict[str, Any], text: str) -> None:
    with pytest.raises(ParameterError) as caught:
        from_mapping(ExampleParameters, values)
    assert str(caught.value).startswith(text)
    assert "\n" not in str(caught.value)


def test_an_unknown_name_is_refused_with_those_there_are() -> None:
    with pytest.raises(
        ParameterError, match=r"unknown parameter 'detector.windw': known are surfaces, .*no_slip.wait$"
    ):
        from_mapping(ExampleParameters, {"detector.windw": 5})


def test_a_name_that_lacks_its_groups_is_refused_with_the_whole_name() -> None:
    with pytest.raises(ParameterError, match=r"^unknown parameter 'wait', perhaps .*no_slip\.wait: known are "):
        from_mapping(ExampleParameters, {"wait": 0.1})


def test_a_combination_is_refused_by_the_group_that_minds_it() -> None:
    with pytest.raises(ParameterError, match=r"^detector.window: 'lead' = 7.0 is longer than 'length' = 6$"):
        from_mapping(ExampleParameters, {"detector.window.lead": 7})
    with pytest.raises(ParameterError, match=r"^more 'surfaces' than values of 'radius'$"):
        from_mapping(ExampleParameters, {"surfaces": ["dry", "wet"]})


def test_what_is_set_for_another_method_is_named_in_one_line() -> None:
    values = {"no_slip.eta_margin": 0.1, "no_slip.wait": False}
    (line,) = ignored(from_mapping(ExampleParameters, values))
    assert line == "no_slip.eta_margin, no_slip.wait: ignored, as 'method' is 'slip', not no_slip, both or all"
    assert not ignored(from_mapping(ExampleParameters, {**values, "method": "both"}))
    assert not ignored(ExampleParameters())


def test_a_field_that_is_no_parameter_is_an_error_of_the_program() -> None:
    @dataclass(frozen=True)
    class Plain:
        length: int = 3

    with pytest.raises(TypeError, match=r"Plain.length is not a parameter"):
        declared(Plain)


def test_a_mapping_is_flattened_to_dotted_names() -> None:
    assert flattened({"a": 1, "b": {"c": 2, "d": {"e": 3}}}) == {"a": 1, "b.c": 2, "b.d.e": 3}
