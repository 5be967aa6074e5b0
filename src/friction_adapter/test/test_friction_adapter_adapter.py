"""Records of any source as values in SI units."""

from collections.abc import Sequence
from itertools import pairwise
from math import isnan, nan
from pathlib import Path

import pytest

from friction_adapter.adapter import Adapter, Output
from friction_adapter.map_file import load_map
from friction_adapter.sources import TABLE, Fields, Sources
from friction_parameters.parameter import ParameterError

CAR = Path(__file__).parent / "four_wheels.yaml"
SECOND = 1_000_000_000
UNITS = {"V": "km/h", "A": "m/s2", "P": "", "X": "furlong"}


class Bus:
    """A DBC file whose frames are f.V, f.A, g.P and g.X."""

    def find(self, name: str) -> tuple[str, str, str]:
        for frame, signals in (("f", "VA"), ("g", "PX")):
            if name in signals:
                return frame, name, UNITS[name]
        raise ValueError("there are V, A, P")


def adapter(directory: Path, *signals: str, columns: Sequence[str] = (), top: str = "stamp: t") -> Adapter:
    path = directory / "map.yaml"
    path.write_text("\n".join([f"vehicle: {CAR}", top, "signals:", *(f"  {each}" for each in signals)]))
    return Adapter(load_map(path), Sources(lambda _: Fields({}), Bus(), columns))


def taken(made: Sequence[Output]) -> list[tuple[int, list[float]]]:
    return [(each.stamp, list(each.values)) for each in made]


def test_a_row_becomes_the_values_of_one_stamp(tmp_path: Path) -> None:
    of_map = adapter(
        tmp_path,
        "speed: {from: {column: v}, unit: km/h, latency: 0.25}",
        "wheel_speed: {from: table, field: '{wheel}', unit: m/s}",
        columns=("t", "v", "FL", "FR", "RL", "RR"),
        top="stamp: t\nstamp_offset: 1000",
    )
    row = {"t": -0.5, "v": 36.0, "FL": 3.0, "FR": 6.0, "RL": 3.2, "RR": 6.4}
    assert [target.topic for target in of_map.targets] == ["wheel_states", "vehicle_velocity"]
    wheels, speed = of_map.take(TABLE, row, 0)
    assert (wheels.stamp, speed.stamp) == (999_500_000_000, 999_250_000_000)
    assert list(wheels.values) == pytest.approx([10.0, 20.0, 10.0, 20.0], rel=1e-14)
    assert speed.values[0] == pytest.approx(10.0, rel=1e-14)


def test_a_radius_of_the_map_holds_in_place_of_those_of_the_car(tmp_path: Path) -> None:
    # the car's wheels have 0.3 and 0.32 m: a file that learns them must not change what the wheels turn
    columns = ("t", "FL", "FR", "RL", "RR")
    entry = "wheel_speed: {from: table, field: '{wheel}', unit: km/h, radius: 0.25}"
    of_map = adapter(tmp_path, entry, columns=columns)
    (wheels,) = of_map.take(TABLE, {"t": 1.0, "FL": 9.0, "FR": 9.0, "RL": 9.0, "RR": 18.0}, 0)
    assert list(wheels.values) == pytest.approx([10.0, 10.0, 10.0, 20.0], rel=1e-14)


def test_an_axles_pressure_goes_to_its_wheels(tmp_path: Path) -> None:
    of_map = adapter(
        tmp_path,
        "brake_pressure: {from: table, fields: {front: pf, rear: pr}, unit: '%', full_scale: 1.0e7}",
        columns=("t", "pf", "pr"),
    )
    made = of_map.take(TABLE, {"t": 1.0, "pf": 50.0, "pr": 20.0}, 0)
    assert [of_map.targets[each.target].topic for each in made] == [
        f"{w}/brake_pressure" for w in ("FL", "FR", "RL", "RR")
    ]
    assert [each.values[0] for each in made] == pytest.approx([5e6, 5e6, 2e6, 2e6])


@pytest.mark.parametrize(("how", "value"), [("sum", 30.0), ("mean", 15.0)])
def test_several_fields_are_added_up(tmp_path: Path, how: str, value: float) -> None:
    of_map = adapter(tmp_path, f"speed: {{from: table, field: [a, b], combine: {how}}}", columns=("t", "a", "b"))
    assert of_map.take(TABLE, {"t": 1.0, "a": 10.0, "b": 20.0}, 0)[0].values[0] == pytest.approx(value)


