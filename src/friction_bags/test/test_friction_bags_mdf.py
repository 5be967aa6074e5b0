"""MDF logs through a signal map; `make mdf` installs what this needs."""

import sys
from math import isclose
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from friction_adapter.map_file import load_map
from friction_bags.__main__ import main
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.cdr import decode
from friction_runtime.installed import message_class

MAP = """vehicle: compact_car
signals:
  wheel_speed: {from: {can: "V_{wheel}"}}
  brake_pressure: {from: can, fields: {front: P}, latency: 0.01}
"""
WHEELS = ("front_left", "front_right", "rear_left", "rear_right")


def written(directory: Path, text: str = MAP) -> Path:
    path = directory / "map.yaml"
    path.write_text(text)
    return path


def test_without_asammdf_the_line_that_installs_it_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "asammdf", None)
    log = tmp_path / "drive.mf4"
    log.write_bytes(b"MDF     4.10")
    assert main(["import", str(log), "--map", str(written(tmp_path)), "--out", str(tmp_path / "bag")]) == 2
    assert "python3 -m pip install asammdf" in capsys.readouterr().err


class TestWithAsammdf:
    @pytest.fixture(autouse=True)
    def needs_asammdf(self) -> None:
        pytest.importorskip("asammdf", reason="asammdf is absent: make mdf")

    def log(self, path: Path, version: str) -> Path:
        """Wheel speeds [km/h] at 100 Hz, all of one group, and a pressure [bar] at 50 Hz; a channel twice."""
        from asammdf import MDF, Signal

        times = np.arange(20) * 0.01
        speeds = [Signal(72.0 - np.arange(20), times, "km/h", f"V_{wheel}") for wheel in WHEELS]
        with MDF(version=version) as mdf:
            mdf.append(speeds, common_timebase=True)
            mdf.append([Signal(np.full(10, 80.0), times[::2], "bar", "P")], common_timebase=True)
            for _ in range(2):
                mdf.append([Signal(np.zeros(3), times[:3], "", "Twice")], common_timebase=True)
            saved: Any = mdf.save(path, overwrite=True)
        return Path(saved)

    @pytest.mark.parametrize(("name", "version"), [("drive.mf4", "4.10"), ("drive.mdf", "3.30")])
    def test_channels_become_signals(self, tmp_path: Path, name: str, version: str) -> None:
        log, bag = self.log(tmp_path / name, version), tmp_path / "bag"
        assert main(["import", str(log), "--map", str(written(tmp_path)), "--out", str(bag)]) == 0
        found: dict[str, list[Any]] = {}
        with BagReader(bag) as reader:
            for topic, _, data in reader.messages():
                found.setdefault(topic.name, []).append(decode(data, message_class(topic.type)))
        assert {topic: len(each) for topic, each in found.items()} == {
            "/wheel_states": 20,
            "/front_left/brake_pressure": 10,
            "/front_right/brake_pressure": 10,
        }
        radius = load_map(written(tmp_path)).vehicle.wheel("front_left").radius
        for k, wheels in enumerate(found["/wheel_states"]):
            assert (wheels.header.stamp.sec, wheels.header.stamp.nanosec) == (1000, k * 10_000_000)
            assert isclose(wheels.velocity[0], (72.0 - k) / 3.6 / radius)
        pressure = found["/front_left/brake_pressure"][1]
        assert (pressure.header.stamp.nanosec, pressure.fluid_pressure) == (10_000_000, 8e6)

    @pytest.mark.parametrize(
        ("old", "new", "said"),
        [
            ("front: P", "front: Q", "has no channel 'Q': there are"),
            ("front: P", "front: Twice", "several channels have the name 'Twice': 2.Twice, 3.Twice"),
            ("latency: 0.01", "unit: Pa", "its unit is Pa here, and bar where it comes from"),
        ],
    )
    def test_a_map_that_does_not_fit_is_refused(
        self, tmp_path: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, said: str
    ) -> None:
        log = self.log(tmp_path / "drive.mf4", "4.10")
        signal_map = written(tmp_path, MAP.replace(old, new))
        assert main(["import", str(log), "--map", str(signal_map), "--out", str(tmp_path / "bag")]) == 2
        assert said in capsys.readouterr().err

    def test_a_file_that_is_no_log_is_refused(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        (tmp_path / "drive.mf4").write_bytes(b"no log" * 100)
        given = ["import", str(tmp_path / "drive.mf4"), "--map", str(written(tmp_path)), "--out", str(tmp_path / "bag")]
        assert main(given) == 2
        assert "drive.mf4 cannot be read" in capsys.readouterr().err
