"""Write the files generated from the code: shipped parameter files, tables in the READMEs, reasons, Figure 8.1.

Usage: tools/run.bash python3 -m tools.docs   (normally through `make docs`)
"""

from __future__ import annotations

import ast
import re
import sys
from collections import defaultdict
from collections.abc import Iterator, Mapping
from importlib import import_module
from itertools import pairwise
from pathlib import Path

from abs_supervisor.plausibility import CHECKS
from book import state_machine_figure
from friction_bringup import graph
from friction_parameters.generated import ShippedFile, parameter_file, parameter_table
from vehicle_models.reason import REMEDIES, Reason
from vehicle_models.vehicle_file import vehicle_table

NODES = (*graph.NODES, graph.ADAPTER)
ROOT = Path(__file__).resolve().parents[1]
FIGURE = ROOT / "docs" / "figure_8_1.png"
_MISSING = range(Reason.NO_WHEEL_SPEED, Reason.NOT_BRAKING)
"""Codes of inputs: Validity.msg names the input alone."""
_REASONS = """# Reasons

Why an estimate may not be used, and what to do. `make docs` writes this file: codes and causes are those of
`friction_msgs/msg/Validity.msg`, remedies those of `vehicle_models.reason.REMEDIES`, sentences those that stand
beside the reason in the code, with … for a number or a name. Silent or stale inputs are named by their topic, faults of
a sensor by what was measured.
"""


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
    readme = ROOT / "src" / "abs_supervisor" / "README.md"
    yield readme, with_block(readme, "plausibility", plausibility_table())
    readme = ROOT / "src" / "vehicle_models" / "README.md"
    yield readme, with_block(readme, "vehicle", vehicle_table())
    yield ROOT / "docs" / "reasons.md", reason_list()


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


def plausibility_table() -> str:
    """Return the checks of a wheel speed as a table."""
    rows = [f"| {check.name} | {check.condition} | {1e3 * check.lasts:.0f} ms |" for check in CHECKS]
    return "\n".join(("| check | condition | for |", "|---|---|---|", *rows)) + "\n"


def reason_list() -> str:
    """Return docs/reasons.md.

    Raises:
        KeyError: a reason has no remedy or no cause.
    """
    message = (ROOT / "src" / "friction_msgs" / "msg" / "Validity.msg").read_text(encoding="utf-8")
    causes = dict(re.findall(r"^uint16 (\w+)=\d+ *# (.*)$", message, re.MULTILINE))
    said: dict[str, dict[str, list[str]]] = defaultdict(dict)
    packages = {path.parent for path in ROOT.glob("src/*/setup.py")} - {ROOT / "src" / "vehicle_models"}
    for package in sorted(packages):
        for file in sorted((package / package.name).rglob("*.py")):
            for name, text in _sentences(ast.parse(file.read_text(encoding="utf-8"))):
                said[name].setdefault(text, []).append(package.name)
    parts = [_REASONS]
    for reason in list(Reason)[1:]:
        cause = f"{causes[reason.name]} is missing" if reason in _MISSING else causes[reason.name]
        parts.append(f"## {reason.value} {reason.name}\n\n- Cause: {cause}.\n- Remedy: {REMEDIES[reason]}.\n")
        lines = [f"- `{text}` ({', '.join(dict.fromkeys(of))})\n" for text, of in sorted(said[reason.name].items())]
        parts += ["".join(lines)] if lines else []
    return "\n".join(parts)


def _sentences(tree: ast.Module) -> Iterator[tuple[str, str]]:
    """Yield the names of reasons with the sentences that follow them in a tuple, a call or a dict."""
    for node in ast.walk(tree):
        pairs: list[tuple[ast.expr | None, ast.expr]] = []
        if isinstance(node, ast.Tuple):
            pairs = list(pairwise(node.elts))
        elif isinstance(node, ast.Call):
            pairs = list(pairwise(node.args))
        elif isinstance(node, ast.Dict):
            pairs = list(zip(node.keys, node.values, strict=True))
        for reason, text in pairs:
            if isinstance(reason, ast.Attribute) and ast.unparse(reason.value) == "Reason" and (words := _words(text)):
                yield reason.attr, words


def _words(text: ast.expr) -> str:
    """Return a string with … for what is put into it; empty for anything else."""
    if isinstance(text, ast.JoinedStr):
        return "".join(_words(each) or "…" for each in text.values)
    return text.value if isinstance(text, ast.Constant) and isinstance(text.value, str) else ""


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
