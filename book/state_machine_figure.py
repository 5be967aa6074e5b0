"""Figure 8.1: the state machine of the ABS supervisor, found by trying every class of input, and drawn."""

from __future__ import annotations

from itertools import product
from math import inf, nan
from pathlib import Path

from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch, FancyBboxPatch

from abs_supervisor.state_machine import COMMANDS, Cause, Inputs, State, Thresholds, transition

Transitions = dict[tuple[State, State], tuple[Cause, ...]]
"""Causes of each transition, by the states before and after."""

CONDITIONS = {
    Cause.BRAKING: r"demand $\geq \bar{T}$",
    Cause.INSTABILITY: "$H \\leq H_{\\mathrm{inst}}$,\nslip growing",
    Cause.WAIT_OVER: "after\n$n$ ms",
    Cause.STABILITY: "$H \\geq H_{\\mathrm{st}}$,\nslip falling",
    Cause.RELEASE_TIMEOUT: "released\nfor too long",
    Cause.BRAKING_OVER: r"demand $< \bar{T}$",
    Cause.FAIL_SAFE: "inputs failed",
    Cause.LOW_SPEED: "low speed",
}
"""Each cause in the symbols of section 8.2.2; H stands for the indicator, H sign(eta) of (8.5)."""

_PLACES = {State.S0: (1.0, 3.0), State.S1: (4.4, 3.0), State.S21: (8.0, 4.6), State.S22: (8.0, 1.4)}
_RADIUS = 0.62
_UNSTABLE = (State.S21, State.S22)
_BENDS = {
    (State.S0, State.S1): -0.3,
    (State.S1, State.S0): -0.3,
    (State.S21, State.S0): 0.45,
    (State.S22, State.S0): -0.45,
}
"""Height of an arc over the distance of its states."""
_LABELS = {
    (State.S0, State.S1): (2.7, 3.8, "\nor "),
    (State.S1, State.S0): (3.05, 2.05, "\nor "),
    (State.S1, State.S21): (5.75, 4.25, "\nor "),
    (State.S21, State.S22): (8.45, 3.0, "\nor "),
    (State.S22, State.S1): (5.75, 1.75, "\nor "),
    (State.S21, State.S0): (4.6, 5.72, ", or "),
    (State.S22, State.S0): (4.6, 0.28, ", or "),
}
"""Centre of the text of each transition, and what stands between its causes."""


def find_transitions(thresholds: Thresholds | None = None) -> Transitions:
    """Find every transition of the machine and its causes, by a grid over all inputs that it distinguishes."""
    known = thresholds or Thresholds()
    indicators = (nan, -inf, known.h_instability, 0.0, known.h_stability, inf)
    times = (0.0, known.wait, known.release_timeout, inf)
    found: dict[tuple[State, State], set[Cause]] = {}
    for state, indicator, time, flags in product(State, indicators, times, product((False, True), repeat=4)):
        braking, slip_growing, failed, slow = flags
        after, cause = transition(state, Inputs(braking, indicator, slip_growing, failed, slow), time, known)
        if after is not state:
            found.setdefault((state, after), set()).add(cause)
    return {edge: tuple(sorted(causes)) for edge, causes in sorted(found.items())}


def description(transitions: Transitions) -> str:
    """Transitions as a text, a line each; the picture carries it."""
    lines = []
    for (before, after), causes in transitions.items():
        lines.append(f"{before.name} -> {after.name}: {', '.join(cause.name for cause in causes)}")
    return "\n".join(lines)


def figure(transitions: Transitions) -> Figure:
    """Draw the machine as Figure 8.1 shows it."""
    made = Figure(figsize=(9.6, 6.4))
    axes = made.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0.0, 9.6), ylim=(-0.2, 6.2), aspect="equal")
    axes.axis("off")
    xs, ys = zip(*(_PLACES[state] for state in _UNSTABLE), strict=True)
    corner = (min(xs) - 1.0, min(ys) - 1.0)
    size = (max(xs) - min(xs) + 2.0, max(ys) - min(ys) + 2.0)
    rounded = "round,pad=0,rounding_size=0.25"
    axes.add_patch(
        FancyBboxPatch(corner, *size, boxstyle=rounded, linestyle="--", edgecolor="0.5", facecolor="0.965", zorder=0)
    )
    axes.text(max(xs) + 0.86, max(ys) + 0.84, "$S_2$", fontsize=14, ha="right", va="top", color="0.35")
    for state in State:
        axes.add_patch(Circle(_PLACES[state], _RADIUS, facecolor="white", edgecolor="black", linewidth=1.5, zorder=3))
        x, y = _PLACES[state]
        axes.text(x, y + 0.12, f"$S_{{{state.name[1:]}}}$", fontsize=16, ha="center", va="center", zorder=4)
        axes.text(x, y - 0.24, COMMANDS[state].name.lower(), fontsize=9, ha="center", va="center", zorder=4)
    for edge, causes in transitions.items():
        (x, y), (x_after, y_after) = _PLACES[edge[0]], _PLACES[edge[1]]
        shrink = 72.0 * _RADIUS + 1.0  # a unit of the axes is an inch
        axes.add_patch(
            FancyArrowPatch(
                (x, y),
                (x_after, y_after),
                connectionstyle=f"arc3,rad={_BENDS.get(edge, 0.0)}",
                arrowstyle="-|>",
                mutation_scale=16,
                linewidth=1.3,
                shrinkA=shrink,
                shrinkB=shrink,
                color="black",
                zorder=2,
            )
        )
        at_x, at_y, between = _LABELS.get(edge, ((x + x_after) / 2.0, (y + y_after) / 2.0, "\nor "))
        text = between.join(CONDITIONS[cause] for cause in causes)
        axes.text(at_x, at_y, text, fontsize=10.5, ha="center", va="center", zorder=5)
    return made


def draw(file: Path) -> None:
    """Write the figure as PNG: the same bytes each time, with the transitions as its description.

    Raises:
        OSError: the file cannot be written.
    """
    transitions = find_transitions()
    figure(transitions).savefig(file, dpi=110, metadata={"Software": None, "Description": description(transitions)})
