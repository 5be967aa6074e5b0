import csv
import hashlib
import os
from itertools import pairwise
from math import isclose
from pathlib import Path

import pytest
from rclpy.serialization import deserialize_message

from friction_adapter.stamp_unit import STAMP_UNITS
from friction_bags.__main__ import main
from friction_bags.bag_io.bag_reader import BagReader
from friction_runtime.installed import message_class
from vehicle_models.vehicle_file import load_vehicle

DATA = Path(os.environ.get("FRICTION_DATA", Path(__file__).parents[4] / "shared" / "data"))
BMW_COLUMNS = (
    *("t_s", "vx_mps", "vy_mps", "ax_mps2", "ay_mps2", "yaw_rate_radps"),
    *("w_fl_radps", "w_fr_radps", "w_rl_radps", "w_rr_radps", "brake_torque_can"),
)
BMW = DATA / "bmw_m8_abs_stop_100hz.csv"
IAC = DATA / "iac_av21_putnam_25hz.csv"
needs_data = pytest.mark.skipif(not BMW.is_file(), reason=f"{BMW} is absent (set FRICTION_DATA)")


def imported(kind: str, source: Path, bag: Path) -> dict[str, list]:
    """Messages by topic of a file imported by the command."""
    assert main(["import", kind, str(source), "--out", str(bag)]) == 0
    found: dict[str, list] = {}
    with BagReader(bag) as reader:
        for topic, stamp, data in reader.messages():
            message = deserialize_message(data, message_class(topic.type))
            assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == stamp
            found.setdefault(topic.name, []).append((stamp, message))
    return found


def rows_of(path: Path) -> list[dict[str, float]]:
    with path.open(newline="") as stream:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(stream)]


@needs_data
def test_the_bmw_bag_holds_the_values_and_the_times_of_the_file(tmp_path: Path) -> None:
    rows = rows_of(BMW)
    bag = imported("bmw", BMW, tmp_path / "bag")
    assert set(bag) == {"/wheel_states", "/imu/data", "/vehicle_velocity", "/can/total_brake_torque_request"}
    assert all(len(messages) == len(rows) for messages in bag.values())
    for row, (stamp, wheels) in zip(rows, bag["/wheel_states"], strict=True):
        assert stamp - 1000 * 10**9 == round(row["t_s"] * 1e9)
        assert wheels.name == ["front_left", "front_right", "rear_left", "rear_right"]
        assert list(wheels.velocity) == [row[f"w_{wheel}_radps"] for wheel in ("fl", "fr", "rl", "rr")]
    for row, (_, imu) in zip(rows, bag["/imu/data"], strict=True):
        assert (imu.linear_acceleration.x, imu.linear_acceleration.y) == (row["ax_mps2"], row["ay_mps2"])
        assert imu.angular_velocity.z == row["yaw_rate_radps"]
        assert imu.orientation_covariance[0] == -1.0
    for row, (_, speed) in zip(rows, bag["/vehicle_velocity"], strict=True):
        assert (speed.twist.twist.linear.x, speed.twist.twist.linear.y) == (row["vx_mps"], row["vy_mps"])
    for row, (_, torque) in zip(rows, bag["/can/total_brake_torque_request"], strict=True):
        assert (torque.name, list(torque.effort)) == (["all_wheels"], [row["brake_torque_can"]])


@needs_data
@pytest.mark.parametrize(
    ("kind", "source", "digest"), [("bmw", BMW, "c8ed2c8d2f6a0359"), ("iac", IAC, "a27d0b76d98eaf36")]
)
def test_the_bags_are_those_of_the_importers_that_were_not_maps(
    tmp_path: Path, kind: str, source: Path, digest: str
) -> None:
    assert main(["import", kind, str(source), "--out", str(tmp_path / "bag")]) == 0
    with BagReader(tmp_path / "bag") as reader:
        rows = sorted((stamp, topic.name, topic.type, bytes(data)) for topic, stamp, data in reader.messages())
    found = hashlib.sha256(b"".join(f"{stamp} {name} {kind} ".encode() + data for stamp, name, kind, data in rows))
    assert found.hexdigest()[:16] == digest
    assert not any("brake_pressure" in name for _, name, _, _ in rows)  # none was recorded, none is invented


