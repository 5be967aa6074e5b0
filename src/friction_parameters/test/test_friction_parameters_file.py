"""Parameter files: values for the node are read; entries that only look meant for it are errors of one line."""

import textwrap
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import example, given
from hypothesis import strategies as st

from friction_parameters.parameter import ParameterError, from_mapping, group, parameter
from friction_parameters.parameter_file import NodeName, file_values, is_ros_own, load


@dataclass(frozen=True)
class DetectorParameters:
    window: int = parameter(6, "samples", minimum=3, maximum=400)
    lead: float = parameter(2.85, "lead")


@dataclass(frozen=True)
class SlopeParameters:
    method: str = parameter("slip", "method", choices=("slip", "no_slip"))
    distances: tuple[float, ...] = parameter((0.0,), "distances", unit="m", minimum=0.0)
    shadow: bool = parameter(True, "shadow")
    detector: DetectorParameters = group(DetectorParameters())


NODE = NodeName("friction_slope")
IN_CAR = NodeName("friction_slope", "/my_car")
Read = Callable[..., dict[str, Any]]


@pytest.fixture
def read(tmp_path: Path) -> Read:
    def values(text: str, node: NodeName = NODE) -> dict[str, Any]:
        file = tmp_path / "p.yaml"
        file.write_text(textwrap.dedent(text), encoding="utf-8")
        return file_values(SlopeParameters, file, node)

    return values


def refused(read: Read, text: str, node: NodeName = NODE) -> str:
    """Message of the refusal, without the path."""
    with pytest.raises(ParameterError) as caught:
        read(text, node)
    message = str(caught.value)
    assert "\n" not in message
    path, _, rest = message.partition(": ")
    assert path.endswith("p.yaml")
    return rest


@pytest.mark.parametrize("section", ["friction_slope", "/friction_slope", "/**/friction_slope", "/**", "/*"])
def test_sections_of_the_node_and_of_every_node_are_taken(read: Read, section: str) -> None:
    assert read(f"{section}: {{ros__parameters: {{detector: {{window: 7}}}}}}") == {"detector.window": 7}


@pytest.mark.parametrize(
    "section",
    [
        *("/**/friction_slope", "/my_car/friction_slope", "my_car/friction_slope", "/*/friction_slope"),
        *("/my_car/**", "/my_car/*", "/**", "/my_car/**/friction_slope"),
    ],
)
def test_sections_are_matched_with_the_full_name_in_a_namespace(read: Read, section: str) -> None:
    assert read(f"{section}: {{ros__parameters: {{method: no_slip}}}}", IN_CAR) == {"method": "no_slip"}


@pytest.mark.parametrize("namespace", ["my_car", "/my_car", "/**"])
def test_namespaces_may_be_nested(read: Read, namespace: str) -> None:
    own, other = "friction_slope: {ros__parameters: {method: no_slip}}", "other: {ros__parameters: {a: 1}}"
    text = f"{namespace}: {{{own}, {other}}}"
    assert read(text, IN_CAR) == {"method": "no_slip"}


def test_dotted_and_nested_names_are_the_same(read: Read) -> None:
    assert read("friction_slope: {ros__parameters: {detector.window: 7, detector: {lead: 1}}}") == {
        "detector.window": 7,
        "detector.lead": 1.0,
    }


def test_a_later_section_decides_over_an_earlier_one(read: Read) -> None:
    general = "/**: {ros__parameters: {method: slip, shadow: false, use_sim_time: true, of_others: 5}}"
    own = "/**/friction_slope: {ros__parameters: {method: no_slip}}"
    full = "/friction_slope: {ros__parameters: {detector: {window: 9}, method: slip}}"
    assert read(f"{general}\n{own}") == {"method": "no_slip", "shadow": False, "use_sim_time": True}
    assert read(f"{own}\n{general}")["method"] == "slip"
    assert read(f"{own}\n{full}") == {"method": "slip", "detector.window": 9}
    assert read(f"{full}\n{own}") == {"method": "no_slip", "detector.window": 9}


def test_integers_in_a_list_of_floats_are_taken(read: Read) -> None:
    (found,) = read("friction_slope: {ros__parameters: {distances: [0, 40.5, 1e-4, 80]}}").values()
    assert found == (0.0, 40.5, 1e-4, 80.0)
    assert {type(each) for each in found} == {float}


@pytest.mark.parametrize(
    ("word", "value"), [("true", True), ("True", True), ("yes", True), ("off", False), ("NO", False)]
)
def test_words_for_true_and_false_are_those_of_ros(read: Read, word: str, value: bool) -> None:
    text = f"friction_slope: {{ros__parameters: {{shadow: {word}, use_sim_time: {word}}}}}"
    assert read(text) == {"shadow": value, "use_sim_time": value}


