"""Draw a drive over changing roads, with the friction that friction_grip knows, as docs/friction_grip_drive.png.

Usage: tools/run.bash python3 -m tools.draw_grip_drive   (normally through `make docs`)
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from benchmarks.grip.drives import drive
from friction_grip.friction_used import FrictionUsed
from friction_grip.parameters import FrictionGripParameters
from friction_grip.road_memory import RoadMemory
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle_file import load_vehicle

PICTURE = Path(__file__).resolve().parents[1] / "docs" / "friction_grip_drive.png"
_SEED, _SECONDS = 4, 180.0
_INTERVAL = 1.96
"""Deviations of a 95 % interval."""
_SHADES = {"dry": "#f4ead5", "wet": "#dbe9f6", "cobblestone": "#e6e0ee", "snow": "#f0f0f0", "ice": "#d5f2f2"}


def main() -> None:
    """Write the picture."""
    driven, vehicle, p = drive(_SEED, _SECONDS), load_vehicle("compact_car"), FrictionGripParameters()
    used, road = (
        FrictionUsed(vehicle),
        RoadMemory(p.prior, p.change_distance, p.proof_distance, 1.0 - p.lower_probability),
    )
    gains = np.array([wheel.brake_gain for wheel in vehicle.wheels])
    distance = np.append(0.0, np.cumsum(driven.speed[1:] * np.diff(driven.time)))
    step = float(driven.time[1] - driven.time[0])
    rows = []
    for k, time in enumerate(driven.time.tolist()):
        stamp, speed = round((time + 1.0) * NANOSECONDS), float(driven.speed[k])
        road.drive(speed * step)
        lateral = float(driven.leftward[k]), float(driven.yaw_rate[k])
        torques = gains * driven.pressure[k]
        found = used.update(stamp, speed, float(driven.forward[k]), *lateral, torques, driven.wheel_speed[k])
        if found is None:
            continue
        road.feel(found, stamp)
        proof = road.proof()
        proven = np.nan if proof is None else proof.mu
        rows.append((distance[k], found.vehicle.mu_used, found.vehicle.stddev, proven, road.bounds().lower))
    at, mu, deviation, proven, lower = np.array(rows).T

    figure = Figure(figsize=(9.0, 4.0), layout="constrained")
    axes = figure.subplots()
    borders = [0, *(np.flatnonzero([a != b for a, b in zip(driven.road, driven.road[1:], strict=False)]) + 1).tolist()]
    for begin, end in zip(borders, [*borders[1:], len(driven.road) - 1], strict=True):
        axes.axvspan(distance[begin], distance[end], color=_SHADES[driven.road[begin]], linewidth=0)
        axes.text(0.5 * (distance[begin] + distance[end]), 1.27, driven.road[begin], ha="center", fontsize=8)
    axes.plot(distance, driven.mu_max, color="black", linewidth=1.2, label="friction of the road")
    axes.fill_between(at, mu - _INTERVAL * deviation, mu + _INTERVAL * deviation, color="#8ec1e8", linewidth=0)
    axes.plot(at, mu, color="#1b6ca8", linewidth=1.0, label="used, with its 95 % interval")
    axes.plot(at, proven, color="#2e7d32", linewidth=1.4, label="proven within 100 m")
    axes.plot(at, lower, color="#c0392b", linewidth=1.2, linestyle="--", label="lower bound, 95 %")
    axes.set(xlabel="distance [m]", ylabel="friction", xlim=(0.0, float(distance[-1])), ylim=(0.0, 1.35))
    axes.grid(alpha=0.3)
    figure.legend(loc="outside lower center", ncols=4, fontsize=8)
    figure.savefig(PICTURE, dpi=110, metadata={"Software": None})


if __name__ == "__main__":
    main()
