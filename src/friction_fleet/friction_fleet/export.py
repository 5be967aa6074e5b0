"""A map of friction as Parquet, GeoJSON, a page for a browser, and signals of the COVESA vehicle specification."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, fields
from datetime import datetime, timezone
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from friction_fleet.cells import centre, neighbours, outline, outlines
from friction_fleet.fusion import SLIPPERY, WARNING, CellFriction

_STAMP = b"stamp"
_DIGITS = 4
_SIGNAL = "Vehicle.ADAS.ESC.RoadFriction"


def write_parquet(path: Path, cells: Sequence[CellFriction], stamp: float) -> None:
    """Write a row for each cell; the time of the map [s since 1970] is in the metadata of the file."""
    columns: dict[str, Any] = {each.name: [getattr(cell, each.name) for cell in cells] for each in fields(CellFriction)}
    columns["cell"] = pa.array(columns["cell"], pa.uint64())
    places = np.array([centre(cell.cell) for cell in cells]).reshape(-1, 2)
    table = pa.table({**columns, "latitude": places[:, 0], "longitude": places[:, 1]})
    pq.write_table(table.replace_schema_metadata({_STAMP: repr(stamp).encode()}), path)


def read_parquet(path: Path) -> tuple[list[CellFriction], float]:
    """Return the cells of a file of write_parquet, and the time of the map [s since 1970]."""
    table = pq.read_table(path)
    names = [each.name for each in fields(CellFriction)]
    rows = table.select(names).to_pylist()
    return [CellFriction(**row) for row in rows], float(table.schema.metadata[_STAMP])


def zones(cells: Iterable[CellFriction]) -> list[list[int]]:
    """Return the slippery cells that touch each other, zone by zone."""
    left = {cell.cell for cell in cells if cell.slippery > WARNING}
    found = []
    while left:
        waiting, zone = [min(left)], []
        left.remove(waiting[0])
        while waiting:
            zone.append(waiting.pop())
            touching = left.intersection(neighbours(zone[-1]))
            left -= touching
            waiting += sorted(touching)
        found.append(sorted(zone))
    return found


def geojson(cells: Sequence[CellFriction], stamp: float) -> dict[str, Any]:
    """Return a feature for each cell, and one for each slippery zone (EU 886/2013: temporary slippery road)."""
    features = []
    for cell in cells:
        corners = outline(cell.cell)
        shape = {"type": "Polygon", "coordinates": [[*corners, corners[0]]]}
        features.append({"type": "Feature", "geometry": shape, "properties": _shown(cell)})
    for zone in zones(cells):
        properties = {"kind": "temporary slippery road", "below": SLIPPERY, "cells": len(zone)}
        features.append({"type": "Feature", "geometry": outlines(zone), "properties": properties})
    return {"type": "FeatureCollection", "stamp": _iso(stamp), "features": features}


def page(cells: Sequence[CellFriction], stamp: float) -> str:
    """Return a page that needs no network: cells in the colour of their 5 % quantile."""
    made = [{**_shown(cell), "outline": [[round(x, 6), round(y, 6)] for x, y in outline(cell.cell)]} for cell in cells]
    data = json.dumps({"stamp": _iso(stamp), "cells": made}, separators=(",", ":"))
    template = files("friction_fleet").joinpath("web/map.html").read_text(encoding="utf-8")
    return template.replace("/*DATA*/null", data)


def vss(cells: Sequence[CellFriction], stamp: float) -> list[dict[str, Any]]:
    """Return the signals of each cell: quantiles of 5, 50 and 95 % in percent, at most 100 as the catalogue has it."""
    names: Mapping[str, str] = {"LowerBound": "lower", "MostProbable": "median", "UpperBound": "upper"}
    made = []
    for cell in cells:
        latitude, longitude = centre(cell.cell)
        values = {f"{_SIGNAL}.{name}": min(100.0, round(100.0 * getattr(cell, of), 1)) for name, of in names.items()}
        of_cell = {"cell": f"{cell.cell:x}", "latitude": round(latitude, 6), "longitude": round(longitude, 6)}
        made.append({**of_cell, "ts": _iso(stamp - cell.age), **values})
    return made


def _shown(cell: CellFriction) -> dict[str, Any]:
    rounded = {
        name: round(value, _DIGITS) if isinstance(value, float) else value for name, value in asdict(cell).items()
    }
    return {**rounded, "kind": "cell", "cell": f"{cell.cell:x}", "age": round(cell.age)}


def _iso(stamp: float) -> str:
    return datetime.fromtimestamp(stamp, timezone.utc).isoformat(timespec="seconds")
