"""The machine of wheel_slip's modes as a diagram in Mermaid, found by trying every class of evidence."""

from itertools import product

from wheel_slip.estimate import Mode
from wheel_slip.mode import Cause, Evidence, SlideParameters, transition

Transitions = dict[tuple[Mode, Mode], tuple[Cause, ...]]
"""Causes of each transition, by the modes before and after."""


def find_transitions(parameters: SlideParameters | None = None) -> Transitions:
    """Find every transition of the machine and its causes, by a grid over all evidence that it distinguishes."""
    p = parameters or SlideParameters()
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


def diagram(transitions: Transitions) -> str:
    """Return the lines of the diagram, as a block of a README."""
    lines = ["```mermaid", "stateDiagram-v2", f"    [*] --> {Mode.WAITING.name}: {Cause.STARTED.value}"]
    for (before, after), causes in transitions.items():
        lines.append(f"    {before.name} --> {after.name}: {'<br/>or '.join(cause.value for cause in causes)}")
    return "\n".join([*lines, "```"])
