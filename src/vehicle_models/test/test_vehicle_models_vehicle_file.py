"""Vehicle files: their values, how bad ones are refused, and that no other exception is ever raised."""

import re
import string
from pathlib import Path

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from friction_parameters.parameter import ParameterError
from vehicle_models.vehicle import Accelerometer, Deviation, SharedBy, Vehicle, Wheel
from vehicle_models.vehicle_file import file_keys, load_vehicle, shipped_vehicles, vehicle_path

CAR = """\
name: my car
mass: {value: 1620.0, stddev: 60.0}
front_load_share: 0.58
wheelbase: 2.68
centre_of_gravity_height: 0.54
track: 1.55
accelerometer: {axis: x, sign: 1}
all_wheels: {inertia: 1.1, brake_gain: {value: 1.0e-4, stddev: 1.0e-5}}
axles:
  front: {radius: 0.31}
  rear: {radius: 0.315, driven: true}
wheels:
  FL: {axle: front, side: left, joint: "car::wheel_fl"}
  FR: {axle: front, side: right}
  RL: {axle: rear, side: left, radius: {value: 0.314, stddev: 0.001}}
  RR: {axle: rear, side: right}
"""
CORNER = """\
name: corner
mass: 225
wheels:
  front_left: {axle: front, radius: 0.3, inertia: 1.0, brake_gain: 1e-4}
"""


def load(directory: Path, text: str) -> Vehicle:
    path = directory / "car.yaml"
    path.write_text(text, encoding="utf-8")
    return load_vehicle(path)


def refusal(directory: Path, text: str) -> str:
    """Return the error for a bad file, without its path."""
    with pytest.raises(ParameterError) as caught:
        load(directory, text)
    said = str(caught.value)
    assert "\n" not in said
    assert said.startswith(f"{directory / 'car.yaml'}: ")
    return said.removeprefix(f"{directory / 'car.yaml'}: ")


@pytest.mark.parametrize("name", shipped_vehicles())
def test_each_shipped_file_makes_a_car_with_all_it_carries(name: str) -> None:
    vehicle = load_vehicle(name)
    assert vehicle == load_vehicle(vehicle_path(name))
    assert vehicle.name == vehicle.name.strip()
    assert sum(vehicle.load_shares) == pytest.approx(1.0)
    assert sum(vehicle.transfer_shares) == pytest.approx(0.0)
    corners = [vehicle.corner(wheel) for wheel in vehicle.wheel_names]
    assert sum(corner.mass for corner in corners) == pytest.approx(vehicle.mass)
    assert sum(corner.vertical_load for corner in corners) == pytest.approx(vehicle.mass * 9.81)


def test_known_cars_are_shipped() -> None:
    assert {"chapter_corner", "compact_car", "bmw_m8", "indy_av21"} <= set(shipped_vehicles())
    corner = load_vehicle("chapter_corner").corner("front_left")
    assert (corner.radius, corner.inertia, corner.mass, corner.gravity) == (0.3, 1.0, 225.0, 9.81)


def test_what_is_said_of_a_wheel_decides_over_its_axle_and_that_over_all_wheels(tmp_path: Path) -> None:
    car = load(tmp_path, CAR)
    assert car.wheel_names == ("FL", "FR", "RL", "RR")
    assert car.joints == ("car::wheel_fl", "FR", "RL", "RR")
    assert car.radii == (0.31, 0.31, 0.314, 0.315)
    assert {wheel.inertia for wheel in car.wheels} == {1.1}
    assert [wheel.driven for wheel in car.wheels] == [False, False, True, True]
    assert car.wheel("RL").encoder_teeth == 48
    every = load(
        tmp_path,
        CAR.replace("inertia: 1.1", "inertia: 1.1, radius: 0.2")
        .replace("  front: {radius: 0.31}", "  front: {radius: 0.31, inertia: 1.2}")
        .replace("side: right}", "side: right, inertia: 1.3}", 1),
    )
    assert every.radii == car.radii
    assert [wheel.inertia for wheel in every.wheels] == [1.2, 1.3, 1.1, 1.1]


def test_deviations_say_with_which_wheels_an_error_is_shared(tmp_path: Path) -> None:
    car = load(tmp_path, CAR.replace("front: {radius: 0.31}", "front: {radius: {value: 0.31, stddev: 0.002}}"))
    assert car.deviations == {"mass": Deviation(60.0, SharedBy.ALL)}
    gain = {"brake_gain": Deviation(1e-5, SharedBy.ALL)}
    of_axle = gain | {"radius": Deviation(0.002, SharedBy.AXLE)}
    assert car.wheel("FL").deviations == car.wheel("FR").deviations == of_axle
    assert car.wheel("RL").deviations == gain | {"radius": Deviation(0.001, SharedBy.WHEEL)}
    assert car.wheel("RR").deviations == gain
    mounted = load(tmp_path, CAR.replace("sign: 1}", "sign: 1, bias: {value: 0.1, stddev: 0.17}}"))
    assert mounted.accelerometer == Accelerometer(bias=0.1, deviations={"bias": Deviation(0.17, SharedBy.ALL)})


