"""Imports across the top level: book -> campaigns -> benchmarks -> src, never the other way round."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TOPICS = sorted(path.parent.name for path in ROOT.glob("benchmarks/*/__init__.py"))
ABOVE = {
    "benchmarks": {"campaigns", "book"},
    "campaigns": {"book"},
    "src": {"benchmarks", "campaigns", "book"},
}
ALLOWED: dict[str, set[str]] = {
    "slip": {"abs"},  # its stops have the same supervisor
    "real_car": {"slope", "identification"},  # slope signs in ordinary driving; values kept of an estimate
}


def imported(files: Iterator[Path]) -> set[str]:
    """Modules that files import."""
    found: set[str] = set()
    for file in files:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                assert node.level == 0, f"{file}: relative import"
                found |= {f"{node.module}.{alias.name}" for alias in node.names}
            elif isinstance(node, ast.Import):
                found |= {alias.name for alias in node.names}
    return found


@pytest.mark.parametrize("directory", ABOVE)
def test_nothing_is_imported_from_above(directory: str) -> None:
    files = (file for file in (ROOT / directory).rglob("*.py") if file.parent.name != "test")
    assert {name.split(".")[0] for name in imported(files)}.isdisjoint(ABOVE[directory])


@pytest.mark.parametrize("topic", TOPICS)
def test_a_study_imports_only_those_that_its_rule_names(topic: str) -> None:
    found = {
        name.split(".")[1] for name in imported((ROOT / "benchmarks" / topic).rglob("*.py")) if "benchmarks." in name
    }
    assert found & set(TOPICS) - {topic} <= ALLOWED.get(topic, set())
    assert "__main__" not in found


def test_what_is_shared_imports_no_study() -> None:
    names = imported((ROOT / "benchmarks").glob("*.py"))
    found = {name.split(".")[1] for name in names if name.startswith("benchmarks.")}
    assert found.isdisjoint(TOPICS)
