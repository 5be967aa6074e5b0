"""Tables: whole files, the newest row of a path, duplicates that do not depend on who was first."""

from __future__ import annotations

from itertools import permutations
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("pyarrow")
pytest.importorskip("fsspec")

from friction_fleet.dataset import BAGS, BOUNDS, DUPLICATE, ERROR, OK, SCHEMAS, Dataset


def bag(key: str, path: str, committed: int, status: str = OK) -> dict[str, Any]:
    known = {"bag": key, "path": path, "committed": committed, "status": status, "vehicle": "car", "file_stamp": path}
    return dict.fromkeys(SCHEMAS[BAGS].names) | known


def bound(key: str, mu: float) -> dict[str, Any]:
    return dict.fromkeys(SCHEMAS[BOUNDS].names) | {"bag": key, "vehicle": "car", "stamp": 5, "mu_used": mu}


def test_rows_count_once_their_bag_is_committed(tmp_path: Path) -> None:
    dataset = Dataset(str(tmp_path))
    dataset.put_rows(BOUNDS, "k", "car", "2026-01-15", [bound("k", 0.5)])
    assert dataset.table(BOUNDS).num_rows == 0
    dataset.commit(bag("k", "a", 1))
    assert dataset.table(BOUNDS).to_pylist()[0]["mu_used"] == 0.5
    assert not list(tmp_path.rglob("*.part"))


def test_a_write_that_fails_leaves_no_file_of_that_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def die(_: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("os.fsync", die)
    dataset = Dataset(str(tmp_path))
    with pytest.raises(KeyboardInterrupt):
        dataset.commit(bag("k", "a", 1))
    assert dataset.bags() == []


def test_a_bag_that_was_changed_or_processed_again_has_its_newest_row(tmp_path: Path) -> None:
    dataset = Dataset(str(tmp_path))
    for key, committed, mu in (("old", 1, 0.3), ("new", 2, 0.6)):
        dataset.put_rows(BOUNDS, key, "car", "2026-01-15", [bound(key, mu)])
        dataset.commit(bag(key, "a", committed))
    assert [row["bag"] for row in dataset.bags()] == ["new"]
    assert [row["mu_used"] for row in dataset.table(BOUNDS).to_pylist()] == [0.6]
    assert dataset.compact() == 2
    assert [row["mu_used"] for row in dataset.table(BOUNDS).to_pylist()] == [0.6]
    assert dataset.compact() == 0


def test_which_of_two_equal_bags_is_the_duplicate_does_not_depend_on_the_order(tmp_path: Path) -> None:
    seen = []
    for number, order in enumerate(permutations("abc")):
        dataset = Dataset(str(tmp_path / str(number)))
        for place, path in enumerate(order):
            dataset.commit(bag("k", path, 1, OK if place == 0 else DUPLICATE))
        seen.append([(row["path"], row["status"], row["vehicle"], row["file_stamp"]) for row in dataset.bags()])
    expected = [("a", OK, "car", "a"), ("b", DUPLICATE, None, "b"), ("c", DUPLICATE, None, "c")]
    assert seen == [expected] * 6


def test_a_duplicate_of_a_bag_that_was_changed_later_keeps_the_results(tmp_path: Path) -> None:
    dataset = Dataset(str(tmp_path))
    dataset.put_rows(BOUNDS, "k", "car", "2026-01-15", [bound("k", 0.5)])
    dataset.commit(bag("k", "a", 1))
    dataset.commit(bag("k", "b", 2, DUPLICATE))
    dataset.commit(bag("other", "a", 3))
    assert [(row["path"], row["bag"], row["status"]) for row in dataset.bags()] == [("a", "other", OK), ("b", "k", OK)]
    assert dataset.table(BOUNDS).num_rows == 1
    assert dataset.compact() == 0


def test_two_workers_that_had_the_same_bag_at_once_count_once(tmp_path: Path) -> None:
    dataset = Dataset(str(tmp_path))
    for path in "ba":
        dataset.commit(bag("k", path, 1))
    assert [row["status"] for row in dataset.bags()] == [OK, DUPLICATE]


def test_rows_of_a_bag_that_failed_do_not_count(tmp_path: Path) -> None:
    dataset = Dataset(str(tmp_path))
    dataset.put_rows(BOUNDS, "k", "car", "2026-01-15", [bound("k", 0.5)])
    dataset.commit(bag("k", "a", 1, ERROR))
    assert dataset.table(BOUNDS).num_rows == 0
