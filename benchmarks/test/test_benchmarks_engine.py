"""Jobs of studies: kept, taken up again, and the same wherever they run."""

from collections.abc import Iterator
from math import sqrt
from pathlib import Path

import pytest

from benchmarks.engine import ENGINE, Engine, code_digest, results_of

NUMBERS = [4.0, 9.0, 2.0, 16.0, 9.0]


@pytest.fixture
def done() -> Iterator[list[float]]:
    """Jobs that were done, in order; afterwards studies run as without a command line."""
    before = ENGINE.set(Engine())
    _done.clear()
    yield _done
    ENGINE.reset(before)


_done: list[float] = []


def noted(number: float) -> float:
    """A job; the negative one fails."""
    _done.append(number)
    return sqrt(number)


def test_what_was_kept_is_not_done_again(done: list[float], tmp_path: Path) -> None:
    ENGINE.set(Engine(keep=tmp_path / "kept"))
    with pytest.raises(ValueError, match="math domain"):
        results_of(noted, [4.0, 9.0, -1.0, 16.0], "jobs")
    assert results_of(noted, [4.0, 9.0, 16.0], "jobs") == [2.0, 3.0, 4.0]
    assert done == [4.0, 9.0, -1.0, 16.0]
    assert results_of(abs, [4.0], "another function") == [4.0]


def test_without_a_directory_nothing_is_kept(done: list[float]) -> None:
    assert results_of(noted, NUMBERS, "jobs") == results_of(noted, NUMBERS, "jobs")
    assert done == 2 * NUMBERS


def test_other_code_does_not_take_what_was_kept(
    done: list[float], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ENGINE.set(Engine(keep=tmp_path))
    results_of(noted, [4.0], "jobs")
    monkeypatch.setattr("benchmarks.engine.code_digest", lambda: f"not {code_digest()}")
    results_of(noted, [4.0], "jobs")
    assert done == [4.0, 4.0]


@pytest.mark.usefixtures("done")
def test_processes_give_the_results_in_the_order_of_the_jobs() -> None:
    ENGINE.set(Engine(workers=2))
    assert results_of(sqrt, NUMBERS, "jobs") == [sqrt(each) for each in NUMBERS]


@pytest.mark.usefixtures("done")
def test_a_cluster_gives_the_same_and_goes_on_where_it_was(tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed", reason="distributed is absent: make fleet")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        ENGINE.set(Engine(scheduler=cluster.scheduler_address, keep=tmp_path))
        assert results_of(sqrt, NUMBERS, "jobs") == [sqrt(each) for each in NUMBERS]
    assert results_of(sqrt, NUMBERS, "jobs") == [sqrt(each) for each in NUMBERS], "the cluster is gone"