@needs_data
@pytest.mark.parametrize(("kind", "source", "vehicle"), [("bmw", BMW, "bmw_m8"), ("iac", IAC, "indy_av21")])
def test_a_bag_says_of_which_car_it_is_and_names_its_wheels(
    tmp_path: Path, kind: str, source: Path, vehicle: str
) -> None:
    bag = imported(kind, source, tmp_path / "bag")
    with BagReader(tmp_path / "bag") as reader:
        assert reader.custom_data["vehicle"] == vehicle
    assert tuple(bag["/wheel_states"][0][1].name) == load_vehicle(vehicle).joints


@needs_data
def test_bursts_of_near_duplicate_stamps_are_kept_in_their_order(tmp_path: Path) -> None:
    stamps = [stamp for stamp, _ in imported("bmw", BMW, tmp_path / "bag")["/wheel_states"]]
    steps = [after - before for before, after in pairwise(stamps)]
    assert min(steps) > 0
    assert sum(step < 1_000_000 for step in steps) == 7
    assert max(steps) > 60_000_000


@needs_data
def test_the_iac_bag_holds_the_values_of_the_file(tmp_path: Path) -> None:
    rows, car = rows_of(IAC), load_vehicle("indy_av21")
    bag = imported("iac", IAC, tmp_path / "bag")
    assert set(bag) == {"/wheel_states", "/imu/data", "/vehicle_velocity", "/brake_demand"}
    for row, (stamp, wheels) in zip(rows, bag["/wheel_states"], strict=True):
        assert stamp == round(row["time(s)"] * 1e9)
        rims = [row[f"wheel_{wheel}(kmph)"] for wheel in ("fl", "fr", "rl", "rr")]
        back = [speed * radius * 3.6 for speed, radius in zip(wheels.velocity, car.radii, strict=True)]
        assert all(isclose(a, b, rel_tol=1e-14) for a, b in zip(rims, back, strict=True))
    for row, (_, demand) in zip(rows, bag["/brake_demand"], strict=True):
        assert demand.pressure == row["brake_ped_cmd(kPa)"] * 1000.0
    for row, (_, imu) in zip(rows, bag["/imu/data"], strict=True):
        assert imu.linear_acceleration.x == row["ax(m/s^2)"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a,b\n1,2\n", "there is no column 'w_fl_radps': a, b"),
        (",".join(BMW_COLUMNS) + "\n" + ",".join(["1", *["x"] * 10]) + "\n", "line 2: "),
        (",".join(BMW_COLUMNS) + "\n" + "1,2", "the last line has no end"),
    ],
)
def test_a_file_with_other_columns_or_no_numbers_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, said: str
) -> None:
    source = tmp_path / "x.csv"
    source.write_text(text)
    assert main(["import", "bmw", str(source), "--out", str(tmp_path / "bag")]) == 2
    assert said in capsys.readouterr().err


def test_a_missing_file_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["import", "iac", str(tmp_path / "x.csv"), "--out", str(tmp_path / "bag")]) == 2
    assert "x.csv" in capsys.readouterr().err


TABLE_MAP = """vehicle: bmw_m8
stamp: time
signals:
  speed: {from: {column: "v [km/h]"}, unit: km/h}
"""


