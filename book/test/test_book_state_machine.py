"""Figure 8.1 is drawn from the machine: its transitions are the documented ones, and the picture can be read."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.image import imread
from matplotlib.patches import Circle, FancyArrowPatch
from matplotlib.path import Path as PlotPath
from matplotlib.text import Text
from PIL import Image

from abs_supervisor.state_machine import Cause, State
from book.state_machine_figure import CONDITIONS, description, draw, figure, find_transitions

OUT = (Cause.BRAKING_OVER, Cause.FAIL_SAFE, Cause.LOW_SPEED)
DOCUMENTED = {
    (State.S0, State.S1): (Cause.BRAKING,),
    (State.S1, State.S0): OUT,
    (State.S1, State.S21): (Cause.INSTABILITY,),
    (State.S21, State.S0): OUT,
    (State.S21, State.S22): (Cause.WAIT_OVER,),
    (State.S22, State.S0): OUT,
    (State.S22, State.S1): (Cause.STABILITY, Cause.RELEASE_TIMEOUT),
}
"""Section 8.2.2 and the README of abs_supervisor."""


def test_transitions_that_are_found_are_the_documented_ones() -> None:
    assert find_transitions() == DOCUMENTED


def test_every_cause_of_a_transition_can_be_written() -> None:
    assert set(CONDITIONS) == set(Cause) - {Cause.NONE, Cause.RESET}


def test_a_transition_that_is_not_documented_would_be_drawn_too() -> None:
    more = {**DOCUMENTED, (State.S0, State.S22): (Cause.WAIT_OVER,)}
    assert len(figure(more).axes[0].texts) == len(figure(DOCUMENTED).axes[0].texts) + 1


def test_no_text_lies_over_another_or_over_an_arrow_or_the_edge_of_a_state() -> None:
    made = figure(DOCUMENTED)
    FigureCanvasAgg(made).draw()
    axes = made.axes[0]
    texts = [text for text in axes.findobj(Text) if text.get_text()]
    boxes = [text.get_window_extent() for text in texts]
    assert len(boxes) == len(DOCUMENTED) + 2 * len(State) + 1
    assert not [pair for pair in combinations(boxes, 2) if pair[0].overlaps(pair[1])]
    assert all(made.bbox.contains(*corner) for box in boxes for corner in box.corners())
    lines = [patch for patch in axes.patches if isinstance(patch, (FancyArrowPatch, Circle))]
    assert len(lines) == len(DOCUMENTED) + len(State)
    for patch in lines:
        path = patch.get_transform().transform_path(patch.get_path())
        drawn = PlotPath(np.asarray(path.vertices)[:-1], np.asarray(path.codes)[:-1])  # without the mark of its end
        pieces = [PlotPath(polygon) for polygon in drawn.to_polygons(closed_only=False)]
        crossed = [box for box in boxes for piece in pieces if piece.intersects_bbox(box, filled=False)]
        assert not crossed


def test_the_picture_is_the_same_each_time_and_carries_what_it_shows(tmp_path: Path) -> None:
    one, other = tmp_path / "one.png", tmp_path / "other.png"
    draw(one)
    draw(other)
    assert one.read_bytes() == other.read_bytes()
    assert Image.open(one).info["Description"] == description(DOCUMENTED)
    assert imread(one).shape[1] > 900
