"""Releases of the brake in the summary."""

from __future__ import annotations

import numpy as np
import pytest
from friction_msgs.msg import BrakeCommand, SupervisorState
from rich.console import Console

from friction_bags.results.recorded_run import RecordedRun, Series
from friction_report.summary import release_table, sign_text

TIME = np.arange(0.0, 2.0, 0.01)


def run_with_releases(*, shadow: bool) -> RecordedRun:
    """One wheel, released from 0.5 to 0.7 s and from 1.0 to 1.3 s; five releases refused, one ended by a cap."""
    released = ((TIME > 0.495) & (TIME < 0.695)) | ((TIME > 0.995) & (TIME < 1.295))
    command = np.where(released, float(BrakeCommand.DECREASE), float(BrakeCommand.INCREASE))
    cap = np.where((TIME > 1.295) & (TIME < 1.6), float(SupervisorState.LIMIT_NO_SPIN_UP), 0.0)
    counts = {"refused_releases": np.where(TIME < 1.5, 2.0, 5.0), "limit": cap}
    series = {"front_left/abs_supervisor": Series(TIME, {"command": command, **counts})}
    if not shadow:
        series["front_left/brake_command"] = Series(TIME, {"command": command})
    return RecordedRun(("front_left",), 0, series, TIME)


@pytest.mark.parametrize("shadow", [False, True])
def test_releases_are_added_up_and_those_of_shadow_mode_are_called_so(shadow: bool) -> None:
    console = Console(width=120, color_system=None)
    with console.capture() as capture:
        console.print(release_table(run_with_releases(shadow=shadow)))
    text = capture.get()
    assert ("shadow mode" in text) is shadow
    (row,) = (line for line in text.splitlines() if "front_left" in line)
    assert row.replace("│", " ").split() == ["front_left", "0.50", "0.30", "5", "1"]


def test_valid_signs_are_compared_with_the_truth_at_their_own_time() -> None:
    """The truth turns at 1 s; an estimate that says so 0.1 s later, with that delay, is right all along."""
    truth = np.where(TIME < 0.995, 1.0, -1.0)
    late = np.where(TIME < 1.095, 1.0, -1.0)
    delay, valid = np.full(TIME.shape, 0.1), (TIME > 0.495).astype(float)

    def said(age: np.ndarray) -> str:
        series = {
            "front_left/friction_slope": Series(TIME, {"sign": late, "valid": valid, "delay": age}),
            "truth/front_left/friction_slope": Series(TIME, {"sign": truth}),
        }
        return sign_text(RecordedRun(("front_left",), 0, series, TIME), "front_left")

    assert "150 of 150 valid" in said(delay)
    assert "140 of 150 valid" in said(0.0 * delay)