@pytest.mark.parametrize(
    "text",
    [
        "# time,v [km/h],gear\n1.5,36,D\n",
        "time;v [km/h];gear\n1.5;36;D\n",
        "\ufefftime\tgear\tv [km/h]\n1.5\tD\t36\n",
        'gear,"time","v [km/h]"\nD,1.5,36\n',
    ],
)
def test_tables_of_other_tools_are_read(tmp_path: Path, text: str) -> None:
    signal_map, source = tmp_path / "map.yaml", tmp_path / "drive.csv"
    signal_map.write_text(TABLE_MAP)
    source.write_text(text, encoding="utf-8")
    assert main(["import", str(source), "--map", str(signal_map), "--out", str(tmp_path / "bag")]) == 0
    with BagReader(tmp_path / "bag") as reader:
        ((topic, stamp, data),) = list(reader.messages())
        assert reader.custom_data["vehicle"] == "bmw_m8"
    assert (topic.name, stamp) == ("/vehicle_velocity", 1_500_000_000)
    assert isclose(deserialize_message(data, message_class(topic.type)).twist.twist.linear.x, 10.0)


@pytest.mark.parametrize(
    ("text", "stamps"),
    [
        ("time, v [km/h] , m/s\xb2\n1.5, 36, 1\n", [1.5]),
        ("time,v [km/h],a\ns,km/h,g\n\n1.5,36,1\n", [1.5]),
        ("time,v [km/h],a\n1.5,36,1\n1.6,,2\n1.7,36,3\n", [1.5, 1.7]),
        ("time,v [km/h]\n1970-01-01 00:00:01.500000000,36\n1970-01-01T01:00:01.6+0100,36\n", [1.5, 1.6]),
        ("time,v [km/h]\n-0.5,36\n0,36\n2,36\n", [999.5, 1000.0, 1002.0]),
    ],
    ids=["Latin-1 and blanks", "units", "slower signal", "dates", "from zero"],
)
def test_tables_as_strangers_write_them_are_read(tmp_path: Path, text: str, stamps: list[float]) -> None:
    signal_map, source = tmp_path / "map.yaml", tmp_path / "drive.csv"
    signal_map.write_text(TABLE_MAP)
    source.write_text(text, encoding="latin-1")
    assert main(["import", str(source), "--map", str(signal_map), "--out", str(tmp_path / "bag")]) == 0
    with BagReader(tmp_path / "bag") as reader:
        found = [
            (stamp, deserialize_message(data, message_class(topic.type))) for topic, stamp, data in reader.messages()
        ]
    assert [stamp / 1e9 for stamp, _ in found] == pytest.approx(stamps)
    assert all(isclose(message.twist.twist.linear.x, 10.0) for _, message in found)


def test_a_text_among_the_values_is_named_with_line_and_column(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    signal_map, source = tmp_path / "map.yaml", tmp_path / "drive.csv"
    signal_map.write_text(TABLE_MAP)
    source.write_text("time,v [km/h]\n1.5,36\n1.6,none\n1.7,-\n1.8,36\n")
    assert main(["import", str(source), "--map", str(signal_map), "--out", str(tmp_path / "bag")]) == 1
    assert "line 3: 'v [km/h]' is 'none': no number, 2 times" in capsys.readouterr().err
    with BagReader(tmp_path / "bag") as reader:
        assert reader.message_count == 2


def test_what_cannot_be_used_of_a_table_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    signal_map, source = tmp_path / "map.yaml", tmp_path / "drive.csv"
    signal_map.write_text(TABLE_MAP)
    source.write_text("time,v [km/h]\n1,36\n-1,36\n")
    assert main(["import", str(source), "--map", str(signal_map), "--out", str(tmp_path / "bag")]) == 1
    said = capsys.readouterr().err
    assert "stamp that no message can hold, 1 times" in said
    assert "nothing can be estimated without 'wheel_speed'" in said


@pytest.mark.parametrize("given", [["drive.csv"], ["no_map", "drive.csv"], ["bmw", "a.csv", "b.csv"]])
def test_a_log_without_map_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str], given: list[str]) -> None:
    assert main(["import", *given, "--out", str(tmp_path / "bag")]) == 2
    assert "give LOG --map MAP, or one of " in capsys.readouterr().err