def test_a_deviation_of_zero_says_that_a_value_is_known_exactly(tmp_path: Path) -> None:
    car = load(tmp_path, CAR.replace("stddev: 60.0", "stddev: 0"))
    assert car.deviations == {"mass": Deviation(0.0, SharedBy.ALL)}


def test_a_value_of_a_wheel_leaves_the_deviation_of_the_common_value_behind(tmp_path: Path) -> None:
    car = load(tmp_path, CAR.replace("front: {radius: 0.31}", "front: {radius: 0.31, brake_gain: 1.2e-4}"))
    assert (car.wheel("FL").brake_gain, car.wheel("FL").deviations) == (1.2e-4, {})
    assert car.wheel("RR").deviations == {"brake_gain": Deviation(1e-5, SharedBy.ALL)}


def test_a_corner_needs_no_more_than_its_mass_and_its_wheel(tmp_path: Path) -> None:
    corner = load(tmp_path, CORNER)
    assert corner.mass == 225.0 and isinstance(corner.mass, float)
    assert corner.wheels == (Wheel("front_left", "front_left", radius=0.3, inertia=1.0, brake_gain=1e-4),)
    assert (corner.load_shares, corner.transfer_shares) == ((1.0,), (0.0,))
    assert corner.accelerometer == Accelerometer()


