"""What the summary says of the releases of the brake."""

from __future__ import annotations

import numpy as np
import pytest
from friction_msgs.msg import BrakeCommand
from rich.console import Console

from friction_bags.drive_page.recorded_run import RecordedRun, Series
from friction_bringup.summary import release_table

TIME = np.arange(0.0, 2.0, 0.01)


def run_with_releases(*, shadow: bool) -> RecordedRun:
    """One wheel, released from 0.5 to 0.7 s and from 1.0 to 1.3 s; five releases refused, one ended by a cap."""
    released = ((TIME > 0.495) & (TIME < 0.695)) | ((TIME > 0.995) & (TIME < 1.295))
    command = np.where(released, float(BrakeCommand.DECREASE), float(BrakeCommand.INCREASE))
    counts = {"refused_releases": np.where(TIME < 1.5, 2.0, 5.0), "caps": np.where(TIME < 1.3, 0.0, 1.0)}
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
