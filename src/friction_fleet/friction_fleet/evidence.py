"""Evidence on the friction of cells, from the tables of a fleet."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from friction_bags.results.braking_rows import CAR
from friction_fleet.dataset import BOUNDS, BRAKINGS, Dataset


@dataclass(frozen=True)
class Evidence:
    """What a car has learned of the road in a cell."""

    cell: int
    stamp: float
    """[s] since 1970"""
    vehicle: str
    mu: float
    """Friction: of the peak, or the largest that was used."""
    stddev: float
    is_fit: bool
    """Whether it is the peak of a friction curve; else the road has at least this friction."""


def read_evidence(dataset: Dataset) -> list[Evidence]:
    """Return the fits and the lower bounds of a fleet that have a place, by time.

    A fit that friction in use contradicts is none. Friction in use does not count beside a
    fit of the same pass: the two are of the same tyres.
    """
    fits = [row for row in _rows(dataset, BRAKINGS) if row["of"] == CAR and row["mu_max"] and not row["contradicted"]]
    found = [
        Evidence(row["cell"], row["stamp"].timestamp(), row["vehicle"], row["mu_max"], row["mu_max_stddev"], True)
        for row in fits
    ]
    known = {(row["bag"], row["cell"]) for row in fits}
    found += [
        Evidence(row["cell"], row["stamp"].timestamp(), row["vehicle"], row["mu_used"], row["mu_used_stddev"], False)
        for row in _rows(dataset, BOUNDS)
        if (row["bag"], row["cell"]) not in known
    ]
    return sorted(found, key=lambda each: (each.stamp, each.cell, each.vehicle, each.is_fit, each.mu))


def _rows(dataset: Dataset, table: str) -> Iterator[dict[str, Any]]:
    for batch in dataset.table(table).to_batches():
        yield from (row for row in batch.to_pylist() if row["cell"] is not None)
