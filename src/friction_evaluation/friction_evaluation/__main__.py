"""Command line: ``python -m friction_evaluation PART --json FILE --page FILE``."""

from __future__ import annotations

import argparse
import json
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from friction_evaluation.markdown_page import page
from friction_evaluation.parts import PARTS, part
from friction_evaluation.rows import Row, as_text, columns, failures, plain
from friction_parameters.command_line import command

_PROGRAM = "python -m friction_evaluation"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one part, print its table and write its rows.

    Returns:
        Exit code: 1 where a row fails, 2 where a parameter or a file is bad, else 0.
    """
    return command(lambda: _run(arguments))


def _run(arguments: Sequence[str] | None) -> int:
    given = list(sys.argv[1:] if arguments is None else arguments)
    parser = argparse.ArgumentParser(prog=_PROGRAM, description=__doc__)
    parser.add_argument("part", choices=PARTS, help="; ".join(f"{name}: {text}" for name, text in PARTS.items()))
    name = parser.parse_args(given[:1]).part
    chosen = part(name)
    files = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    files.add_argument("--json", type=Path, help="write the rows to this file")
    files.add_argument("--page", type=Path, help="write the rows as a page of Markdown to this file")
    own = argparse.ArgumentParser(prog=f"{_PROGRAM} {name}", description=PARTS[name], parents=[files])
    chosen.add_arguments(own)
    options = own.parse_args(given[1:])
    rows = list(chosen.run(options))
    print_rows(PARTS[name], rows)
    if options.json is not None:
        _write(options.json, json.dumps({"rows": [plain(row) for row in rows]}, indent=1) + "\n")
    if options.page is not None:
        # The paths of the results are no part of the command that repeats them.
        _, repeated = files.parse_known_args(given[1:])
        _write(options.page, page(f"Results: {name}", PARTS[name], f"{_PROGRAM} {shlex.join([name, *repeated])}", rows))
    failed = failures(rows)
    for row in failed:
        print(f"failed: {', '.join(f'{name} {as_text(value)}' for name, value in row.items())}", file=sys.stderr)
    return int(bool(failed))


def _write(file: Path, text: str) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")


def print_rows(title: str, rows: Sequence[Row]) -> None:
    """Print flat rows as a table; every row may have its own columns."""
    names = columns(rows)
    table = Table(title=title)
    for name in names:
        table.add_column(escape(name), overflow="fold")
    for row in rows:
        table.add_row(*(escape(as_text(row.get(name, ""))) for name in names))
    # Wide enough that no column is cut where the output goes to a file.
    console = Console()
    (console if console.is_terminal else Console(width=240)).print(table)


if __name__ == "__main__":
    sys.exit(main())
