"""Texts of the repository: no conflict markers, working links, first lines of modules that state their job."""

from __future__ import annotations

import ast
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from benchmarks import __main__ as benchmarks
from campaigns import __main__ as campaigns

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


MODULE_START = re.compile(
    r"(Whether|What|How|Where|Which|Why|When|Who)\b"
    r"|.*\b(tells?|told|says?|said|of late|besides|taken for|sure|surely|so many)\b"
)
"""Questions and idioms of our own: a first line states the job of its module in the field's terms."""
LINK = re.compile(r"(?<!!)\[[^\]]*\]\(([^)\s]+)\)")


def tracked(pattern: str) -> list[Path]:
    """Return the files of the repository that match a pattern of git."""
    listed = subprocess.run(["git", "ls-files", pattern], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    return [ROOT / name for name in listed.splitlines() if (ROOT / name).exists()]


def anchors(page: Path) -> set[str]:
    """Return the anchors that GitHub makes of the headings of a page."""
    headings = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def broken_links(page: Path) -> list[str]:
    """Return the links of a page to files or headings that do not exist."""
    broken = []
    for link in LINK.findall(page.read_text(encoding="utf-8")):
        if link.startswith(("http:", "https:", "mailto:")):
            continue
        name, _, heading = link.partition("#")
        target = page.parent / name if name else page
        if not target.exists() or (heading and target.suffix == ".md" and heading not in anchors(target)):
            broken.append(link)
    return broken


def first_line_faults(source: str) -> str | None:
    """Return the first line of a module's docstring if it asks a question or uses a banned idiom."""
    first = (ast.get_docstring(ast.parse(source)) or "").partition("\n")[0]
    return first if MODULE_START.match(first) else None


def test_first_lines_of_modules_state_their_job() -> None:
    files = tracked("*.py")
    assert len(files) > 100
    faults = {str(file.relative_to(ROOT)): first_line_faults(file.read_text(encoding="utf-8")) for file in files}
    assert not {file: line for file, line in faults.items() if line}


@pytest.mark.parametrize("line", ["What the brake does.", "Whether it rolls.", "Slips at which H tells a side."])
def test_a_first_line_that_asks_is_found(line: str) -> None:
    assert first_line_faults(f'"""{line}\n\nMore.\n"""\n') == line
    assert first_line_faults('"""Monitor of the brake."""') is None


def test_links_between_pages_lead_somewhere() -> None:
    pages = tracked("*.md")
    assert len(pages) > 10
    assert not {str(page.relative_to(ROOT)): links for page in pages if (links := broken_links(page))}


def test_a_broken_link_is_found(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("# One two\n[a](page.md#one-two) [b](page.md#three) [c](gone.md) [d](https://example.org)\n")
    assert broken_links(page) == ["page.md#three", "gone.md"]


def test_commands_in_texts_call_python3() -> None:
    files = [*tracked("*.md"), *tracked("src/*.py")]
    assert not [str(file.relative_to(ROOT)) for file in files if "python -m" in file.read_text(encoding="utf-8")]


def test_commands_in_texts_name_parts_that_exist() -> None:
    parts = {"benchmarks": benchmarks.PARTS, "campaigns": campaigns.PARTS}
    for page in tracked("*.md"):
        for program, part in re.findall(r"python3 -m (benchmarks|campaigns) (\w+)", page.read_text(encoding="utf-8")):
            assert part in parts[program] or part.isupper(), f"{page}: {part}"