REFUSED = {
    "unknown key": (
        ("track:", "trak:"),
        "line 6: unknown key 'trak': known here are name, mass, front_load_share, .*, all_wheels, axles, wheels",
    ),
    "unknown key of a wheel": (("driven: true", "drven: true"), "line 11: unknown key 'drven': known here are radius"),
    "side of an axle": (("radius: 0.31}", "radius: 0.31, side: left}"), "line 10: unknown key 'side'"),
    "unknown axle": (("  rear: {", "  back: {"), "line 11: unknown key 'back': known here are front, rear"),
    "unknown part of a value": (("stddev: 60.0", "sttdev: 60.0"), "line 2: unknown key 'sttdev': .* value, stddev"),
    "unknown key of the accelerometer": (("sign: 1", "sing: 1"), "line 7: unknown key 'sing': .* pitch_gain"),
    "key twice": (("track: 1.55", "track: 1.55\nmass: 1700.0"), "line 7: 'mass' is repeated here, first in line 2"),
    "key of a wheel twice": (
        ("driven: true}", "driven: true, driven: false}"),
        "line 11: 'driven' is repeated here, first in line 11",
    ),
    "wheel twice": (("  FR:", "  FL:"), "line 14: 'FL' is repeated here, first in line 13"),
    "no name": (("name: my car\n", ""), "'name' is missing"),
    "no mass": (("mass: {value: 1620.0, stddev: 60.0}\n", ""), r"'mass' is missing: a number, 1 to 100000 \[kg\]"),
    "no wheels": ((CAR[CAR.index("axles:") :], "wheels: {}\n"), "line 9: 'wheels' must name at least one wheel"),
    "a missing key of the car": (
        ("wheelbase: 2.68\n", ""),
        r"'wheelbase' is missing, as a wheel is on the axle 'rear': a number, 0.5 to 20 \[m\]",
    ),
    "a missing key of a wheel": (
        ("inertia: 1.1, ", ""),
        r"line 13: 'inertia' of wheel 'FL' is missing: a number, 0.01 to 100 \[kg m\^2\]",
    ),
    "no axle": (
        ("axle: rear, side: right", "side: right"),
        "line 16: 'axle' of wheel 'RR' is missing: one of front, rear",
    ),
    "bad axle": (("axle: rear, side: right", "axle: back"), "line 16: 'axle' = 'back' must be one of front, rear"),
    "bad axis": (("axis: x", "axis: w"), "line 7: 'axis' = 'w' must be one of x, y, z"),
    "bad sign": (("sign: 1", "sign: 0.5"), "line 7: 'sign' = 0.5 must be 1 or -1"),
    "out of range": (
        ("wheelbase: 2.68", "wheelbase: 268"),
        r"line 4: 'wheelbase' = 268 must be a number, 0.5 to 20 \[m\]",
    ),
    "out of range with a deviation": (
        ("mass: {value: 1620.0, stddev: 60.0}", "mass:\n  value: 0.1\n  stddev: 1.0"),
        r"line 3: 'mass' = 0.1 must be a number, 1 to 100000 \[kg\]",
    ),
    "not a number": (("0.54", ".nan"), r"line 5: 'centre_of_gravity_height' = nan must be a number, 0 to 5 \[m\]"),
    "infinite": (("0.58", ".inf"), "line 3: 'front_load_share' = inf must be a number, 0.05 to 1"),
    "a text for a number": (
        ("0.54", "low"),
        r"line 5: 'centre_of_gravity_height' = 'low' must be a number, 0 to 5 \[m\]",
    ),
    "a number in quotes": (("0.54", "'0.54'"), "line 5: 'centre_of_gravity_height' = '0.54' must be a number"),
    "true for a number": (("0.54", "true"), "line 5: 'centre_of_gravity_height' = True must be a number"),
    "a list for a number": (
        ("0.54", "[0.5, 0.6]"),
        r"line 5: 'centre_of_gravity_height' = \[0.5, 0.6\] must be a number",
    ),
    "nothing for a number": (("0.54", ""), "line 5: 'centre_of_gravity_height' = None must be a number"),
    "a part for a number": (
        ("0.54", "{value: {value: 1}}"),
        "line 5: 'centre_of_gravity_height' = {'value': 1} must be",
    ),
    "a number for a choice": (("driven: true", "driven: 1"), "line 11: 'driven' = 1 must be true or false"),
    "a float for teeth": (
        ("inertia: 1.1", "encoder_teeth: 48.0"),
        "line 8: 'encoder_teeth' = 48.0 must be an integer, 8 to 1000",
    ),
    "a number for the name": (("name: my car", "name: 7"), "line 1: 'name' = 7 must be a text"),
    "no value beside a deviation": (("value: 1620.0, ", ""), "line 2: 'mass' has no 'value'"),
    "deviation below zero": (
        ("stddev: 60.0", "stddev: -1.0"),
        r"line 2: 'stddev' of 'mass' = -1.0 must be a number >= 0 \[kg\]",
    ),
    "deviation not a number": (
        ("stddev: 60.0", "stddev: .nan"),
        "line 2: 'stddev' of 'mass' = nan must be a number >= 0",
    ),
    "deviation infinite": (("stddev: 60.0", "stddev: .inf"), "line 2: 'stddev' of 'mass' = inf must be a number >= 0"),
    "deviation a text": (("stddev: 60.0", "stddev: much"), "line 2: 'stddev' of 'mass' = 'much' must be a number >= 0"),
    "deviation true": (("stddev: 60.0", "stddev: true"), "line 2: 'stddev' of 'mass' = True must be a number >= 0"),
    "deviation empty": (("stddev: 60.0", "stddev:"), "line 2: 'stddev' of 'mass' = None must be a number >= 0"),
    "deviation of a text": (
        ("axis: x", "axis: {value: x, stddev: 0.1}"),
        "line 7: 'stddev' of 'axis': it is no measured quantity",
    ),
    "deviation of a count": (
        ("inertia: 1.1", "encoder_teeth: {value: 48, stddev: 1.0}"),
        "line 8: 'stddev' of 'encoder_teeth': it is no measured quantity",
    ),
    "deviation of a choice": (
        ("driven: true", "driven: {value: true, stddev: 0.1}"),
        "line 11: 'stddev' of 'driven': it is no measured quantity",
    ),
    "name that begins no topic": (
        ("  FR: {", "  front-right: {"),
        "line 14: wheel 'front-right': topics begin with this name, so it is of letters, digits and _, .* its 'joint'",
    ),
    "number for a name": (("  FR: {", "  4: {"), "line 14: wheel '4': topics begin with this name"),
    "empty joint": (('"car::wheel_fl"', '""'), "line 13: 'joint' = '' must be a text"),
    "number for a joint": (('"car::wheel_fl"', "4"), "line 13: 'joint' = 4 must be a text"),
    "joint twice": (('"car::wheel_fl"', "FR"), "line 12: 'wheels': two have the joint 'FR'"),
    "corner twice": (("axle: rear, side: right", "axle: rear, side: left"), "line 12: .* have the place 'rear left'"),
    "all load in front": (
        ("front_load_share: 0.58", "front_load_share: 1.0"),
        "line 3: 'front_load_share' = 1.0 does not fit: a wheel is on the axle 'rear'",
    ),
    "axle without a wheel": (
        (CAR[CAR.index("wheels:\n") :], "wheels:\n  FL: {axle: front}\n"),
        "line 11: 'rear': no wheel is on this axle",
    ),
    "no wheel in front": (
        (CAR[CAR.index("axles:") :], "wheels:\n  RL: {axle: rear, radius: 0.3}\n"),
        "line 9: 'wheels': none is on the axle 'front'",
    ),
    "wheels are a list": (
        (CAR[CAR.index("wheels:\n") :], "wheels: [FL, FR]"),
        "line 12: 'wheels' must hold keys and values",
    ),
    "a wheel is empty": (("FR: {axle: front, side: right}", "FR:"), "line 14: 'FR' must hold keys and values"),
    "all_wheels is empty": ((CAR.splitlines()[7], "all_wheels:"), "line 8: 'all_wheels' must hold keys and values"),
    "an axle is empty": (("front: {radius: 0.31}", "front:"), "line 10: 'front' must hold keys and values"),
    "not YAML": (("name: my car", "name: [my car"), "line 2: not YAML: .*"),
    "a list": ((CAR, "- 1\n- 2\n"), "line 1: a mapping is expected"),
    "empty": ((CAR, ""), "'name' is missing"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_bad_file_is_refused_in_one_line_with_file_line_key_unit_and_range(case: str, tmp_path: Path) -> None:
    (good, bad), said = REFUSED[case]
    assert good in CAR
    assert re.match(said, refusal(tmp_path, CAR.replace(good, bad, 1))), refusal(tmp_path, CAR.replace(good, bad, 1))


def test_a_load_share_of_a_car_without_rear_wheels_is_refused(tmp_path: Path) -> None:
    said = refusal(tmp_path, CORNER + "front_load_share: 0.6\n")
    assert said == "line 5: 'front_load_share' = 0.6 does not fit: no wheel is on the axle 'rear'"


def test_bytes_that_are_no_text_are_refused(tmp_path: Path) -> None:
    (tmp_path / "car.yaml").write_bytes(b"name: \xff\xfe\n")
    with pytest.raises(ParameterError, match=r"car\.yaml"):
        load_vehicle(tmp_path / "car.yaml")


@pytest.mark.parametrize("name", ["bmw", "no/such/file.yaml", "bad\0name", "x" * 5000, "."])
def test_a_vehicle_that_does_not_exist_is_refused_with_those_shipped(name: str) -> None:
    with pytest.raises(ParameterError, match=r"there is no vehicle file .* chapter_car, chapter_corner, compact_car"):
        load_vehicle(name)


def test_no_vehicle_is_refused_with_those_shipped() -> None:
    with pytest.raises(ParameterError, match=r"no vehicle file is given .*'vehicle_file'.* bmw_m8, chapter_car"):
        load_vehicle("")


KEYS = [
    "name",
    "joint",
    "value",
    "stddev",
    "all_wheels",
    "axles",
    "wheels",
    "accelerometer",
    "front",
    "rear",
    "FL",
    "a-b",
]
KEYS += [key for cls in (Vehicle, Wheel, Accelerometer) for key in file_keys(cls)]
SCALARS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.sampled_from(["front", "rear", "left", "right", "x", "y", "", "on", "1e999", "0x", "2001-99-99", "!!int x"]),
    st.text(string.printable, max_size=8),
)
TREES = st.recursive(
    SCALARS,
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(st.sampled_from(KEYS), inner, max_size=6)),
    max_leaves=25,
)


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(tree=TREES, place=st.sampled_from(["", *KEYS]))
def test_a_hostile_tree_of_the_right_keys_makes_a_car_or_a_refusal(tree: object, place: str, tmp_path: Path) -> None:
    content = yaml.safe_load(CAR)
    if place:
        content[place] = tree
    path = tmp_path / "car.yaml"
    path.write_text(yaml.safe_dump(content if place else tree), encoding="utf-8")
    check(path)


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_file_with_hostile_characters_in_it_makes_a_car_or_a_refusal(data: st.DataObject, tmp_path: Path) -> None:
    begin = data.draw(st.integers(0, len(CAR)))
    end = data.draw(st.integers(begin, min(begin + 12, len(CAR))))
    pieces = st.sampled_from(
        [*"{}[]:,&*!|>'\"#%@`- \t\n", "!!int ", "!!float ", "&a ", "*a", "<<: ", ".nan", "0b_", "\0"]
    )
    middle = "".join(data.draw(st.lists(st.one_of(pieces, st.text(max_size=3)), max_size=4)))
    path = tmp_path / "car.yaml"
    path.write_bytes((CAR[:begin] + middle + CAR[end:]).encode("utf-8", errors="surrogatepass"))
    check(path)


def check(path: Path) -> None:
    try:
        vehicle = load_vehicle(path)
    except ParameterError as error:
        assert "\n" not in str(error)
        assert str(path) in str(error)
    else:
        assert sum(vehicle.load_shares) == pytest.approx(1.0)
        for cls, part in [
            (Vehicle, vehicle),
            (Accelerometer, vehicle.accelerometer),
            *((Wheel, w) for w in vehicle.wheels),
        ]:
            for key, limits in file_keys(cls).items():
                if limits["minimum"] is not None:
                    assert limits["minimum"] <= getattr(part, key) <= limits["maximum"]
