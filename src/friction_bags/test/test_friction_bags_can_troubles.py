"""CAN logs that are cut off, relative, of several buses or of another car: read as far as they go, and reported."""

import struct
from collections.abc import Sequence
from pathlib import Path

import pytest

from friction_bags.__main__ import main
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.importers.blf_objects import Objects, count_objects

can = pytest.importorskip("can", reason="python-can is absent: python3 -m pip install python-can cantools")
pytest.importorskip("cantools")

DBC = 'VERSION ""\nBU_: E\nBO_ 416 Wheels: 8 E\n' + "".join(
    f' SG_ V_{wheel} : {16 * place}|16@1+ (0.01,0) [0|655.35] "km/h" E\n'
    for place, wheel in enumerate(("FL", "FR", "RL", "RR"))
)
CAR = Path(__file__).parents[2] / "friction_adapter" / "test" / "four_wheels.yaml"
COUNT = 300
SPEEDS = struct.pack("<4H", 3600, 3600, 3600, 3600)


@pytest.fixture
def signal_map(tmp_path: Path) -> Path:
    (tmp_path / "car.dbc").write_text(DBC)
    path = tmp_path / "map.yaml"
    path.write_text(
        f'vehicle: {CAR}\ncan: {{dbc: car.dbc}}\nsignals:\n  wheel_speed: {{from: {{can: "V_{{wheel}}"}}}}\n'
    )
    return path


def logged(path: Path, channels: Sequence[int] = (0,), identifier: int = 416) -> Path:
    with can.Logger(path) as log:
        for k in range(COUNT):
            for channel in channels:
                log.on_message_received(
                    can.Message(
                        timestamp=1.7e9 + 0.01 * k,
                        arbitration_id=identifier,
                        is_extended_id=False,
                        data=SPEEDS,
                        channel=channel,
                    )
                )
    return path


def imported(log: Path, signal_map: Path, bag: Path) -> tuple[int, int, float]:
    """Return exit code, messages and duration [s]."""
    code = main(["import", str(log), "--map", str(signal_map), "--out", str(bag)])
    with BagReader(bag) as reader:
        return code, sum(reader.counts.values()), (reader.end - reader.start) * 1e-9


def asc(path: Path, times: Sequence[float], relative: bool) -> Path:
    data = SPEEDS.hex(" ").upper()
    head = f"date Sat Sep 30 15:06:13.191 2017\nbase hex  timestamps {'relative' if relative else 'absolute'}\n"
    head += "no internal events logged\n"
    path.write_text(head + "".join(f"{time:11.6f} 1  1A0             Rx   d 8 {data}\n" for time in times))
    return path


def test_stamps_of_an_asc_log_that_are_relative_are_summed_up(tmp_path: Path, signal_map: Path) -> None:
    log = asc(tmp_path / "drive.asc", [0.01] * COUNT, relative=True)
    code, count, duration = imported(log, signal_map, tmp_path / "bag")
    assert (code, count) == (0, COUNT)
    assert duration == pytest.approx(0.01 * (COUNT - 1))


def test_stamps_before_the_beginning_of_an_asc_log_are_read(tmp_path: Path, signal_map: Path) -> None:
    log = asc(tmp_path / "drive.asc", [0.01 * (k - 5) for k in range(COUNT)], relative=False)
    code, count, duration = imported(log, signal_map, tmp_path / "bag")
    assert (code, count) == (0, COUNT)
    assert duration == pytest.approx(0.01 * (COUNT - 1))


