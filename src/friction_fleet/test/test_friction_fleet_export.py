"""Maps as files: the cells come back, the page needs no network, zones are those of slippery neighbours."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

pytest.importorskip("h3")
pytest.importorskip("pyarrow")

from friction_fleet.__main__ import main
from friction_fleet.cells import cell_of, neighbours
from friction_fleet.export import geojson, page, read_parquet, vss, write_parquet, zones
from friction_fleet.fusion import CellFriction

HERE = cell_of(48.1, 11.5)
STAMP = 1_768_478_400.0
"""2026-01-15 12:00 UTC"""


def cell(number: int, slippery: float, median: float) -> CellFriction:
    return CellFriction(number, 0.8 * median, median, 1.2 * median, slippery, 600.0, 7, 2, 3)


FAR = cell_of(48.2, 11.5)
CELLS = [
    cell(HERE, 0.9, 0.2),
    cell(neighbours(HERE)[0], 0.8, 0.3),
    cell(FAR, 0.7, 0.1),
    cell(cell_of(48.3, 11.5), 0.0, 1.0),
]


def test_slippery_cells_that_touch_are_a_zone() -> None:
    assert sorted(map(len, zones(CELLS))) == [1, 2]
    features = geojson(CELLS, STAMP)["features"]
    assert [each["properties"]["kind"] for each in features] == ["cell"] * 4 + ["temporary slippery road"] * 2
    ring = features[0]["geometry"]["coordinates"][0]
    assert ring[0] == ring[-1] and len(ring) == 7
    assert all(abs(x - 11.5) < 0.01 and abs(y - 48.1) < 0.01 for x, y in ring)


def test_a_map_comes_back_from_its_file_and_leaves_as_signals(tmp_path: Path) -> None:
    write_parquet(tmp_path / "map.parquet", CELLS, STAMP)
    assert read_parquet(tmp_path / "map.parquet") == (CELLS, STAMP)
    assert main(["export", str(tmp_path / "map.parquet"), "--vss", str(tmp_path / "signals.jsonl")]) == 0
    lines = [json.loads(line) for line in (tmp_path / "signals.jsonl").read_text().splitlines()]
    assert lines == vss(CELLS, STAMP)
    assert lines[0]["Vehicle.ADAS.ESC.RoadFriction.MostProbable"] == 20.0
    assert lines[0]["ts"] == "2026-01-15T11:50:00+00:00"  # of the last evidence
    assert lines[3]["Vehicle.ADAS.ESC.RoadFriction.UpperBound"] == 100.0  # 1.2 is more than the catalogue has


def test_the_page_holds_the_cells_and_asks_no_network() -> None:
    text = page(CELLS, STAMP)
    assert not re.findall(r"(?:src|href)=|https?://(?!www\.w3\.org/2000/svg)|fetch\(|import ", text)
    (data,) = re.findall(r"^const data = (.*);$", text, re.MULTILINE)
    read = json.loads(data)
    assert [each["cell"] for each in read["cells"]] == [f"{each.cell:x}" for each in CELLS]
    assert read["cells"][0]["lower"] == 0.16