def test_a_quoted_word_is_a_text(read: Read) -> None:
    text = refused(read, "friction_slope: {ros__parameters: {shadow: 'true'}}")
    assert text == "line 1: parameter 'shadow' = 'true' must be of type bool"


def test_what_a_dump_holds_beside_the_parameters_of_the_node_is_kept_for_ros(read: Read) -> None:
    found = read("""
        /friction_slope:
          ros__parameters:
            method: slip
            qos_overrides:
              /parameter_events:
                publisher: {depth: 1000, durability: volatile, avoid_ros_namespace_conventions: false}
            start_type_description_service: true
            use_sim_time: false
        """)
    assert found == {
        "method": "slip",
        "qos_overrides./parameter_events.publisher.depth": 1000,
        "qos_overrides./parameter_events.publisher.durability": "volatile",
        "qos_overrides./parameter_events.publisher.avoid_ros_namespace_conventions": False,
        "start_type_description_service": True,
        "use_sim_time": False,
    }
    assert [name for name in found if not is_ros_own(name)] == ["method"]


@pytest.mark.parametrize(
    "text",
    [
        "use_sim_time: maybe",
        "use_sim_time: 1",
        "start_type_description_service: [true]",
        "qos_overrides: {/a: {publisher: {depth: [1, 2]}}}",
        "qos_overrides: {/a: {publisher: {depth: }}}",
    ],
)
def test_parameters_of_ros_with_a_value_that_ros_could_not_take_are_refused(read: Read, text: str) -> None:
    assert "has the wrong type" in refused(read, f"/**: {{ros__parameters: {{{text}}}}}")


def test_sections_of_other_nodes_are_ignored_whatever_they_hold(read: Read) -> None:
    found = read("""
        /**/wheel_slip:
          ros__parameters: {unknown: 1, window: 5}
        /**/corner_sim:
          ros__parameters: 5
        other: {ros__parameters: {method: [mixed, 1, {a: b}]}}
        my_car:
          friction_curve_id: {ros__parameters: {radii: [0.3]}}
          nothing: {}
        friction_slope_rear: {ros__parameters: {method: wrong}}
        friction_slope2: {ros__parameters: {method: wrong}}
        empty:
        number: 5
        friction_slope: {ros__parameters: {method: no_slip}}
        """)
    assert found == {"method": "no_slip"}


@pytest.mark.parametrize("text", ["", "# nothing\n", "/**:\n", "/**: {}\n", "friction_slope: {ros__parameters: }\n"])
def test_a_file_may_be_empty(read: Read, text: str) -> None:
    assert read(text) == {}


@pytest.mark.parametrize(
    ("text", "lines"),
    [
        (
            "friction_slope: {ros__parameters: {method: slip}}\nfriction_slope: {ros__parameters: {shadow: true}}",
            (2, 1),
        ),
        ("/**: {ros__parameters: {method: slip}}\n\n/**: {ros__parameters: {shadow: true}}", (3, 1)),
        ("friction_slope: {ros__parameters: {}}\n/friction_slope: {ros__parameters: {}}", (2, 1)),
        ("friction_slope:\n  ros__parameters: {}\n  ros__parameters: {}", (3, 2)),
        ("friction_slope:\n  ros__parameters:\n    method: slip\n    shadow: true\n    method: slip", (5, 3)),
        ("friction_slope:\n  ros__parameters:\n    detector:\n      window: 6\n      window: 7", (5, 4)),
        ("friction_slope:\n  ros__parameters:\n    detector: {window: 6}\n    detector: {lead: 1}", (4, 3)),
        ("friction_slope:\n  ros__parameters:\n    detector: {window: 6}\n    detector.window: 6", (4, 3)),
        ("/**:\n  ros__parameters: {a: 1,\n   a: 2}", (3, 2)),
        ("/**: {ros__parameters: {}}\n/**/friction_slope: {}\n/**/friction_slope: {ros__parameters: {}}", (3, 2)),
    ],
)
def test_a_key_that_stands_twice_is_refused_with_both_lines(read: Read, text: str, lines: tuple[int, int]) -> None:
    again, first = lines
    message = refused(read, text)
    assert message.startswith(f"line {again}: ")
    assert message.endswith(f"is repeated here, first in line {first}")


def test_a_namespace_that_stands_twice_is_refused(read: Read) -> None:
    text = "my_car: {friction_slope: {ros__parameters: {}}}\nmy_car: {other: {ros__parameters: {}}}"
    assert refused(read, text, IN_CAR) == "line 2: 'my_car' is repeated here, first in line 1"


