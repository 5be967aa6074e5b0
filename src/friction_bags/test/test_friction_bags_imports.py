"""Allowed imports of each part of friction_bags from the others, and from the other packages of the workspace."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from friction_bags.__main__ import main

PACKAGE = Path(__file__).parents[1] / "friction_bags"
WORKSPACE = frozenset(path.parent.name for path in Path(__file__).parents[2].glob("*/package.xml"))
ALLOWED: dict[str, set[str]] = {
    "progress_bars": set(),
    "bag_io": {"friction_parameters", "friction_runtime"},  # errors of a command, names of message types
    "bag_vehicle": {"friction_bags.bag_io", "friction_parameters", "friction_runtime", "vehicle_models"},
    "record_replay": {
        "friction_bags.bag_io",
        "friction_bags.bag_vehicle",
        "friction_bags.progress_bars",
        "friction_parameters",
        "friction_runtime",
        "vehicle_models",
    },
    "results": {"friction_bags.bag_io", "friction_runtime", "vehicle_models"},
    "offline": {
        "friction_adapter",
        "friction_bags.bag_io",
        "friction_bags.bag_vehicle",
        "friction_bags.remapped_bag",
        "friction_bags.progress_bars",
        "friction_bags.results",
        "friction_parameters",
        "friction_runtime",
        "vehicle_models",
        "wheel_slip",
    },
    "remapped_bag": {
        "friction_adapter",
        "friction_bags.bag_io",
        "friction_bags.bag_vehicle",
        "friction_runtime",
    },
    "importers": {
        "friction_adapter",
        "friction_bags.bag_io",
        "friction_bags.bag_vehicle",
        "friction_bags.remapped_bag",
        "friction_bags.progress_bars",
        "friction_parameters",
        "friction_runtime",
        "vehicle_models",
    },
    "experiments": {
        "corner_sim",
        "friction_adapter",
        "friction_bags.bag_io",
        "friction_bags.bag_vehicle",
        "friction_bags.offline",
        "friction_msgs",
        "friction_parameters",
        "friction_runtime",
        "vehicle_models",
    },
    "__main__": {
        "friction_bags.bag_io",
        "friction_parameters",
        "friction_runtime",
    },  # loads the module of a command by its name
}


def imported(part: str) -> Iterator[str]:
    """Return what the modules of a part import from the workspace: parts of friction_bags, and packages."""
    for file in [PACKAGE / f"{part}.py", *(PACKAGE / part).glob("**/*.py")]:
        if not file.exists():
            continue
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = []
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                assert node.level == 0, f"{file}: relative import"
                names = [f"{node.module}.{alias.name}" for alias in node.names]
            for name in names:
                package, _, rest = name.partition(".")
                if package == "friction_bags":
                    yield f"{package}.{rest.partition('.')[0]}"
                elif package in WORKSPACE:
                    yield package


def test_every_part_has_a_rule() -> None:
    found = {path.stem for path in PACKAGE.glob("*.py")} | {path.parent.name for path in PACKAGE.glob("*/__init__.py")}
    assert found - {"__init__"} == set(ALLOWED)
    assert "friction_slope" in WORKSPACE


@pytest.mark.parametrize("part", ALLOWED)
def test_part_imports_only_what_its_rule_names(part: str) -> None:
    assert set(imported(part)) - {f"friction_bags.{part}"} <= ALLOWED[part]


@pytest.mark.parametrize("command", ["record", "play", "info", "reindex", "process", "import", "tutorial", "library"])
def test_every_command_finds_its_module(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main([command, "--help"])
    assert ended.value.code == 0
    assert f"friction_bags {command}" in capsys.readouterr().out
