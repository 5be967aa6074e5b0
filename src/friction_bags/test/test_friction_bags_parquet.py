"""Parquet tables through a signal map; `make parquet` installs what this needs."""

import sys
from math import isclose, nan
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from friction_adapter.map_file import load_map
from friction_bags.__main__ import main
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.importers.table import ParquetTable
from friction_parameters.parameter import ParameterError

MAP = """vehicle: compact_car
stamp: time
signals:
  speed: {from: {column: v}, unit: km/h}
  acceleration: {from: {column: a}, unit: g}
"""
ROWS = 12_000
"""More than are read at once."""


def written(directory: Path) -> Path:
    path = directory / "map.yaml"
    path.write_text(MAP)
    return path


def test_without_pyarrow_the_line_that_installs_it_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(ParameterError, match="python3 -m pip install pyarrow"):
        ParquetTable(tmp_path / "drive.parquet", load_map(written(tmp_path)))


class TestWithPyarrow:
    @pytest.fixture(autouse=True)
    def needs_pyarrow(self) -> None:
        pytest.importorskip("pyarrow", reason="pyarrow is absent: make parquet")

    def table(self, path: Path, **more: Any) -> Path:
        import pyarrow
        from pyarrow import parquet

        columns = {"time": 5.0 + 0.01 * np.arange(ROWS), "v": np.full(ROWS, 36.0, np.float32), "gear": ["D"] * ROWS}
        columns |= {"a": [None if k == 7 else -0.5 for k in range(ROWS)], **more}
        parquet.write_table(pyarrow.table(columns), path)
        return path

    def test_a_table_is_the_bag_of_the_same_table_as_csv(self, tmp_path: Path) -> None:
        source, bags = self.table(tmp_path / "drive.parquet"), []
        text = "\n".join(f"{5.0 + 0.01 * k!r},36.0,{nan if k == 7 else -0.5}" for k in range(ROWS))
        (tmp_path / "drive.csv").write_text(f"time,v,a\n{text}\n")
        for log in (source, tmp_path / "drive.csv"):
            bag = tmp_path / f"bag{log.suffix}"
            assert main(["import", str(log), "--map", str(written(tmp_path)), "--out", str(bag)]) == 0
            with BagReader(bag) as reader:
                bags.append([(stamp, topic.name, bytes(data)) for topic, stamp, data in reader.messages()])
        assert bags[0] == bags[1]
        assert len(bags[0]) == 2 * ROWS - 1  # the empty cell

    def test_stamps_may_be_times(self, tmp_path: Path) -> None:
        times = np.datetime64("2023-11-14T22:13:20") + 10 * np.arange(ROWS).astype("timedelta64[ms]")
        source = self.table(tmp_path / "drive.parquet", time=times)
        assert main(["import", str(source), "--map", str(written(tmp_path)), "--out", str(tmp_path / "bag")]) == 0
        with BagReader(tmp_path / "bag") as reader:
            stamps = [stamp for topic, stamp, _ in reader.messages() if topic.name == "/vehicle_velocity"]
        assert isclose(stamps[1] * 1e-9, 1_700_000_000.01, rel_tol=1e-15)

    def test_columns_that_are_none_and_files_that_are_none_are_refused(
        self, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        source, out = self.table(tmp_path / "drive.parquet", v=["fast"] * ROWS), str(tmp_path / "bag")
        assert main(["import", str(source), "--map", str(written(tmp_path)), "--out", out]) == 2
        assert "column 'v' does not hold numbers" in capsys.readouterr().err
        written(tmp_path).write_text(MAP.replace("column: v", "column: speed"))
        assert main(["import", str(source), "--map", str(tmp_path / "map.yaml"), "--out", out]) == 2
        assert "there is no column 'speed': time, v, gear, a" in capsys.readouterr().err
        source.write_bytes(b"no table")
        assert main(["import", str(source), "--map", str(written(tmp_path)), "--out", out]) == 2
        assert "cannot be read" in capsys.readouterr().err
