"""Friction of the cells of a generated town over time, as `simulate` has written it."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

from friction_fleet.fusion import SLIPPERY
from friction_parameters.command_line import UserError

_UNIFORM = 1.05
"""Highest over lowest friction of a cell that is of one road."""


@dataclass(frozen=True)
class CellTruth:
    """Friction of a cell over a time."""

    cell: int
    begin: float
    end: float
    """[s since 1970]"""
    lowest: float
    mean: float
    highest: float

    @property
    def is_uniform(self) -> bool:
        """Whether all of the road in the cell is alike."""
        return self.highest < _UNIFORM * self.lowest

    @property
    def is_slippery(self) -> bool:
        """Whether all of the road in the cell is slippery."""
        return self.highest < SLIPPERY


def read_truth(path: Path) -> list[CellTruth]:
    """Read a file of Town.write_truth; times in which a cell does not change are joined.

    Raises:
        UserError: it is none.
    """
    with path.open(encoding="utf-8", newline="") as file:
        try:
            rows = [
                CellTruth(int(row["cell"]), *(float(row[name]) for name in _NUMBERS)) for row in csv.DictReader(file)
            ]
        except (KeyError, TypeError, ValueError) as error:
            raise UserError(f"{path} is no file of `simulate`: {error}") from error
    joined: list[CellTruth] = []
    for row in sorted(rows, key=lambda each: (each.cell, each.begin)):
        last = joined[-1] if joined else None
        if last and (last.cell, last.end) == (row.cell, row.begin) and _levels(last) == _levels(row):
            joined[-1] = CellTruth(row.cell, last.begin, row.end, *_levels(row))
        else:
            joined.append(row)
    return joined


_NUMBERS = ("begin", "end", "mu_lowest", "mu_mean", "mu_highest")


def _levels(truth: CellTruth) -> tuple[float, float, float]:
    return truth.lowest, truth.mean, truth.highest
