"""Figures 8.16 to 8.28 are drawn, and what they show is what the chapter sees in them."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.smart_tyre.runs import NOISY, calibration_runs
from book.smart_tyre import numbers
from book.smart_tyre_figures import draw


def test_figures_are_drawn(tmp_path: Path) -> None:
    rows = draw(tmp_path, calibration_runs(NOISY))
    shown = {row["quantity"]: row["value"] for row in rows if row["axle"] in ("front", "both")}
    assert shown["twin spikes a revolution"] == pytest.approx(1.0, abs=0.05)
    assert all(np.isfinite(row["value"]) for row in rows)
    (length,) = numbers(rows)
    assert 24.0 < length["5 %"] <= length["95 %"] < 26.0
    expected = {"figure_8_16.png", "figure_forces.png", *(f"figure_8_{n}.png" for n in range(18, 29))}
    assert {file.name for file in tmp_path.iterdir()} == expected
