"""Draw an ABS stop on snow, with speed and slip as wheel_slip estimates them, as docs/wheel_slip_stop.png.

Usage: tools/run.bash python3 -m tools.draw_slip_stop   (normally through `make docs`)
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from benchmarks.slip.stops import CAR, stops
from vehicle_models.reason import Reason
from wheel_slip.estimator import SlipEstimator

PICTURE = Path(__file__).resolve().parents[1] / "docs" / "wheel_slip_stop.png"
_STEP = 5_000_000
_BEFORE, _INTERVAL, _WHEEL = 200, 1.96, 0
"""Samples shown before the brake; deviations of a 95 % interval; front left."""


def main() -> None:
    """Write the picture."""
    stop = stops("snow", range(1))[0]
    estimator = SlipEstimator(CAR)
    rows = [
        estimator.update((k + 1) * _STEP, omega.tolist(), float(reading))[_WHEEL]
        for k, (omega, reading) in enumerate(zip(stop.wheel_speed, stop.acceleration, strict=True))
    ]
    shown = slice(stop.onset - _BEFORE, None)
    time = 1e-9 * _STEP * (np.arange(len(rows)) - stop.onset)
    speed = np.array([row.vehicle_speed for row in rows])
    deviation = np.sqrt([row.vehicle_speed_variance for row in rows])
    valid = np.array([row.reason is Reason.OK for row in rows])
    slip = np.where(valid, [row.slip for row in rows], np.nan)
    slip_deviation = np.sqrt(np.where(valid, [row.slip_variance for row in rows], np.nan))
    rim = stop.wheel_speed[:, _WHEEL] * CAR.radii[_WHEEL]

    figure = Figure(figsize=(9.0, 5.6), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True)
    drawn = (
        (above, "speed [m/s]", speed, deviation, stop.speed),
        (below, "slip [-]", slip, slip_deviation, stop.slip[:, _WHEEL]),
    )
    above.plot(time[shown], rim[shown], color="0.7", linewidth=0.8, label="rim, front left")
    for axes, name, found, width, truth in drawn:
        band = _INTERVAL * width
        axes.fill_between(
            time[shown], (found - band)[shown], (found + band)[shown], color="#8ec1e8", label="95 % interval"
        )
        axes.plot(time[shown], truth[shown], color="black", linewidth=1.2, label="truth")
        axes.plot(time[shown], found[shown], color="#1b6ca8", linewidth=1.0, linestyle="--", label="estimate")
        axes.set_ylabel(name)
        axes.grid(alpha=0.3)
        axes.legend(loc="upper right", fontsize=8)
    below.set_ylim(-0.1, 0.4)
    below.set_xlabel("time since the brake [s]")
    figure.suptitle("ABS stop on snow without speed sensor and brake pressure", fontsize=11)
    figure.savefig(PICTURE, dpi=110, metadata={"Software": None})


if __name__ == "__main__":
    main()
