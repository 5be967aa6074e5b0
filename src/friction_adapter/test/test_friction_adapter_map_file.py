"""Maps as files: what they mean, and that every mistake is refused with its line."""

from math import isnan
from pathlib import Path

import pytest

from friction_adapter.map_file import load_map, shipped_maps
from friction_adapter.signal_map import Kind, SignalMap
from friction_parameters.parameter import ParameterError

CAR = Path(__file__).parent / "four_wheels.yaml"
WHEELS = "wheel_speed: {from: {topic: /w, type: a_msgs/msg/W}, fields: {FL: a, FR: b, RL: c, RR: d}, unit: km/h}"


def written(directory: Path, *signals: str, top: str = "") -> Path:
    """A map: line 1 names the car, the signals begin in line 3."""
    path = directory / "map.yaml"
    path.write_text("\n".join([f"vehicle: {CAR}", "signals:", *(f"  {each}" for each in signals), top, ""]))
    return path


def read(directory: Path, *signals: str, top: str = "") -> SignalMap:
    return load_map(written(directory, *signals, top=top))


def test_each_wheel_has_a_signal_in_the_order_of_the_car(tmp_path: Path) -> None:
    signals = read(tmp_path, WHEELS).signals
    assert [(each.wheel, each.fields) for each in signals] == [
        ("FL", ("a",)),
        ("FR", ("b",)),
        ("RL", ("c",)),
        ("RR", ("d",)),
    ]
    assert {each.unit for each in signals} == {"km/h"}
    assert {each.stamp for each in signals} == {"header.stamp"}
    assert read(tmp_path, WHEELS).topics == {"/w": "a_msgs/msg/W"}


def test_a_text_with_wheel_names_a_signal_of_each(tmp_path: Path) -> None:
    signals = read(tmp_path, 'brake_pressure: {from: {can: "P_{wheel}"}, unit: bar, latency: 0.01}').signals
    assert [each.fields for each in signals] == [("P_FL",), ("P_FR",), ("P_RL",), ("P_RR",)]
    assert {each.latency for each in signals} == {10_000_000}
    assert {each.origin.kind for each in signals} == {Kind.CAN}


def test_a_wheel_goes_before_its_axle_and_that_before_all(tmp_path: Path) -> None:
    signals = read(tmp_path, "brake_pressure: {from: table, fields: {all: line, front: axle, FR: own}}").signals
    assert [each.fields[0] for each in signals] == ["axle", "own", "line", "line"]


def test_a_wheel_is_named_by_its_place_or_its_joint_where_a_map_is_for_any_car(tmp_path: Path) -> None:
    places = "brake_pressure: {from: table, fields: {front_left: a, rear_right: b, FL: own}}"
    assert [each.fields for each in read(tmp_path, places).signals] == [("own",), ("b",)]
    (first, *_) = read(tmp_path, 'wheel_speed: {from: can, field: "{joint}_v"}').signals
    assert first.fields == ("wheel_fl_joint_v",)


def test_pressures_of_one_axle_are_enough(tmp_path: Path) -> None:
    signals = read(tmp_path, "brake_pressure: {from: table, fields: {front: axle}}").signals
    assert [each.wheel for each in signals] == ["FL", "FR"]


@pytest.mark.parametrize("topic", ['"/{wheel}/w"', "{FL: /FL/w, FR: /FR/w, RL: /RL/w, RR: /RR/w}"])
def test_each_wheel_may_have_a_topic(tmp_path: Path, topic: str) -> None:
    signals = read(tmp_path, f"wheel_speed: {{from: {{topic: {topic}, type: a_msgs/msg/W}}, field: w}}").signals
    assert [each.origin.topic for each in signals] == ["/FL/w", "/FR/w", "/RL/w", "/RR/w"]
    assert {each.fields for each in signals} == {("w",)}


def test_defaults(tmp_path: Path) -> None:
    signal_map = read(tmp_path, "speed: {from: {column: v}}")
    (signal,) = signal_map.signals
    assert (signal.scale, signal.offset, signal.sign, signal.latency, signal.invalid) == (1.0, 0.0, 1, 0, ())
    assert isnan(signal.stddev)
    assert signal.flag is None
    assert (signal_map.stamp_offset, signal_map.together) == (0, 5_000_000)


def test_the_car_is_looked_for_beside_the_map_and_can_be_another(tmp_path: Path) -> None:
    (tmp_path / "car.yaml").write_text(CAR.read_text())
    path = tmp_path / "map.yaml"
    path.write_text("vehicle: car.yaml\nsignals: {speed: {from: {column: v}}}\n")
    assert load_map(path).vehicle_reference == str(tmp_path / "car.yaml")
    assert load_map(path, "bmw_m8").vehicle.name == load_map(path, "bmw_m8").vehicle.name != "test car"


