"""What each topic of friction_evaluation may import of the others: next to nothing, but the report all."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "friction_evaluation"
SHARED = {path.stem for path in PACKAGE.glob("*.py")} - {"__init__"}
TOPICS = {path.parent.name for path in PACKAGE.glob("*/__init__.py")}
ALLOWED: dict[str, set[str]] = {topic: set() for topic in TOPICS} | {
    "slip": {"closed_loop"},  # its stops have the same supervisor
    "real_car": {"slope"},  # friction_slope in ordinary driving, with the settings that are judged there
    "report": TOPICS,
}


def imported(files: Iterator[Path]) -> set[str]:
    """Topics and shared modules that files import."""
    found: set[str] = set()
    for file in files:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                assert node.level == 0, f"{file}: relative import"
                found |= {f"{node.module}.{alias.name}" for alias in node.names}
            elif isinstance(node, ast.Import):
                found |= {alias.name for alias in node.names}
    return {name.split(".")[1] for name in found if name.startswith("friction_evaluation.")}


def test_every_directory_is_a_topic_and_every_import_is_known() -> None:
    directories = {path.parent.name for path in PACKAGE.glob("*/*.py")}
    assert directories == TOPICS
    assert imported(PACKAGE.rglob("*.py")) <= SHARED | TOPICS


@pytest.mark.parametrize("topic", sorted(TOPICS))
def test_topic_imports_only_what_its_rule_names(topic: str) -> None:
    found = imported((PACKAGE / topic).rglob("*.py"))
    assert found & TOPICS - {topic} <= ALLOWED[topic]
    assert found.isdisjoint({"parts", "__main__"}) or topic == "report"


def test_what_is_shared_imports_no_topic() -> None:
    assert imported(PACKAGE.glob("*.py")).isdisjoint(TOPICS)
