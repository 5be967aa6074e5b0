from types import SimpleNamespace as Message

import pytest

from friction_adapter.sources import FieldPath, Fields

NUMBER, NUMBERS = Fields({}), Fields({}, is_sequence=True)
WHEEL = Fields({"id": NUMBER, "speed": NUMBER}, is_sequence=True)
TYPE = Fields(
    {"header": Fields({"stamp": Fields({"sec": NUMBER})}), "name": NUMBERS, "velocity": NUMBERS, "wheels": WHEEL}
)
MESSAGE = Message(
    header=Message(stamp=Message(sec=7)),
    name=["a::wheel_fl", "b"],
    velocity=[1.5, 2.5],
    wheels=[Message(id=3, speed=30.0), Message(id=4, speed=40.0)],
)


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("header.stamp.sec", 7),
        ("velocity[1]", 2.5),
        ("velocity[name=a::wheel_fl]", 1.5),
        ("wheels[id=4].speed", 40.0),
        ("wheels[0].speed", 30.0),
    ],
)
def test_a_path_reads_its_field(path: str, value: float) -> None:
    FieldPath(path).check(TYPE)
    assert FieldPath(path).reader()(MESSAGE) == value


@pytest.mark.parametrize(
    ("path", "said"),
    [
        ("velocty[0]", "no field 'velocty': header, name, velocity, wheels"),
        ("header.stmp", "no field 'stmp' in header: stamp"),
        ("velocity", "velocity\\[0\\]"),
        ("header[0].stamp", "is no sequence"),
        ("velocity[nme=b]", "cannot be picked by 'nme': name, velocity"),
        ("wheels[di=3].speed", "cannot be picked by 'di': id, speed"),
        ("wheels[0]", "is a message, not a value: wheels\\[0\\].id, wheels\\[0\\].speed"),
        ("velocity[0].x", "it is a value"),
    ],
)
def test_a_path_that_the_type_does_not_have_is_refused_with_the_fields_there_are(path: str, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        FieldPath(path).check(TYPE)


@pytest.mark.parametrize("path", ["", "a..b", "a[", "a[-1]", "a + b", "a[x]", "2a", "a[b=c=d]"])
def test_what_is_no_path_is_refused(path: str) -> None:
    with pytest.raises(ValueError, match="is no field"):
        FieldPath(path)


@pytest.mark.parametrize("path", ["velocity[name=other]", "velocity[5]", "wheels[id=9].speed"])
def test_a_message_without_the_element_raises(path: str) -> None:
    with pytest.raises((LookupError, ValueError)):
        FieldPath(path).reader()(MESSAGE)