def test_commas_are_decimal_points_where_semicolons_separate(tmp_path: Path) -> None:
    signal_map, source = tmp_path / "map.yaml", tmp_path / "drive.csv"
    signal_map.write_text(TABLE_MAP)
    source.write_text("time;v [km/h]\n1700000000,25;36,0\n1700000000,75;37,5\n")
    assert main(["import", str(source), "--map", str(signal_map), "--out", str(tmp_path / "bag")]) == 0
    with BagReader(tmp_path / "bag") as reader:
        assert sum(reader.counts.values()) == 2
        assert isclose((reader.end - reader.start) * 1e-9, 0.5, abs_tol=1e-6)


STARTS = {"zero": 0.0, "2023": 1.7e9}


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("unit", ["s", "ms", "us", "ns", "days"])
@pytest.mark.parametrize("step", [0.005, 0.01, 0.1])
def test_the_unit_of_times_is_recognised(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], step: float, unit: str, start: str
) -> None:
    is_serial_date = (unit, start) == ("days", "2023")  # as spreadsheets have
    start_in_unit = 45244.0 if is_serial_date else STARTS[start] * 1e9 / STAMP_UNITS[unit]
    signal_map, source = tmp_path / "map.yaml", tmp_path / "drive.csv"
    signal_map.write_text(TABLE_MAP)
    times = [start_in_unit + step * k * 1e9 / STAMP_UNITS[unit] for k in range(200)]
    source.write_text("time,v [km/h]\n" + "".join(f"{time:.12f},36\n" for time in times))
    assert main(["import", str(source), "--map", str(signal_map), "--out", str(tmp_path / "bag")]) == 0
    said = capsys.readouterr().err
    assert (unit == "s") != (f"are taken for {unit}" in said)
    with BagReader(tmp_path / "bag") as reader:
        assert isclose((reader.end - reader.start) * 1e-9, step * 199, rel_tol=1e-3)
        assert start == "zero" or abs(reader.start * 1e-9 - 1.7e9) < 86400.0


def test_a_unit_of_times_is_that_of_the_map_of_the_name_or_of_the_line_below_it(tmp_path: Path) -> None:
    rows = "".join(f"{k},36\n" for k in range(1, 200))
    for place, (key, text) in enumerate(
        [("stamp_unit: ms\n", "time,v [km/h]\n"), ("", "Time [ms],v [km/h]\n"), ("", "time,v [km/h]\nms,km/h\n")]
    ):
        signal_map, source = tmp_path / f"map{place}.yaml", tmp_path / f"drive{place}.csv"
        signal_map.write_text(key + TABLE_MAP.replace("stamp: time\n", ""))
        source.write_text(text + rows)
        assert main(["import", str(source), "--map", str(signal_map), "--out", str(tmp_path / f"bag{place}")]) == 0
        with BagReader(tmp_path / f"bag{place}") as reader:
            assert isclose((reader.end - reader.start) * 1e-9, 0.198, rel_tol=1e-3)


def test_times_of_no_drive_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    signal_map, source = tmp_path / "map.yaml", tmp_path / "drive.csv"
    signal_map.write_text(TABLE_MAP)
    source.write_text("time,v [km/h]\n" + "".join(f"{1e-11 * k},36\n" for k in range(1, 100)))
    command = ["import", str(source), "--map", str(signal_map), "--out", str(tmp_path / "bag")]
    assert main(command) == 2
    assert "the times in column 'time' are 1e-11 apart: give 'stamp_unit'" in capsys.readouterr().err
    source.write_text("time_ms,v [km/h]\n" + "".join(f"{1e-3 * k},36\n" for k in range(1, 100)))
    signal_map.write_text(TABLE_MAP.replace("stamp: time\n", ""))
    assert main(command) == 2
    assert "are 0.001 apart, and not in ms: give 'stamp_unit'" in capsys.readouterr().err
    source.write_text("time,v [km/h]\n" + "".join(f"{k},36\n" for k in range(1, 100)))  # ms, or a slow log
    signal_map.write_text(TABLE_MAP)
    assert main(command) == 2
    assert "are 1 apart: give 'stamp_unit'" in capsys.readouterr().err
    signal_map.write_text("stamp_unit: s\n" + TABLE_MAP)
    assert main(command) == 0