@pytest.mark.parametrize(
    "name",
    [
        *("friction_slop", "friction_slopes", "frictionslope", "FrictionSlope", "friction-slope", "fricton_slope"),
        *("friction_slope_node", "frictoin_slope"),
    ],
)
@pytest.mark.parametrize("namespace", ["/**/", "/", "", "/my_car/"])
def test_a_section_whose_name_is_nearly_that_of_the_node_is_refused(read: Read, name: str, namespace: str) -> None:
    text = f"/**/friction_slope: {{ros__parameters: {{}}}}\n{namespace}{name}: {{ros__parameters: {{window: 5}}}}"
    message = refused(read, text)
    assert message.startswith("line 2: section '")
    assert message.endswith("is '/**/friction_slope' meant?")


def test_nodes_that_were_given_similar_names_may_stand_in_one_file(read: Read) -> None:
    text = "friction_slope_fl: {ros__parameters: {method: no_slip}}\nfriction_slope_fr: {ros__parameters: {}}"
    assert read(text, NodeName("friction_slope_fl", remapped=True)) == {"method": "no_slip"}
    left_out = NodeName("friction_slope_rl", remapped=True)
    assert "is '/**/friction_slope_rl' meant?" in refused(read, text, left_out)


def test_names_of_the_nodes_of_the_graph_are_not_alike() -> None:
    from friction_parameters.parameter_file import _is_misspelt

    names = ["wheel_slip", "friction_slope", "friction_curve_id", "abs_supervisor", "smart_tyre_forces"]
    names += ["friction_grip", "friction_state", "corner_sim"]
    assert not [(one, other) for one in names for other in names if one != other and _is_misspelt(one, other)]


@pytest.mark.parametrize(
    "section", ["friction_slope", "/friction_slope", "/your_car/friction_slope", "/*/*/friction_slope"]
)
def test_a_section_that_does_not_match_the_full_name_is_refused(read: Read, section: str) -> None:
    message = refused(read, f"\n{section}: {{ros__parameters: {{}}}}", IN_CAR)
    assert message == (
        f"line 2: section '/{section.strip('/')}' is not for the node /my_car/friction_slope: "
        "name it '/**/friction_slope' or '/my_car/friction_slope'"
    )


def test_a_full_name_is_refused_outside_its_namespace(read: Read) -> None:
    assert "is not for the node /friction_slope" in refused(read, "my_car: {friction_slope: {ros__parameters: {}}}")


def test_an_unknown_parameter_is_refused_in_a_section_of_the_node_only(read: Read) -> None:
    message = refused(read, "friction_slope:\n  ros__parameters:\n    detector: {windw: 6}")
    assert message.startswith("line 3: unknown parameter 'detector.windw': known are method, ")
    assert read("/**: {ros__parameters: {windw: 6}}") == {}


@pytest.mark.parametrize("section", ["/**/friction_slope", "/**"])
def test_a_bad_value_is_refused_with_its_line(read: Read, section: str) -> None:
    message = refused(read, f"{section}:\n  ros__parameters:\n    detector:\n      window: 2")
    assert message == "line 4: parameter 'detector.window' = 2 is outside [3, 400]"


@pytest.mark.parametrize(
    "text",
    [
        *("friction_slope:", "friction_slope: 5", "friction_slope: {}", "friction_slope: {method: slip}"),
        *("friction_slope: {detector: {window: 6}}", "/**: {method: slip}", "/**: {detector: {window: 6}}"),
        *("friction_slope: {ros_parameters: {method: slip}}", "friction_slope: {ros__parameters: {}, method: slip}"),
        *("friction_slope: {ros__parameters: 5}", "friction_slope: {ros__parameters: [1]}"),
    ],
)
def test_a_section_without_ros_parameters_is_refused(read: Read, text: str) -> None:
    assert "ros__parameters' " in refused(read, text)


def test_a_list_is_read_as_launch_ros_writes_it(tmp_path: Path) -> None:
    path = tmp_path / "launch_params_x"
    path.write_text(yaml.dump({"/**": {"ros__parameters": {"distances": (0.0, 40.0)}}}))
    assert "!!python/tuple" in path.read_text()
    assert file_values(SlopeParameters, path, NODE) == {"distances": (0.0, 40.0)}


def test_parameters_below_no_name_are_refused(read: Read) -> None:
    assert refused(read, "ros__parameters: {method: slip}").startswith("line 1: 'ros__parameters' stands below no name")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[1, 2]", "line 1: a mapping is expected"),
        ("friction_slope: [", "line 1: not YAML: "),
        ("a: 1\nb: {c: 2", "line 2: not YAML: "),
        ("a: &here 1\nb: *here", "line 2: not YAML: aliases are not supported"),
        ("a: &here {b: *here}", "line 1: not YAML: aliases are not supported"),
        (
            "a: !!python/object:os.system {}",
            "line 1: the tag 'tag:yaml.org,2002:python/object:os.system' is not supported",
        ),
        ("a: !mine 5", "line 1: the tag '!mine' is not supported"),
        ("? [a, b]\n: 5", "line 1: a key must be a text"),
        ("--- {}\n--- {}", "line 2: not YAML: but found another document"),
        ("a: \x01", "not YAML: "),
        ("a: " + "[" * 50 + "]" * 50, "line 1: nested too deep"),
        ("a: " + "{b: " * 50 + "1" + "}" * 50, "line 1: nested too deep"),
        ("a: " + "[" * 5000, "nested too deep"),
    ],
)
def test_a_file_that_ros_could_not_read_is_refused_in_one_line(read: Read, text: str, message: str) -> None:
    assert refused(read, text).startswith(message)


