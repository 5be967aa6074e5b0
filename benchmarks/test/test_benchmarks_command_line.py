"""The command line of the studies: parts by name, flat rows to JSON."""

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks import __main__ as command_line
from benchmarks import runner
from benchmarks.runner import Row, at_least, at_most, not_judged
from campaigns import __main__ as campaigns


def test_rows_are_printed_and_written_as_strict_json(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def add_arguments(parser: argparse.ArgumentParser) -> None:
        parser.add_argument("--seeds", type=int, default=500)

    def run(options: argparse.Namespace) -> Sequence[Row]:
        return [
            {"surface": "dry", "runs": options.seeds, "delay_ms": np.float64(75.0)},
            {"surface": "snow", "delay_ms": float("inf"), "bias": float("nan")},
        ]

    monkeypatch.setattr(
        runner, "load_part", lambda _program, _name: SimpleNamespace(add_arguments=add_arguments, run=run)
    )
    file = tmp_path / "new" / "slope.json"
    assert command_line.main(["slope", "--seeds", "3", "--json", str(file)]) == 0
    assert json.loads(file.read_text(), parse_constant=pytest.fail) == {
        "rows": [
            {"surface": "dry", "runs": 3, "delay_ms": 75.0},
            {"surface": "snow", "delay_ms": "inf", "bias": None},
        ]
    }
    assert "delay_ms" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("utilisation", "lock", "code"), [(0.81, 0, 0), (0.79, 0, 1), (0.81, 1, 1), (float("nan"), 0, 1)]
)
def test_a_row_that_does_not_hold_is_named_and_gives_exit_code_1(
    utilisation: float, lock: int, code: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def run(_options: argparse.Namespace) -> Sequence[Row]:
        return [
            {"surface": "dry", "distance_m": 45.0},
            {"quantity": "angle", **not_judged(3.0)},
            {"quantity": "utilisation", **at_least(utilisation, 0.798)},
            {"quantity": "lock", **at_most(lock, 0)},
        ]

    chosen = SimpleNamespace(add_arguments=lambda _parser: None, run=run)
    monkeypatch.setattr(runner, "load_part", lambda _program, _name: chosen)
    assert command_line.main(["abs"]) == code
    assert ("failed: quantity" in capsys.readouterr().err) == bool(code)


def test_unknown_part_is_refused_with_the_known_ones(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        command_line.main(["slop"])
    assert "slope" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["abs", "--vehicle", "no_such_car"], "shipped: bmw_m8"),
        (["slip", "--cases", "stops", "--vehicle", "chapter_corner"], "four wheels"),
        (["slip", "--cases", "stops", "--vehicle", "chapter_car"], "driven"),
    ],
)
def test_a_car_that_does_not_serve_is_refused_in_one_line(
    arguments: Sequence[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command_line.main(arguments) == 2
    error = capsys.readouterr().err
    assert said in error
    assert len(error.splitlines()) == 1


@pytest.mark.parametrize(
    ("program", "part"),
    [("benchmarks", part) for part in command_line.PARTS] + [("campaigns", part) for part in campaigns.PARTS],
)
def test_every_part_has_the_shape_the_command_line_needs(program: str, part: str) -> None:
    chosen = runner.load_part(program, part)
    parser = argparse.ArgumentParser()
    chosen.add_arguments(parser)
    assert callable(chosen.run)