@pytest.mark.parametrize("name", ["t", "Time", "time [s]", "TIMESTAMP", "stamp", "Time (s)", "time_s"])
def test_the_column_of_the_time_is_found(tmp_path: Path, name: str) -> None:
    signal_map, source = tmp_path / "map.yaml", tmp_path / "drive.csv"
    signal_map.write_text(TABLE_MAP.replace("stamp: time\n", ""))
    source.write_text(f"gear,{name},v [km/h]\n1,1.5,36\n")
    assert main(["import", str(source), "--map", str(signal_map), "--out", str(tmp_path / "bag")]) == 0


@pytest.mark.parametrize(
    ("names", "said"), [("a", "no column is the time"), ("t,time", "several columns may be that of the time, t, time")]
)
def test_a_table_without_one_column_of_the_time_asks_for_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], names: str, said: str
) -> None:
    signal_map, source = tmp_path / "map.yaml", tmp_path / "drive.csv"
    signal_map.write_text(TABLE_MAP.replace("stamp: time\n", ""))
    source.write_text(f"{names},v [km/h]\n1,1,36\n")
    assert main(["import", str(source), "--map", str(signal_map), "--out", str(tmp_path / "bag")]) == 2
    text = capsys.readouterr().err
    assert said in text
    assert "give 'stamp: COLUMN'" in text


MOTEC = """"Format","MoTeC CSV File"
"Venue","Somewhere, far"
"Sample Rate","100.000","Hz"

"Time","v [km/h]","Gear"
"s","km/h",""


"1.50","36.0","3"
"1.51","36.0","3"
"""


@pytest.mark.parametrize(
    ("text", "encoding"),
    [
        (MOTEC, "utf-8"),
        ("time;v [km/h]\n1,50;36,0\n1,51;36,0\n", "utf-16"),
        ("time\tv [km/h]\n1,50\t36,0\n1,51\t36,0\n", "utf-16-le"),
        (
            "Nr. 7;\n\ntime;v [km/h];Weg\n01.01.1970 00:00:01,50;36,0;1.234,5\n1.1.1970 0:00:01,51;36;0\n",
            "latin-1",
        ),
        ("time v [km/h]\n".replace(" v", "\tv") + "00:00:01.50\t36\n00:00:01.51\t36\n", "utf-8"),
        ("time|v [km/h]\r\n1970/01/01 00:00:01.50|36\r\n1970/01/01 00:00:01.51|36\r\n", "utf-8-sig"),
    ],
    ids=["MoTeC", "UTF-16", "UTF-16 without mark", "dates of points", "times of day", "bars"],
)
def test_texts_of_other_tools_give_the_same_two_rows(tmp_path: Path, text: str, encoding: str) -> None:
    signal_map, source = tmp_path / "map.yaml", tmp_path / "drive.csv"
    signal_map.write_text(TABLE_MAP.replace("stamp: time\n", ""))
    source.write_bytes(text.encode(encoding))
    assert main(["import", str(source), "--map", str(signal_map), "--out", str(tmp_path / "bag")]) == 0
    with BagReader(tmp_path / "bag") as reader:
        found = [
            (stamp, deserialize_message(data, message_class(topic.type))) for topic, stamp, data in reader.messages()
        ]
    assert [stamp / 1e9 for stamp, _ in found] == pytest.approx([1.5, 1.51])
    assert all(isclose(message.twist.twist.linear.x, 10.0) for _, message in found)


def test_nothing_is_left_of_an_import_that_failed_at_once(tmp_path: Path) -> None:
    signal_map, source = tmp_path / "map.yaml", tmp_path / "drive.csv"
    signal_map.write_text(TABLE_MAP)
    source.write_text("time,v [km/h]\n1,fast\n")
    command = ["import", str(source), "--map", str(signal_map), "--out", str(tmp_path / "bag")]
    assert main(command) == 2
    assert not (tmp_path / "bag").exists()
    source.write_text("time,v [km/h]\n1,36\n")
    assert main(command) == 0
