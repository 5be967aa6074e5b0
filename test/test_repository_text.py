"""No text file of the repository holds what a merge left unsolved."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
MADE = ("build", "install", "log", "out", "bags")
"""Directories that are made, not written."""
MARKER = re.compile(r"^(<{7}|[|]{7}|>{7})( |$)", re.MULTILINE)
"""The line between the two sides is a heading in some texts; it never comes without the others."""


def written_files(root: Path) -> Iterator[Path]:
    """Yield the files that people write: none below a directory that is made or hidden."""
    for path in sorted(root.iterdir()):
        if path.name.startswith(".") or path.name in MADE:
            continue
        if path.is_dir():
            yield from written_files(path)
        else:
            yield path


def with_markers(root: Path) -> list[str]:
    """Return the text files that hold a conflict marker, relative to a directory."""
    found = []
    for file in written_files(root):
        content = file.read_bytes()
        if b"\0" not in content and MARKER.search(content.decode(errors="replace")):
            found.append(str(file.relative_to(root)))
    return found


def test_no_file_holds_conflict_markers() -> None:
    assert len(list(written_files(ROOT))) > 300
    assert with_markers(ROOT) == []


@pytest.mark.parametrize("side", ["<<<<<<<", "|||||||", ">>>>>>>"])
def test_a_marker_is_found_in_any_text(side: str, tmp_path: Path) -> None:
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "page.md").write_text(f"above\n{side} HEAD\nbelow\n")
    (tmp_path / "fine.rst").write_text("Title\n=======\n\n>>>> quoted\n")
    assert with_markers(tmp_path) == ["docs/page.md"]