def test_an_invalid_value_is_none_and_a_message_of_none_is_not_sent(tmp_path: Path) -> None:
    of_map = adapter(tmp_path, "speed: {from: {column: v}, invalid: [655.35, -1]}", columns=("t", "v"))
    assert of_map.take(TABLE, {"t": 1.0, "v": 655.35}, 0) == []
    assert of_map.take(TABLE, {"t": 1.0, "v": nan}, 0) == []
    assert of_map.take(TABLE, {"t": 1.1, "v": 655.0}, 0)[0].values[0] == 655.0


def test_a_wheel_that_is_flagged_is_left_out_and_the_others_stay(tmp_path: Path) -> None:
    of_map = adapter(
        tmp_path,
        "wheel_speed: {from: table, field: '{wheel}', valid: {field: 'ok_{wheel}', is: 1}}",
        columns=("t", "FL", "FR", "RL", "RR", "ok_FL", "ok_FR", "ok_RL", "ok_RR"),
    )
    row = {"t": 1.0, **dict.fromkeys(("FL", "FR", "RL", "RR"), 5.0), **dict.fromkeys(("ok_FL", "ok_FR", "ok_RR"), 1.0)}
    ((_, values),) = taken(of_map.take(TABLE, {**row, "ok_RL": 0.0}, 0))
    assert [isnan(each) for each in values] == [False, False, True, False]


def test_wheels_that_the_map_says_were_not_recorded_are_left_out(tmp_path: Path) -> None:
    of_map = adapter(
        tmp_path,
        "wheel_speed: {from: table, fields: {RL: a, RR: b, front: null}, unit: rad/s}",
        columns=("t", "a", "b"),
    )
    assert of_map.targets[0].parts == ("RL", "RR")
    assert taken(of_map.take(TABLE, {"t": 1.0, "a": 5.0, "b": 6.0}, 0)) == [(1_000_000_000, [5.0, 6.0])]


def test_counters_of_edges_become_speeds_at_the_middle_of_each_step(tmp_path: Path) -> None:
    names = ("FL", "FR", "RL", "RR")
    of_map = adapter(
        tmp_path,
        "wheel_speed: {from: table, field: '{wheel}', unit: edges, counter: 256, invalid: 999}",
        columns=("t", *names),
    )
    angle = 6.283185307179586 / 48.0

    def sent(t: float, *counts: float) -> list[tuple[int, list[float]]]:
        return taken(of_map.take(TABLE, {"t": t, **dict(zip(names, counts, strict=True))}, 0))

    assert sent(1.0, 10, 250, 5, 7) == []
    ((stamp, speeds),) = sent(1.02, 14, 2, 1, 999)
    assert stamp == 1_010_000_000
    assert speeds[:3] == pytest.approx([4 * angle / 0.02, 8 * angle / 0.02, -4 * angle / 0.02])
    assert isnan(speeds[3])
    ((stamp, speeds),) = sent(1.04, 14, 2, 1, 7)
    assert (stamp, speeds[:3]) == (1_030_000_000, [0.0, 0.0, 0.0])
    assert isnan(speeds[3])
    assert sent(1.5, 20, 20, 20, 20) == []  # it may have wrapped
    assert sent(1.4, 20, 20, 20, 20) == []
    assert len(sent(1.41, 20, 20, 20, 20)) == 1
    of_map.reset()
    assert sent(1.42, 20, 20, 20, 20) == []


def test_a_speed_of_a_counter_is_the_mean_over_twenty_edges_in_at_most_a_tenth_of_a_second(tmp_path: Path) -> None:
    of_map = adapter(
        tmp_path,
        "wheel_speed: {from: table, fields: {all: count}, unit: edges, scale: 0.5, counter: 256}",
        columns=("t", "count"),
    )
    angle = 6.283185307179586 / 48.0
    speeds: list[tuple[int, float]] = []
    for k in range(200):
        t = 0.01 * k
        edges = 240.0 * t if t < 1.0 else 240.0 + 40.0 * (t - 1.0)
        made = taken(of_map.take(TABLE, {"t": 1.0 + t, "count": 2.0 * (int(edges) % 256)}, 0))
        speeds += [(stamp, values[0]) for stamp, values in made]
    assert all(later[0] > earlier[0] for earlier, later in pairwise(speeds))
    fast = [speed / angle for stamp, speed in speeds if 1.2e9 < stamp < 1.9e9]
    assert max(abs(speed - 240.0) for speed in fast) < 240.0 / 18.0
    slow = [speed / angle for stamp, speed in speeds if stamp > 2.2e9]
    assert max(abs(speed - 40.0) for speed in slow) <= 10.0 + 1e-6


