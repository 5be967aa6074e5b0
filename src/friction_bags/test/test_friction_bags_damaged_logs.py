"""Logs of every kind, cut off anywhere or with bytes that flipped: an exit code and a sentence, never a crash."""

import random
import struct
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from friction_bags.__main__ import main
from friction_bags.bag_io.bag_reader import BagReader

CAR = Path(__file__).parents[2] / "friction_adapter" / "test" / "four_wheels.yaml"
WHEELS = ("FL", "FR", "RL", "RR")
COUNT = 200
CUTS, FLIPS = 20, 40
DBC = 'VERSION ""\nBU_: E\nBO_ 416 Wheels: 8 E\n' + "".join(
    f' SG_ V_{wheel} : {16 * place}|16@1+ (0.01,0) [0|655.35] "km/h" E\n' for place, wheel in enumerate(WHEELS)
)
MAPS = {
    "can": f'vehicle: {CAR}\ncan: {{dbc: car.dbc}}\nsignals:\n  wheel_speed: {{from: {{can: "V_{{wheel}}"}}}}\n',
    "table": f'vehicle: {CAR}\nsignals:\n  wheel_speed: {{from: {{column: "V_{{wheel}}"}}, unit: km/h}}\n',
}


def speeds(k: int) -> list[int]:
    return [3600 + (7 * k + 13 * place) % 50 for place in range(4)]


def with_python_can(path: Path) -> None:
    can = pytest.importorskip("can", reason="python-can is absent: python3 -m pip install python-can cantools")
    with can.Logger(path) as log:
        for k in range(COUNT):
            data = struct.pack("<4H", *speeds(k))
            log.on_message_received(
                can.Message(timestamp=1.7e9 + 0.01 * k, arbitration_id=416, is_extended_id=False, data=data, channel=0)
            )


def savvycan(path: Path) -> None:
    rows = (
        f"{10_000 * k},000001A0,false,Rx,0,8,{struct.pack('<4H', *speeds(k)).hex(',').upper()},\n" for k in range(COUNT)
    )
    path.write_text("Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8\n" + "".join(rows))


def candump(path: Path) -> None:
    rows = (
        f" ({1.7e9 + 0.01 * k:.6f})  can0  1A0   [8]  {struct.pack('<4H', *speeds(k)).hex(' ')}\n" for k in range(COUNT)
    )
    path.write_text("".join(rows))


def table(path: Path) -> None:
    rows = (f"{1.7e9 + 0.01 * k:.3f}," + ",".join(f"{0.01 * each:.2f}" for each in speeds(k)) for k in range(COUNT))
    path.write_text("time,V_FL,V_FR,V_RL,V_RR\n" + "\n".join(rows) + "\n")


def parquet(path: Path) -> None:
    pyarrow = pytest.importorskip("pyarrow", reason="pyarrow is absent: python3 -m pip install pyarrow")
    columns = {"time": [1.7e9 + 0.01 * k for k in range(COUNT)]}
    columns |= {f"V_{wheel}": [0.01 * speeds(k)[place] for k in range(COUNT)] for place, wheel in enumerate(WHEELS)}
    from pyarrow import parquet as files

    files.write_table(pyarrow.table(columns), path)


LOGS: dict[str, tuple[str, Callable[[Path], None]]] = {
    **{f"drive{suffix}": ("can", with_python_can) for suffix in (".blf", ".asc", ".log", ".trc", ".csv")},
    "savvycan.csv": ("can", savvycan),
    "candump.txt": ("can", candump),
    "table.csv": ("table", table),
    "table.parquet": ("table", parquet),
}


@pytest.fixture(params=LOGS)
def log(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[Path, Path]:
    """A sound log and its map."""
    kind, write = LOGS[request.param]
    if kind == "can":
        pytest.importorskip("cantools", reason="cantools is absent: python3 -m pip install python-can cantools")
    (tmp_path / "car.dbc").write_text(DBC)
    (tmp_path / "map.yaml").write_text(MAPS[kind])
    write(tmp_path / request.param)
    return tmp_path / request.param, tmp_path / "map.yaml"


def numbers() -> Iterator[int]:
    """Numbers of the bags of a test."""
    number = 0
    while True:
        yield number
        number += 1


def imported(data: bytes, log: Path, signal_map: Path, number: int) -> tuple[int, int]:
    """Return exit code and messages of a log with this content."""
    damaged = log.with_name(f"damaged_{log.name}")
    damaged.write_bytes(data)
    bag = log.with_name(f"bag{number}")
    code = main(["import", str(damaged), "--map", str(signal_map), "--out", str(bag)])
    assert code in (0, 1, 2)
    if not bag.exists():
        return code, 0
    with BagReader(bag) as reader:
        return code, reader.message_count


def test_a_log_that_is_cut_off_is_no_success(log: tuple[Path, Path]) -> None:
    whole = log[0].read_bytes()
    number = numbers()
    assert imported(whole, *log, next(number)) == (0, COUNT)
    generator = random.Random(1)
    for k in range(CUTS):
        place = int(len(whole) * (k + generator.random()) / CUTS)
        code, count = imported(whole[:place], *log, next(number))
        assert code != 0 or count == COUNT or whole[:place].endswith(b"\n"), place


def test_flipped_bits_crash_nothing(log: tuple[Path, Path]) -> None:
    whole = log[0].read_bytes()
    generator = random.Random(2)
    for k in range(FLIPS):
        damaged = bytearray(whole)
        for _ in range(generator.choice((1, 2, 8))):
            damaged[generator.randrange(len(damaged))] ^= 1 << generator.randrange(8)
        imported(bytes(damaged), *log, k)
