"""Write the files generated from the code: shipped parameter files, tables in the READMEs, Figure 8.1.

Usage: tools/run.bash python3 -m tools.docs   (normally through `make docs`)
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from importlib import import_module
from pathlib import Path

from book import state_machine_figure
from friction_bringup import graph
from friction_parameters.generated import ShippedFile, parameter_file, parameter_table
from vehicle_models.vehicle_file import vehicle_table

NODES = (*graph.NODES, graph.ADAPTER)
ROOT = Path(__file__).resolve().parents[1]
FIGURE = ROOT / "docs" / "figure_8_1.png"


def generated_texts() -> Iterator[tuple[Path, str]]:
    """Yield the files with generated parts, and the text that they should have.

    Raises:
        ValueError: a README has no place for its table.
    """
    for node in NODES:
        shipped: Mapping[str, ShippedFile] = import_module(f"{node}.parameters").SHIPPED
        for name, file in shipped.items():
            yield ROOT / "src" / node / "config" / f"{name}.yaml", parameter_file(node, file)
        readme = ROOT / "src" / node / "README.md"
        yield readme, with_block(readme, "parameters", parameter_table(shipped[node]))
    readme = ROOT / "src" / "vehicle_models" / "README.md"
    yield readme, with_block(readme, "vehicle", vehicle_table())


def with_block(file: Path, name: str, block: str) -> str:
    """Return a file's text with a block between `<!-- name -->` and `<!-- /name -->`.

    Raises:
        ValueError: the file does not hold these two lines, once each and in this order.
    """
    begin, end = f"<!-- {name} -->\n", f"<!-- /{name} -->\n"
    text = file.read_text(encoding="utf-8")
    before, found, rest = text.partition(begin)
    _, found_end, after = rest.partition(end)
    if not (found and found_end) or text.count(begin) != 1 or text.count(end) != 1:
        raise ValueError(f"{file}: it must hold the lines {begin.strip()} and {end.strip()} once")
    return f"{before}{begin}\n{block}\n{end}{after}"


def main() -> int:
    """Write the files that differ, and print their names."""
    try:
        for file, text in generated_texts():
            if not file.exists() or file.read_text(encoding="utf-8") != text:
                file.write_text(text, encoding="utf-8")
                print(f"wrote {file.relative_to(ROOT)}")
    except ValueError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    before = FIGURE.read_bytes() if FIGURE.exists() else b""
    state_machine_figure.draw(FIGURE)
    if FIGURE.read_bytes() != before:
        print(f"wrote {FIGURE.relative_to(ROOT)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