def test_frames_are_stamped_by_their_arrival_and_unknown_ones_left_aside(tmp_path: Path) -> None:
    of_map = adapter(tmp_path, "speed: {from: {can: V}}", "acceleration: {from: {can: A}}")
    assert of_map.take("other", {}, SECOND) == []
    imu, speed = of_map.take("f", {"V": 36.0, "A": -2.0}, 3 * SECOND)
    assert imu.stamp == speed.stamp == 3 * SECOND
    assert imu.values[0] == -2.0
    assert speed.values[0] == pytest.approx(10.0)  # it is in km/h by the DBC file


def test_a_standard_deviation_is_in_the_unit_of_the_signal(tmp_path: Path) -> None:
    of_map = adapter(tmp_path, "speed: {from: {can: V}, stddev: 3.6}")
    assert of_map.stddevs == [{"speed": pytest.approx(1.0)}]


@pytest.mark.parametrize(
    ("signal", "said"),
    [
        (
            "speed: {from: {can: V}, radius: 0.3}",
            "line 4: 'speed': 'radius' belongs to speeds of a rim, such as km/h, not to",
        ),
        (
            "wheel_speed: {from: table, fields: {all: V}, radius: 0.3}",
            "'radius' belongs to speeds of a rim, such as km/h, not to",
        ),
        ("speed: {from: {can: V}, unit: m/s}", "line 4: 'speed': its unit is m/s here, and km/h where it comes from"),
        (
            "speed: {from: {can: X}}",
            "it comes in 'furlong': give its unit, one of m/s, km/h",
        ),
        ("speed: {from: {can: Y}}", "line 4: 'speed': there are V, A, P"),
        ("speed: {from: table, field: [V, Q], combine: sum}", "there is no column 'Q': P, V, t"),
        ("speed: {from: can, field: [V, P], combine: sum}", "its fields come from f, g"),
        ("speed: {from: {topic: /v, type: a_msgs/msg/V}, field: v}", "a_msgs/msg/V: there is no field 'v'"),
    ],
)
def test_a_signal_that_is_not_there_is_refused_with_what_is(tmp_path: Path, signal: str, said: str) -> None:
    with pytest.raises(ParameterError) as refused:
        adapter(tmp_path, signal, columns=("P", "V", "t"))
    assert said in str(refused.value)


def test_a_unit_that_the_dbc_file_does_not_know_is_that_of_the_map(tmp_path: Path) -> None:
    of_map = adapter(tmp_path, "speed: {from: {can: X}, unit: km/h}")
    assert of_map.take("g", {"X": 3.6}, 0)[0].values[0] == pytest.approx(1.0)


def test_signals_of_one_message_and_source_share_their_latency(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="it shares a message with 'acceleration'"):
        adapter(
            tmp_path,
            "acceleration: {from: {column: a}, latency: 0.01}",
            "yaw_rate: {from: {column: r}}",
            columns=("t", "a", "r"),
        )


def test_a_stamp_that_no_message_can_hold_is_counted_and_left_out(tmp_path: Path) -> None:
    of_map = adapter(tmp_path, "speed: {from: {column: v}}", columns=("t", "v"))
    for stamp in (-1.0, nan, float("inf"), 1e30, 2.0**31):
        assert of_map.take(TABLE, {"t": stamp, "v": 1.0}, 0) == []
    assert of_map.refused == 5
    assert len(of_map.take(TABLE, {"t": 2.0**31 - 1.0, "v": 1.0}, 0)) == 1


def test_a_record_without_the_value_is_counted_by_signal(tmp_path: Path) -> None:
    of_map = adapter(tmp_path, "speed: {from: {column: v}}", columns=("t", "v"))
    assert of_map.take(TABLE, {"t": 1.0}, 0) == []
    assert of_map.unreadable == {"'speed'": 1}
