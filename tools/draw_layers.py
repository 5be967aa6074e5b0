"""Draw the packages by layers, with an arrow for each import, as docs/layers.svg.

Usage: python3 tools/draw_layers.py   (normally through `make docs`)
"""

from __future__ import annotations

import ast
from collections.abc import Iterable
from html import escape
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LAYERS = (
    ("friction_bringup",),
    ("friction_report", "vehicle_doctor", "friction_fleet"),
    ("friction_bags",),
    (
        "friction_adapter",
        "corner_sim",
        "wheel_slip",
        "friction_slope",
        "friction_curve_id",
        "abs_supervisor",
        "smart_tyre_forces",
        "friction_grip",
        "friction_state",
    ),
    ("friction_runtime",),
    ("sensor_monitor",),
    ("vehicle_models",),
    ("friction_parameters", "friction_msgs"),
)
"""Product packages from the top; a package imports from layers below its own, and from no other."""
_WIDTH, _BOX, _HEIGHT, _ROW = 1280, 150, 30, 100
_COLOURS = ("#1b6ca8", "#b5651d", "#2e7d32", "#6a1b9a", "#ad1457", "#00796b", "#5d4037", "#37474f")


def imports(files: Iterable[Path]) -> set[str]:
    """Return the top-level names of all modules that Python files import."""
    found: set[str] = set()
    for file in files:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module is not None:
                found.add(node.module.partition(".")[0])
    return found


def package_imports(source: Path) -> dict[str, set[str]]:
    """Return what each package below a directory imports of the others, its tests left out."""
    names = {path.parent.name for path in source.glob("*/package.xml")}
    return {
        name: imports([*(source / name / name).rglob("*.py"), *(source / name).glob("launch/*.py")]) & names - {name}
        for name in sorted(names)
    }


def direct(graph: dict[str, set[str]]) -> dict[str, set[str]]:
    """Leave out each arrow that a longer way replaces."""
    below: dict[str, set[str]] = {}

    def reached(name: str) -> set[str]:
        if name not in below:
            below[name] = graph[name].union(*(reached(each) for each in graph[name]))
        return below[name]

    return {
        name: {each for each in to if not any(each in reached(other) for other in to)} for name, to in graph.items()
    }


def drawing(graph: dict[str, set[str]]) -> str:
    """Return the picture as SVG."""
    place = {}
    for row, names in enumerate(LAYERS):
        step = _WIDTH / len(names)
        for column, name in enumerate(names):
            place[name] = round((column + 0.5) * step), 30 + row * _ROW
    height = 30 + (len(LAYERS) - 1) * _ROW + _HEIGHT + 20
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {height}" font-family="sans-serif"'
        ' font-size="14">',
        '<defs><marker id="tip" markerWidth="8" markerHeight="8" refX="7" refY="4" orient="auto">'
        '<path d="M0,1 L7,4 L0,7 z" fill="context-stroke"/></marker></defs>',
        f'<rect width="{_WIDTH}" height="{height}" fill="white"/>',
    ]
    rows = {name: row for row, names in enumerate(LAYERS) for name in names}
    for name, (x, y) in place.items():
        colour = _COLOURS[rows[name]]
        for other in sorted(direct(graph)[name]):
            to_x, to_y = place[other]
            bend = y + _HEIGHT + 0.5 * (to_y - y - _HEIGHT)
            path = f"M{x},{y + _HEIGHT} C{x},{bend} {to_x},{bend} {to_x},{to_y - 2}"
            lines.append(
                f'<path d="{path}" fill="none" stroke="{colour}" stroke-opacity="0.7" marker-end="url(#tip)"/>'
            )
    for name, (x, y) in place.items():
        box = f'x="{x - _BOX // 2}" y="{y}" width="{_BOX}" height="{_HEIGHT}" rx="5"'
        lines.append(f'<rect {box} fill="white" stroke="{_COLOURS[rows[name]]}" stroke-width="1.5"/>')
        lines.append(f'<text x="{x}" y="{y + 20}" text-anchor="middle">{escape(name)}</text>')
    return "\n".join([*lines, "</svg>", ""])


def main() -> None:
    """Write docs/layers.svg."""
    (ROOT / "docs/layers.svg").write_text(drawing(package_imports(ROOT / "src")), encoding="utf-8")


if __name__ == "__main__":
    main()