@pytest.mark.parametrize(
    ("signal", "said"),
    [
        ("wheelspeed: {from: table, field: w}", "line 3: unknown signal 'wheelspeed': known are wheel_speed"),
        ("speed: {from: {column: v}, units: m/s}", "line 3: unknown key 'units': known here are from, field"),
        ("speed: {field: v}", "line 3: 'speed' has no 'from'"),
        ("speed: {from: serial, field: v}", "line 3: 'from' = 'serial' must be one of"),
        ("speed: {from: {topic: /v}, field: v}", "line 3: 'from' needs topic and type"),
        ("speed: {from: {topic: /v, type: v}, field: v}", "line 3: 'type' = 'v' is no message type"),
        ("speed: {from: table}", "line 3: the field of 'speed' is given nowhere"),
        ("speed: {from: {column: v}, field: w}", "line 3: the field of 'speed' is given twice"),
        ("speed: {from: {topic: /v, type: a_msgs/msg/V}, field: v + 1}", "line 3: 'v \\+ 1' is no field"),
        ("speed: {from: {column: v}, unit: bar}", "line 3: 'bar' is no unit of 'speed': known are m/s, km/h"),
        ("speed: {from: {column: v}, sign: -2}", "line 3: 'sign' = -2 must be 1 or -1"),
        ("speed: {from: {column: v}, scale: 0}", "line 3: 'scale' = 0"),
        ("speed: {from: {column: v}, scale: fast}", "line 3: 'scale' = 'fast' must be a number"),
        ("speed: {from: {column: v}, latency: -1}", "line 3: 'latency' = -1 must be a number from 0 to 1"),
        ("speed: {from: {column: v}, latency: .nan}", "line 3: 'latency' = nan must be a number"),
        (
            'wheel_speed: {from: table, field: "{wheel}", unit: km/h, radius: 9}',
            "line 3: 'radius' = 9 must be a number",
        ),
        ("speed: {from: {column: v}, invalid: none}", "line 3: 'invalid' = 'none' must be a number"),
        ("speed: {from: {column: v}, valid: {field: ok}}", "line 3: 'valid' must be"),
        ("speed: {from: table, field: [a, b]}", "line 3: 'field' names several: add 'combine'"),
        ("speed: {from: table, field: [a, b], combine: max}", "line 3: 'combine' = 'max' must be sum or mean"),
        ("speed: {from: table, fields: {FL: a}}", "line 3: 'speed' is that of the car"),
        ("wheel_speed: {from: {column: w}}", "line 3: 'wheel_speed' is that of each wheel: give {FL: ..., FR: ..."),
        (
            "wheel_speed: {from: table, fields: {FL: a, RL: c}}",
            "line 3: 'wheel_speed' lacks FR, RR of the car",
        ),
        (
            "wheel_speed: {from: table, fields: {all: null}}",
            "line 3: 'wheel_speed' lacks ",
        ),
        (
            "wheel_speed: {from: table, fields: {LF: a}}",
            "line 3: unknown key 'LF': known here are FL, FR, RL, RR, front_left, front",
        ),
        ('wheel_speed: {from: table, field: "{wheel}", stddev: 1}', "line 3: the message of 'wheel_speed' carries no"),
        ("brake_demand: {from: {column: p}, unit: '%'}", "line 3: 'full_scale' belongs to the unit %: 100 % in Pa"),
        ('wheel_speed: {from: table, field: "{wheel}", unit: edges}', "line 3: 'counter' belongs to the unit edges"),
        ('wheel_speed: {from: table, field: "{wheel}", counter: 256}', "line 3: 'counter' belongs to the unit edges"),
        ("yaw_rate: {from: {column: r}}", "line 3: 'yaw_rate' goes into the message of 'acceleration'"),
    ],
)
def test_a_mistake_is_refused_with_its_line(tmp_path: Path, signal: str, said: str) -> None:
    with pytest.raises(ParameterError) as refused:
        read(tmp_path, signal)
    text = str(refused.value)
    begin = f"{tmp_path / 'map.yaml'}: "
    assert text.startswith(begin)
    assert text[len(begin) :].startswith(said.replace("\\", ""))


@pytest.mark.parametrize(
    ("top", "said"),
    [
        ("stamps: x", "line 4: unknown key 'stamps'"),
        ("together: 2", "line 4: 'together' = 2 must be a number from 0 to 1"),
        ("can: {dbc: nowhere.dbc}", "line 4: there is no DBC file"),
        ("can: {buses: 1}", "line 4: unknown key 'buses': known here are dbc, topic, bus"),
        ("vehicle: bmw_m8", "line 4: 'vehicle' is repeated here, first in line 1"),
    ],
)
def test_a_mistake_beside_the_signals_is_refused_too(tmp_path: Path, top: str, said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        read(tmp_path, "speed: {from: {column: v}}", top=top)


def test_a_map_without_car_or_signals_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "map.yaml"
    for text, said in (
        ("signals: {speed: {from: {column: v}}}", "'vehicle' is missing"),
        ("vehicle: bmw_m8", "'signals' is missing"),
        ("vehicle: no_car\nsignals: {}", "line 1: there is no vehicle file"),
        ("vehicle: bmw_m8\nsignals: {}", "'signals' names none"),
    ):
        path.write_text(text)
        with pytest.raises(ParameterError, match=said):
            load_map(path)


def test_an_unknown_map_is_refused_with_those_shipped() -> None:
    with pytest.raises(ParameterError, match=r"no signal map 'nowhere'.*bmw"):
        load_map("nowhere")


@pytest.mark.parametrize("name", shipped_maps())
def test_a_shipped_map_is_valid(name: str) -> None:
    assert load_map(name, "compact_car").signals


def test_what_cannot_be_estimated_is_said_with_what_to_add(tmp_path: Path) -> None:
    texts = " ".join(read(tmp_path, "speed: {from: {column: v}}").cannot)
    for quantity in ("wheel_speed", "acceleration", "brake_pressure"):
        assert f"without '{quantity}'" in texts
    rest = "acceleration: {from: {column: a}}", "brake_pressure: {from: table, fields: {all: p}}"
    assert read(tmp_path, WHEELS, *rest).cannot == ()
