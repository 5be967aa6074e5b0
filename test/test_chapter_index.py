"""The chapter index: every number of the chapter leads to an existing function that names the number."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
NOT_DRAWN = {"Figure 8.14", "Figure 8.15", "Figure 8.17"}
"""Photographs and a sketch."""
ROW = re.compile(
    r"\| (?P<numbers>.+?) \| (?P<content>.+?) \| \[(?P<name>\S+)\]\(\.\./(?P<file>\S+)\)"
    r" \| `(?P<function>\S+)` \| `(?P<command>[^`]+)` \|"
)
COMMAND = re.compile(r"python3 -m (book|benchmarks|campaigns)( [\w.\-]+)*|pytest \S+")


def numbers_in(text: str) -> set[str]:
    """Numbers that a text names, ranges spelt out: "(8.7)", "Figures 8.2 to 8.4 and 8.9", "Table 8.1"."""
    found = {f"(8.{number})" for number in re.findall(r"\(8\.(\d+)\)", text)}
    for first, second in re.findall(r"\(8\.(\d+)\) to \(8\.(\d+)\)", text):
        found |= {f"(8.{number})" for number in range(int(first), int(second) + 1)}
    for kind, listed in re.findall(r"(Figure|Table)s? (8\.\d+(?:(?:, | and | to )8\.\d+)*)", text):
        for first, second in re.findall(r"8\.(\d+)(?: to 8\.(\d+))?", listed):
            found |= {f"{kind} 8.{number}" for number in range(int(first), int(second or first) + 1)}
    return found


def index_rows() -> Iterator[tuple[str, str, str]]:
    """Numbers, file and function of every row."""
    text = (ROOT / "docs/chapter_index.md").read_text(encoding="utf-8")
    for line in text.splitlines():
        if line.startswith("| ") and not line.startswith("| number"):
            row = ROW.fullmatch(line)
            assert row, f"a row of the index cannot be read: {line}"
            package, name = row["name"].split("/", 1)
            assert row["file"] in (f"src/{package}/{package}/{name}", f"{package}/{name}")
            assert COMMAND.fullmatch(row["command"]), row["command"]
            yield row["numbers"], row["file"], row["function"]


ROWS = list(index_rows())


@pytest.mark.parametrize(("numbers", "file", "function"), ROWS, ids=[f"{row[0]} {row[2]}" for row in ROWS])
def test_a_number_leads_to_a_function_that_names_it(numbers: str, file: str, function: str) -> None:
    node: ast.Module | ast.ClassDef | ast.FunctionDef = ast.parse((ROOT / file).read_text(encoding="utf-8"))
    said = [ast.get_docstring(node) or ""]
    for part in function.split("."):
        inside = [each for each in node.body if isinstance(each, (ast.ClassDef, ast.FunctionDef)) and each.name == part]
        assert inside, f"{file} has no {function}"
        node = inside[0]
        said.append(ast.get_docstring(node) or "")
    wanted = numbers_in(numbers)
    assert wanted
    equations = {number for number in wanted if number.startswith("(")}
    assert not equations - numbers_in(said[-1]), f"{file}: {function} does not name its equation"
    assert not wanted - numbers_in("\n".join(said)), f"{file}: {function} and its module do not name them"


def test_every_number_of_the_chapter_is_in_the_index_once_at_least() -> None:
    equations = {f"(8.{number})" for number in range(1, 20)}
    tables = {f"Table 8.{number}" for number in range(1, 6)}
    figures = {f"Figure 8.{number}" for number in range(1, 29)} - NOT_DRAWN
    listed = set().union(*(numbers_in(numbers) for numbers, _, _ in ROWS))
    assert listed == equations | tables | figures


def test_ranges_and_lists_of_numbers_are_spelt_out() -> None:
    text = "Figures 8.2 to 8.4 and 8.9, (8.1) to (8.3)\nand (8.7), Table 8.1, Tables 8.4 and 8.5"
    figures = {f"Figure 8.{number}" for number in (2, 3, 4, 9)}
    equations = {f"(8.{number})" for number in (1, 2, 3, 7)}
    assert numbers_in(text) == figures | equations | {"Table 8.1", "Table 8.4", "Table 8.5"}
