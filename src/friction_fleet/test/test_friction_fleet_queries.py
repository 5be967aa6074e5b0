"""The queries of the README, on tables with known answers."""

from __future__ import annotations

import re
from datetime import date, datetime, timezone
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("pyarrow")
pytest.importorskip("fsspec")

from friction_fleet.dataset import BAGS, BRAKINGS, ERROR, OK, SCHEMAS, Dataset

README = Path(__file__).parents[1] / "README.md"
DAY = 1_768_435_200 * 10**6
HOUR = 3_600 * 10**6
STRANGE = "the car does not move as its vehicle file says: run vehicle_doctor"


def braking(hour: float, mu_max: float | None, reason: str = "", vehicle: str = "car1") -> dict[str, Any]:
    stamp = DAY + round(hour * HOUR)
    known = {"of": "car", "vehicle": vehicle, "start": stamp, "stamp": stamp, "mu_max": mu_max, "mu_used": 0.3}
    known |= {"cell": 0x8B1FB4671A0CFFF, "valid": 0.0 if mu_max is None else 0.5, "reason": reason}
    return dict.fromkeys(SCHEMAS[BRAKINGS].names) | known | {"contradicted": False}


def test_the_queries_of_the_readme_answer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    duckdb = pytest.importorskip("duckdb")
    dataset = Dataset(str(tmp_path / "tables"))
    rows = [braking(7.2, 0.1), braking(7.9, 0.14), braking(12.0, 0.9), braking(13.0, None, STRANGE, "car2")]
    for key, path, status, of_bag in (
        ("old", "a", OK, [braking(3.0, 0.2)]),
        ("new", "a", OK, rows),
        ("bad", "b", ERROR, []),
    ):
        dataset.put_rows(BRAKINGS, key, "car1", "2026-01-15", [{**row, "bag": key} for row in of_bag])
        row = {"bag": key, "path": path, "status": status, "committed": DAY + (key == "new")}
        dataset.commit(dict.fromkeys(SCHEMAS[BAGS].names) | row)
    monkeypatch.chdir(tmp_path)
    with duckdb.connect() as connection:
        connection.execute("SET TimeZone = 'UTC'")
        blocks = re.findall(r"```sql\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
        connection.execute(blocks[0])
        slippery, drifting, reasons = (connection.execute(block).fetchall() for block in blocks[1:])
    assert slippery == [(7, "8b1fb4671a0cfff", 2, 0.12)]
    assert drifting == [("car2", date(2026, 1, 15), 1, 1.0)]
    assert reasons == [(STRANGE, 1, 0.3)]
    assert datetime.fromtimestamp(DAY / 1e6, timezone.utc).date() == date(2026, 1, 15)