def test_a_log_that_is_cut_off_anywhere_says_so(
    tmp_path: Path, signal_map: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = logged(tmp_path / "whole.blf").read_bytes()
    assert count_objects(tmp_path / "whole.blf") == Objects(COUNT, COUNT + 1, True)
    for place in range(200, len(whole), len(whole) // 10):
        log = tmp_path / f"cut{place}.blf"
        log.write_bytes(whole[:place])
        code = main(["import", str(log), "--map", str(signal_map), "--out", str(tmp_path / f"bag{place}")])
        said = capsys.readouterr().err
        assert code == 2 or (code == 1 and f"its header states {COUNT}" in said)


def test_an_object_without_a_size_is_refused(tmp_path: Path, signal_map: Path) -> None:
    whole = bytearray(logged(tmp_path / "whole.blf").read_bytes())
    place = whole.index(b"LOBJ")
    whole[place + 8 : place + 12] = bytes(4)
    (tmp_path / "drive.blf").write_bytes(whole)
    assert main(["import", str(tmp_path / "drive.blf"), "--map", str(signal_map), "--out", str(tmp_path / "b")]) == 2


def test_frames_of_two_buses_are_told_apart_by_the_map(
    tmp_path: Path, signal_map: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = logged(tmp_path / "drive.blf", channels=(0, 1))
    assert imported(log, signal_map, tmp_path / "both")[0] == 1
    assert "frame Wheels comes on the buses 0, 1: 'can: {bus: N}'" in capsys.readouterr().err
    signal_map.write_text(signal_map.read_text().replace("car.dbc}", "car.dbc, bus: 1}"))
    assert imported(log, signal_map, tmp_path / "one")[:2] == (0, COUNT)


def test_a_log_without_a_frame_of_the_map_is_no_success(
    tmp_path: Path, signal_map: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = logged(tmp_path / "drive.blf", identifier=417)
    assert main(["import", str(log), "--map", str(signal_map), "--out", str(tmp_path / "bag")]) == 2
    assert not (tmp_path / "bag").exists()
    said = capsys.readouterr().err
    assert "frame Wheels (1A0) is not in the log; the nearest that is there is 1A1" in said
    assert "'wheel_speed' of FL has not one value" in said


def gvret(path: Path, count: int = COUNT) -> Path:
    """What SavvyCAN writes, with a comma at the end of each line."""
    rows = (f"{10_000 * k},000001A0,false,Rx,0,8,{SPEEDS.hex(',').upper()},\n" for k in range(count))
    path.write_text("Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8\n" + "".join(rows))
    return path


def printed(path: Path, stamps: Sequence[str]) -> Path:
    """What candump prints with times, and a remote frame of another identifier in between."""
    data = SPEEDS.hex(" ").upper()
    rows = [f" ({stamp})  can0  1A0   [8]  {data}\n" for stamp in stamps]
    path.write_text("".join([*rows[:1], f" ({stamps[0]})  can0  1FFFFFFF   [0]  remote request\n", *rows[1:]]))
    return path


def test_a_table_of_savvycan_is_read(tmp_path: Path, signal_map: Path) -> None:
    code, count, duration = imported(gvret(tmp_path / "drive.csv"), signal_map, tmp_path / "bag")
    assert (code, count) == (0, COUNT)
    assert duration == pytest.approx(0.01 * (COUNT - 1))


@pytest.mark.parametrize(
    "stamps",
    [
        [f"{1.7e9 + 0.01 * k:.6f}" for k in range(COUNT)],
        [f"{0.01 * k:010.6f}" for k in range(COUNT)],
        ["000.000000", *(["000.012000", "000.008000"] * COUNT)[: COUNT - 1]],
        [f"2023-11-14 22:13:2{k // 100}.{10_000 * (k % 100):06d}" for k in range(COUNT)],
    ],
    ids=["-ta", "-tz", "-td", "-tA"],
)
def test_what_candump_prints_is_read(tmp_path: Path, signal_map: Path, stamps: list[str]) -> None:
    code, count, duration = imported(printed(tmp_path / "drive.txt", stamps), signal_map, tmp_path / "bag")
    assert (code, count) == (0, COUNT)
    assert duration == pytest.approx(0.01 * (COUNT - 1), abs=0.005)


def test_what_candump_prints_without_times_is_refused(
    tmp_path: Path, signal_map: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "drive.log").write_text(f"  can0  1A0   [8]  {SPEEDS.hex(' ')}\n" * 5)
    assert main(["import", str(tmp_path / "drive.log"), "--map", str(signal_map), "--out", str(tmp_path / "b")]) == 2
    assert "its frames have no times: log with `candump -L` or `candump -ta`" in capsys.readouterr().err


def test_lines_that_are_no_frames_are_counted(
    tmp_path: Path, signal_map: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = gvret(tmp_path / "drive.csv")
    lines = log.read_text().splitlines(keepends=True)
    lines[7] = "70000,000001A0,false,Rx,0,8,10,\n"
    lines[9] = "rebooted\n"
    log.write_text("".join(lines))
    assert imported(log, signal_map, tmp_path / "bag")[:2] == (1, COUNT - 2)
    assert "line that is no frame, 2 times" in capsys.readouterr().err


def busmaster(path: Path, mode: str) -> Path:
    head = f"***BUSMASTER Ver 3.2.2***\n***PROTOCOL CAN***\n***HEX***\n***{mode} MODE***\n***START DATE AND TIME ***\n"
    data = SPEEDS.hex(" ").upper()
    hours = "17:27" if mode == "SYSTEM" else "00:00"
    times = [10 * k if mode == "SYSTEM" else 10 * min(k, 1) for k in range(COUNT)]
    rows = [f"{hours}:{at // 1000:02d}:{at % 1000:03d} Rx 1 0x1A0 s 8 {data} \n" for at in times]
    path.write_text(head + "".join(rows) + "***[STOP LOGGING SESSION]***\n")
    return path


@pytest.mark.parametrize("mode", ["SYSTEM", "RELATIVE"])
def test_a_log_of_busmaster_is_read(tmp_path: Path, signal_map: Path, mode: str) -> None:
    code, count, duration = imported(busmaster(tmp_path / "drive.log", mode), signal_map, tmp_path / "bag")
    assert (code, count) == (0, COUNT)
    assert duration == pytest.approx(0.01 * (COUNT - 1), abs=1e-3)


@pytest.mark.parametrize(
    "fault",
    [
        'CM_ SG_ 416 "no name of a signal";\n',
        ' SG_ X : 0|8@1+ (.,0) [0|1] "" E\n',
        'BO_ 1000000 Wide: 8 E\n SG_ W : 0|8@1+ (1,0) [0|1] "" E\n',
        'BO_ 900 3D: 8 E\n SG_ 2W : 0|8@1+ (1,0) [0|1] "" E\n',
    ],
    ids=["comment", "signal", "identifier", "name"],
)
def test_what_a_database_has_wrong_elsewhere_is_said_and_no_reason_to_refuse_it(
    tmp_path: Path, signal_map: Path, capsys: pytest.CaptureFixture[str], fault: str
) -> None:
    other = 'BO_ 417 Other: 8 E\n SG_ Y : 0|8@1+ (1,0) [0|1] "" E\n'
    (tmp_path / "car.dbc").write_text(f"{DBC}\n{other}{fault}")
    log = logged(tmp_path / "drive.blf")
    assert imported(log, signal_map, tmp_path / "bag")[:2] == (0, COUNT)
    assert "only the frames that the map names must be sound" in capsys.readouterr().err


@pytest.mark.parametrize("suffix", [".blf", ".asc", ".log", ".trc", ".csv"])
def test_a_log_is_known_by_its_content(tmp_path: Path, signal_map: Path, suffix: str) -> None:
    log = logged(tmp_path / f"drive{suffix}").rename(tmp_path / "drive.txt")
    assert imported(log, signal_map, tmp_path / "bag")[:2] == (0, COUNT)


def test_a_bus_that_is_not_in_the_log_is_named_with_those_that_are(
    tmp_path: Path, signal_map: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = logged(tmp_path / "drive.blf", channels=(0, 1))
    signal_map.write_text(signal_map.read_text().replace("car.dbc}", "car.dbc, bus: 7}"))
    assert main(["import", str(log), "--map", str(signal_map), "--out", str(tmp_path / "bag")]) == 2
    assert "there is no bus 7: the buses are 0, 1" in capsys.readouterr().err


def test_frames_in_an_mf4_log_are_those_of_a_can_log(tmp_path: Path, signal_map: Path) -> None:
    pytest.importorskip("asammdf", reason="asammdf is absent: python3 -m pip install asammdf")
    code, count, duration = imported(logged(tmp_path / "drive.mf4"), signal_map, tmp_path / "bag")
    assert (code, count) == (0, COUNT)
    assert duration == pytest.approx(0.01 * (COUNT - 1), abs=1e-3)


@pytest.mark.parametrize(
    ("begin", "said"), [(b"PK\x03\x04", "spreadsheet"), (b"\x1f\x8b", "gzip"), (b"\xd0\xcf\x11\xe0", "spreadsheet")]
)
def test_what_is_not_read_is_named_as_what_it_is(
    tmp_path: Path, signal_map: Path, capsys: pytest.CaptureFixture[str], begin: bytes, said: str
) -> None:
    (tmp_path / "drive.csv").write_bytes(begin + bytes(range(256)))
    assert main(["import", str(tmp_path / "drive.csv"), "--map", str(signal_map), "--out", str(tmp_path / "b")]) == 2
    assert said in capsys.readouterr().err
