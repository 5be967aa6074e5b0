"""Draw a drive over changing roads, with the friction that friction_grip knows, as docs/friction_grip_drive.png.

Usage: tools/run.bash python3 -m tools.draw_grip_drive   (normally through `make docs`)
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from benchmarks.grip.drives import drive
from benchmarks.grip.part import tell, used_over
from friction_grip.parameters import FrictionGripParameters
from vehicle_models.vehicle_file import load_vehicle

PICTURE = Path(__file__).resolve().parents[1] / "docs" / "friction_grip_drive.png"
_SEED, _SECONDS = 4, 180.0
_INTERVAL = 1.96
"""Deviations of a 95 % interval."""
_SHADES = {"dry": "#f4ead5", "wet": "#dbe9f6", "cobblestone": "#e6e0ee", "snow": "#f0f0f0", "ice": "#d5f2f2"}


def main() -> None:
    """Write the picture."""
    driven = drive(_SEED, _SECONDS)
    used = used_over(driven, driven.speed, load_vehicle("compact_car"))
    told = tell(driven, driven.speed, used, FrictionGripParameters())
    at, mu, reach = told.travelled, told.used[:, 0], _INTERVAL * told.stddev[:, 0]
    distance = np.append(0.0, np.cumsum(driven.speed[1:] * np.diff(driven.time)))

    figure = Figure(figsize=(9.0, 4.0), layout="constrained")
    axes = figure.subplots()
    borders = [0, *(np.flatnonzero([a != b for a, b in zip(driven.road, driven.road[1:], strict=False)]) + 1).tolist()]
    for begin, end in zip(borders, [*borders[1:], len(driven.road) - 1], strict=True):
        axes.axvspan(distance[begin], distance[end], color=_SHADES[driven.road[begin]], linewidth=0)
        axes.text(0.5 * (distance[begin] + distance[end]), 1.27, driven.road[begin], ha="center", fontsize=8)
    axes.plot(distance, driven.mu_max, color="black", linewidth=1.2, label="friction of the road")
    axes.fill_between(at, mu - reach, mu + reach, color="#8ec1e8", linewidth=0)
    axes.plot(at, mu, color="#1b6ca8", linewidth=1.0, label="used, with its 95 % interval")
    axes.plot(at, told.proven, color="#2e7d32", linewidth=1.4, label="proven within 100 m")
    axes.plot(at, told.lower, color="#c0392b", linewidth=1.2, linestyle="--", label="lower bound, 95 %")
    axes.set(xlabel="distance [m]", ylabel="friction", xlim=(0.0, float(distance[-1])), ylim=(0.0, 1.35))
    axes.grid(alpha=0.3)
    figure.legend(loc="outside lower center", ncols=4, fontsize=8)
    figure.savefig(PICTURE, dpi=110, metadata={"Software": None})


if __name__ == "__main__":
    main()