def test_a_file_that_is_no_text_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "p.yaml"
    file.write_bytes(b"a: \xff\xfe")
    with pytest.raises(ParameterError, match=r"p.yaml: not UTF-8 text"):
        file_values(SlopeParameters, file, NODE)


@pytest.mark.parametrize(("name", "why"), [("missing.yaml", "No such file or directory"), ("", "Is a directory")])
def test_a_file_that_cannot_be_read_is_refused_in_one_line(tmp_path: Path, name: str, why: str) -> None:
    path = tmp_path / name
    with pytest.raises(ParameterError) as refused:
        file_values(SlopeParameters, path, NODE)
    assert str(refused.value) == f"parameter file {path}: {why}"


def test_the_dataclass_is_made_from_a_file(tmp_path: Path) -> None:
    file = tmp_path / "p.yaml"
    file.write_text("/**/friction_slope: {ros__parameters: {detector: {window: 7}, use_sim_time: true}}")
    assert load(SlopeParameters, file, "friction_slope") == from_mapping(SlopeParameters, {"detector.window": 7})


def test_a_file_without_the_node_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "p.yaml"
    file.write_text("other: {ros__parameters: {deadline: 0.1}}\n", encoding="utf-8")
    with pytest.raises(ParameterError, match=r"no section '/\*\*/friction_slope'"):
        load(SlopeParameters, file, "friction_slope")


_WORDS = [
    *("ros__parameters", "friction_slope", "/**", "/**/friction_slope", "/my_car/friction_slope", "*", "method"),
    *("detector", "window", "detector.window", "distances", "use_sim_time", "qos_overrides", "radii", "<<", "="),
    *("2024-13-45", "1:60", "0x", "0b1", "08", "1_0", "1e999", ".inf", ".nan", "~", "", "9" * 5000, "-", "\ud800"),
]
_SCALARS = st.one_of(st.sampled_from(_WORDS), st.text(max_size=8), st.integers(), st.floats(), st.booleans(), st.none())
_TREES = st.recursive(
    _SCALARS, lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(_SCALARS, inner, max_size=4))
)
_SECTIONS = st.dictionaries(
    st.sampled_from(["/**", "/**/friction_slope", "friction_slope", "my_car", "ros__parameters"]),
    st.one_of(st.dictionaries(st.just("ros__parameters"), _TREES), _TREES),
)
_MARKS = (
    ": |\n|\n  |\n    |- |{|}|[|]|, |&a |*a|> |? |'|\"|#|%YAML 9.9\n|---\n|\t|!!int |!!binary |!!bool |!!set |!!omap "
)
_TOKENS = st.lists(st.sampled_from([*_WORDS, *_MARKS.split("|"), "| ", "!!timestamp "]), max_size=40).map("".join)


def _survives(path: Path, content: bytes) -> None:
    path.write_bytes(content)
    for node in (NODE, IN_CAR):
        try:
            found = file_values(SlopeParameters, path, node)
            from_mapping(SlopeParameters, {name: value for name, value in found.items() if not is_ros_own(name)})
        except ParameterError as error:
            assert "\n" not in str(error)
            str(error).encode(errors="backslashreplace")


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("hostile") / "p.yaml"


@given(tree=st.one_of(_TREES, _SECTIONS))
def test_no_tree_gives_another_error(file: Path, tree: Any) -> None:
    _survives(file, yaml.dump(tree, allow_unicode=False).encode("utf-8", "surrogatepass"))


@given(text=_TOKENS)
@example(text="friction_slope: {ros__parameters: {detector: {window: 2024-13-45}}}")
@example(text="friction_slope: {ros__parameters: {distances: [" + "9" * 5000 + "]}}")
@example(text="friction_slope: {ros__parameters: {distances: !!float x}}")
@example(text="friction_slope: {ros__parameters: {shadow: !!bool x}}")
def test_no_text_gives_another_error(file: Path, text: str) -> None:
    _survives(file, text.encode("utf-8", "surrogatepass"))


@given(content=st.binary())
def test_no_bytes_give_another_error(file: Path, content: bytes) -> None:
    _survives(file, content)
