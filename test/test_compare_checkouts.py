"""tools/compare_checkouts.py names what differs between the estimates of two checkouts, and nothing else."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import compare_checkouts

BEFORE: dict[tuple[str, int, int], dict[str, Any]] = {
    ("/slip", 1, 1): {"slip": 0.1, "slip_rate": np.nan, "gone": 1},
    ("/slip", 2, 1): {"slip": 0.2, "slip_rate": 1.0, "gone": 1},
}


def found(after: dict[tuple[str, int, int], dict[str, Any]], monkeypatch: pytest.MonkeyPatch) -> list[str]:
    given = {"before": BEFORE, "after": after}
    monkeypatch.setattr(compare_checkouts, "processed", lambda _root, _bag, out: given[out.name])
    return list(compare_checkouts.differences(Path("a"), Path("b"), Path("dry")))


def test_equal_estimates_and_new_fields_differ_in_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    after = {key: {"slip": row["slip"], "slip_rate": row["slip_rate"], "new": 0} for key, row in BEFORE.items()}
    assert found(after, monkeypatch) == []


def test_a_field_and_a_missing_message_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    first, values = next(iter(BEFORE.items()))
    assert found({first: values | {"slip": 0.3}}, monkeypatch) == [
        "dry /slip slip: differs in 1 messages",
        "dry /slip: only before in 1 messages",
    ]
