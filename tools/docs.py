"""Write the files generated from the code: shipped parameter files, tables and a diagram in the READMEs, Figure 8.1.

Usage: tools/run.bash python3 -m tools.docs   (normally through `make docs`)
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from importlib import import_module
from itertools import product
from pathlib import Path

from book import state_machine_figure
from friction_bringup import graph
from friction_parameters.generated import ShippedFile, parameter_file, parameter_table
from vehicle_models.vehicle_file import vehicle_table
from wheel_slip.estimate import Mode
from wheel_slip.mode import Cause, Evidence, transition
from wheel_slip.tuning import SlideTuning

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
        text = with_block(readme, "parameters", parameter_table(shipped[node]))
        if node == "wheel_slip":
            text = with_block(readme, "modes", mode_diagram(mode_transitions()), text)
        yield readme, text
    readme = ROOT / "src" / "vehicle_models" / "README.md"
    yield readme, with_block(readme, "vehicle", vehicle_table())


ModeTransitions = dict[tuple[Mode, Mode], tuple[Cause, ...]]
"""Causes of each transition, by the modes before and after."""


def mode_transitions(parameters: SlideTuning | None = None) -> ModeTransitions:
    """Find every transition of the machine and its causes, by a grid over all evidence that it distinguishes."""
    p = parameters or SlideTuning()
    accelerations = (0.0, 2.0 * p.slide_above)
    times = (-1.0, p.settle_time, max(p.settle_time, p.calm_time, p.steady_time))
    found: dict[tuple[Mode, Mode], set[Cause]] = {}
    for mode, acceleration, rolled, steady in product(Mode, accelerations, times, times):
        for sensor, speed, roll, pulled, calm, agree in product((False, True), repeat=6):
            evidence = Evidence(sensor, speed, roll, pulled, acceleration, calm, agree, rolled, steady)
            after, cause = transition(mode, evidence, p)
            if after is not mode:
                found.setdefault((mode, after), set()).add(cause)
    order = list(Cause)
    return {edge: tuple(sorted(causes, key=order.index)) for edge, causes in sorted(found.items())}


def mode_diagram(transitions: ModeTransitions) -> str:
    """Return the lines of the diagram, as a block of a README."""
    lines = ["```mermaid", "stateDiagram-v2", f"    [*] --> {Mode.WAITING.name}: {Cause.STARTED.value}"]
    for (before, after), causes in transitions.items():
        lines.append(f"    {before.name} --> {after.name}: {'<br/>or '.join(cause.value for cause in causes)}")
    return "\n".join([*lines, "```"])


def with_block(file: Path, name: str, block: str, text: str | None = None) -> str:
    """Return a file's text, or the one given for it, with a block between `<!-- name -->` and `<!-- /name -->`.

    Raises:
        ValueError: the file does not hold these two lines, once each and in this order.
    """
    begin, end = f"<!-- {name} -->\n", f"<!-- /{name} -->\n"
    text = file.read_text(encoding="utf-8") if text is None else text
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
