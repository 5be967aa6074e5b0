"""Plots of a recorded run: one page for each wheel, and one of all wheels where there are several."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise
from pathlib import Path

import numpy as np
from friction_msgs.msg import BrakeCommand
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from friction_bags.drive_page.codes import COMMANDS, ENVELOPE, SIGNS, STATES, signs, verdicts
from friction_bags.drive_page.recorded_run import Array, RecordedRun, Series
from friction_bringup.braking_metrics import best_speed
from friction_bringup.graph import VEHICLE
from friction_bringup.summary import braking_of

ESTIMATE, TRUTH, PEAK, DEMAND, IDENTIFIED = "tab:blue", "black", "tab:red", "tab:orange", "tab:purple"
STABLE_BAND, UNSTABLE_BAND, UNKNOWN_BAND = "#8fd19e", "#f28b82", "#d9d9d9"
WHEEL_COLOURS = ("tab:blue", "tab:orange", "tab:green", "tab:brown", "tab:pink", "tab:olive")
_MARGIN = 0.3
"""Time [s] shown before and after a braking."""
_SLIP_SHOWN_FROM = 5.0
"""Speed [m/s] above which the axis covers every slip; locked wheels below it matter little."""
COMMAND_COLOURS = {
    BrakeCommand.NONE: UNKNOWN_BAND,
    BrakeCommand.INCREASE: "#9ecae1",
    BrakeCommand.HOLD: "#fdd49e",
    BrakeCommand.DECREASE: "#c994c7",
}
ENVELOPE_COLOURS = {0: UNKNOWN_BAND, 1: STABLE_BAND, 2: UNSTABLE_BAND, 3: "#c49c94"}
SIGN_COLOURS = {-1: UNSTABLE_BAND, 0: UNKNOWN_BAND, 1: STABLE_BAND}


def write_plots(run: RecordedRun, directory: Path, title: str) -> list[Path]:
    """Draw every plot of a run.

    Args:
        run: the run.
        directory: existing directory for the PNG files.
        title: begin of the title of each plot.

    Returns:
        Paths of the plots.
    """
    paths = []
    for wheel in run.wheels:
        slope = run.get(f"{wheel}/friction_slope")
        if len(run.wheels) == 1 or (slope is not None and np.any(slope["valid"] > 0.0)):
            paths.append(_save(wheel_figure(run, wheel, f"{title}, {wheel}"), directory / f"{wheel}.png"))
    if len(run.wheels) > 1:
        paths.append(_save(all_wheels_figure(run, title, None), directory / "wheels.png"))
        if (braking := run.hardest_braking()) is not None:
            name = f"{title}, the hardest braking"
            paths.append(_save(all_wheels_figure(run, name, braking), directory / "wheels_braking.png"))
    return paths


def wheel_figure(run: RecordedRun, wheel: str, title: str) -> Figure:
    """Draw speed, slip, slope indicator, supervisor and brake of one wheel over time."""
    figure = Figure(figsize=(11.0, 13.0), layout="constrained")
    axes: list[Axes] = list(figure.subplots(5, 1, sharex=True, height_ratios=[2.0, 3.0, 2.5, 1.6, 2.0]))
    figure.suptitle(title)
    _draw_speeds(axes[0], run, [wheel])
    _draw_slip(axes[1], run, wheel)
    _draw_indicator(axes[2], run, wheel)
    _draw_supervisor(axes[3], run, wheel)
    _draw_brake(axes[4], run, wheel)
    _finish(axes)
    return figure


def all_wheels_figure(run: RecordedRun, title: str, span: tuple[float, float] | None) -> Figure:
    """Draw speeds, slips, the sign of the slope and forces of all wheels, over all time or a span of it."""
    forces = any(run.get(f"{start}{wheel}/tyre_force") is not None for wheel in run.wheels for start in ("", "truth/"))
    figure = Figure(figsize=(11.0, 14.0 if forces else 9.0), layout="constrained")
    ratios = [2.5, 3.0, 1.5, *([2.5, 2.5] if forces else [])]
    axes: list[Axes] = list(figure.subplots(len(ratios), 1, sharex=True, height_ratios=ratios))
    figure.suptitle(title)
    _draw_speeds(axes[0], run, run.wheels)
    for wheel, colour in zip(run.wheels, WHEEL_COLOURS, strict=False):
        if (slip := run.get(f"{wheel}/slip")) is not None:
            axes[1].plot(slip.time, slip["slip"], color=colour, lw=1.0, label=wheel)
    _draw_identified_peak(axes[1], run, VEHICLE)
    if (curve := run.get(f"truth/{run.wheels[0]}/friction_curve")) is not None:
        axes[1].plot(curve.time, curve["lambda_max"], color=PEAK, lw=1.2, ls="--", label="λ_max of the road, true")
    axes[1].set_ylabel("slip λ [-]")
    labels = []
    for row, wheel in enumerate(run.wheels):
        slope = run.get(f"{wheel}/friction_slope")
        labels.append(wheel)
        if slope is not None:
            _strip(axes[2], slope.time, signs(slope), SIGN_COLOURS, (row - 0.4, row + 0.4))
            if not np.any(slope["valid"] > 0.0):
                why = f"never valid: {slope.reasons.most_common(1)[0][0]}"
                axes[2].text(0.5, row, why, transform=axes[2].get_yaxis_transform(), ha="center", va="center")
    axes[2].set_yticks(range(len(labels)), labels)
    axes[2].set_ylim(len(labels) - 0.5, -0.5)
    axes[2].set_ylabel("slope sign")
    _legend_of_bands(axes[2], SIGNS, SIGN_COLOURS)
    if forces:
        _draw_force(axes[3], run, "fx")
        _draw_force(axes[4], run, "fz")
    _finish(axes)
    if span is not None:
        axes[0].set_xlim(span[0] - _MARGIN, span[1] + _MARGIN)
    return figure


def _draw_force(axes: Axes, run: RecordedRun, name: str) -> None:
    """Draw a force of each wheel: a dot for each revolution with a valid one, the truth as a line."""
    reasons: Counter[str] = Counter()
    for wheel, colour in zip(run.wheels, WHEEL_COLOURS, strict=False):
        if (truth := run.get(f"truth/{wheel}/tyre_force")) is not None:
            axes.plot(truth.time, 1e-3 * truth[name], color=colour, lw=0.7, alpha=0.6, label=f"{wheel}, true")
        if (force := run.get(f"{wheel}/tyre_force")) is not None:
            valid = force["valid"] > 0.0
            reasons.update(force.reasons if not np.any(valid) else {})
            label = f"{wheel}, from its tyre"
            axes.plot(force.time[valid], 1e-3 * force[name][valid], ls="", marker="o", ms=3, color=colour, label=label)
    for row, text in enumerate(reasons):
        axes.text(0.5, 0.9 - 0.12 * row, f"never valid: {text}", transform=axes.transAxes, ha="center", va="center")
    axes.set_ylabel({"fx": "Fx [kN], forward", "fz": "Fz [kN]"}[name])


def _draw_speeds(axes: Axes, run: RecordedRun, wheels: tuple[str, ...] | list[str]) -> None:
    colours = WHEEL_COLOURS if len(wheels) > 1 else (ESTIMATE,)
    for wheel, colour in zip(wheels, colours, strict=False):
        if (slip := run.get(f"{wheel}/slip")) is not None:
            circumference = slip["vehicle_speed"] * (1.0 - slip["slip"])
            axes.plot(slip.time, circumference, color=colour, lw=0.8, label=f"{wheel}: wheel speed ω r")
    if (slip := run.get(f"{wheels[0]}/slip")) is not None:
        axes.plot(slip.time, slip["vehicle_speed"], color="tab:cyan", lw=1.2, label="vehicle speed, estimated")
    for topic, label in (("truth/vehicle_velocity", "vehicle speed, true"), ("vehicle_velocity", "speed sensor")):
        if (series := run.get(topic)) is not None:
            axes.plot(series.time, series["twist.twist.linear.x"], color=TRUTH, lw=0.9, ls="--", label=label)
            break
    if len(wheels) == 1:
        _draw_bound(axes, run, wheels[0])
    axes.set_ylabel("speed [m/s]")


def _draw_bound(axes: Axes, run: RecordedRun, wheel: str) -> None:
    """Draw the bound of the brake, and say in the legend how much of the friction was used."""
    speed, slip = run.get("truth/vehicle_velocity"), run.get(f"truth/{wheel}/slip")
    curve, braking = run.get(f"truth/{wheel}/friction_curve"), braking_of(run)
    if speed is None or slip is None or curve is None or isinstance(braking, str):
        return
    time = speed.time
    of_wheel = np.interp(time, slip.time, np.nan_to_num(slip["slip"]))
    peak, mu_max = (np.interp(time, curve.time, curve[name]) for name in ("lambda_max", "mu_max"))
    best = best_speed(time, speed["twist.twist.linear.x"], of_wheel, peak, mu_max, braking.onset)
    label = f"bound of the brake; utilisation {braking.utilisation:.3f}"
    axes.plot(time, best, color=PEAK, lw=1.0, ls=":", label=label)


def _draw_identified_peak(axes: Axes, run: RecordedRun, name: str) -> None:
    """Draw lambda_max of the identified curve, where valid, with a band of two standard deviations."""
    if (curve := run.get(f"{name}/friction_curve")) is None or not np.any(curve["valid"] > 0.0):
        return
    peak = np.where(curve["valid"] > 0.0, curve["lambda_max"], np.nan)
    reach = 2.0 * curve["lambda_max_stddev"]
    axes.plot(curve.time, peak, color=IDENTIFIED, lw=1.2, label="λ_max, identified (± 2 σ)")
    axes.fill_between(curve.time, peak - reach, peak + reach, color=IDENTIFIED, alpha=0.3, lw=0.0)


def _draw_slip(axes: Axes, run: RecordedRun, wheel: str) -> None:
    if (true_slope := run.get(f"truth/{wheel}/friction_slope")) is not None:
        axes.fill_between(
            true_slope.time,
            0.0,
            1.0,
            where=list(true_slope["sign"] < 0.0),
            transform=axes.get_xaxis_transform(),
            color=UNSTABLE_BAND,
            alpha=0.35,
            lw=0.0,
            label="truly beyond the peak",
        )
    top = 0.3
    if (slip := run.get(f"{wheel}/slip")) is not None:
        axes.plot(slip.time, slip["slip"], color=ESTIMATE, lw=0.9, label="slip, estimated")
    if (truth := run.get(f"truth/{wheel}/slip")) is not None:
        axes.plot(truth.time, truth["slip"], color=TRUTH, lw=0.8, label="slip, true")
        shown = truth["slip"][truth["vehicle_speed"] > _SLIP_SHOWN_FROM]
        top = max(top, 1.05 * float(np.max(shown, initial=0.0)))
    if (curve := run.get(f"truth/{wheel}/friction_curve")) is not None:
        axes.plot(curve.time, curve["lambda_max"], color=PEAK, lw=1.2, ls="--", label="λ_max of the road, true")
        top = max(top, 2.0 * float(np.nanmax(curve["lambda_max"])))
    _draw_identified_peak(axes, run, wheel)
    if (supervisor := run.get(f"{wheel}/abs_supervisor")) is not None and np.any(
        np.isfinite(supervisor["slip_set_point"])
    ):
        axes.plot(
            supervisor.time, supervisor["slip_set_point"], color="tab:green", lw=1.2, label="set-point of the law"
        )
    events = run.crossings(f"{wheel}/friction_slope")
    for sign, marker, label in ((-1, "v", "crossing detected: peak passed"), (1, "^", "crossing detected: regained")):
        chosen = [event for event in events if event.sign == sign]
        axes.plot(
            [event.time for event in chosen],
            [event.slip for event in chosen],
            ls="",
            marker=marker,
            ms=6,
            mfc="white",
            mec=PEAK if sign < 0 else "tab:green",
            label=label,
        )
    axes.set_ylim(-0.02, min(top, 1.02))
    axes.set_ylabel("slip λ [-]")


def _draw_indicator(axes: Axes, run: RecordedRun, wheel: str) -> None:
    slope = run.get(f"{wheel}/friction_slope")
    if slope is None:
        return
    if not np.any(slope["valid"] > 0.0):
        reason = slope.reasons.most_common(1)[0][0]
        axes.text(0.5, 0.5, f"never valid: {reason}", transform=axes.transAxes, ha="center", va="center", wrap=True)
    used = np.where(slope["valid"] > 0.0, 1e-3 * slope["indicator"], np.nan)
    axes.plot(slope.time, 1e-3 * slope["h"], color="0.7", lw=0.7, label="H")
    axes.plot(slope.time, used, color=ESTIMATE, lw=0.9, label="indicator H sign(·), where valid")
    axes.axhline(0.0, color=TRUTH, lw=0.6)
    known = used[np.isfinite(used)]
    reach = float(np.percentile(np.abs(known), 99.0)) * 1.3 if known.size else 1.0
    axes.set_ylim(-1.35 * reach, reach)
    _strip(axes, slope.time, signs(slope), SIGN_COLOURS, (-1.33 * reach, -1.12 * reach))
    _legend_of_bands(axes, {sign: f"sign: {text}" for sign, text in SIGNS.items()}, SIGN_COLOURS)
    axes.set_ylabel("H, indicator [10³ rad/s³]")


def _draw_supervisor(axes: Axes, run: RecordedRun, wheel: str) -> None:
    levels = {state: row for row, state in enumerate(STATES)}
    if (supervisor := run.get(f"{wheel}/abs_supervisor")) is not None:
        rows = np.array([levels[int(state)] for state in supervisor["state"]], dtype=np.float64)
        axes.step(supervisor.time, rows, where="post", color=TRUTH, lw=1.0)
        _strip(axes, supervisor.time, verdicts(supervisor), ENVELOPE_COLOURS, (-1.9, -1.3))
    if (command := run.get(f"{wheel}/brake_command")) is not None:
        _strip(axes, command.time, command["command"], COMMAND_COLOURS, (-1.1, -0.5))
    axes.set_yticks(
        [-1.6, -0.8, *levels.values()], ["envelope", "command", *(text.partition(",")[0] for text in STATES.values())]
    )
    axes.set_ylim(-2.0, len(levels) - 0.7)
    axes.set_ylabel("supervisor")
    _legend_of_bands(axes, COMMANDS, COMMAND_COLOURS)
    _legend_of_bands(axes, ENVELOPE, ENVELOPE_COLOURS)


def _draw_brake(axes: Axes, run: RecordedRun, wheel: str) -> None:
    demand, supervisor = run.get("brake_demand"), run.get(f"{wheel}/abs_supervisor")
    if (pressure := run.get(f"{wheel}/brake_pressure")) is not None:
        axes.plot(pressure.time, 1e-6 * pressure["fluid_pressure"], color=ESTIMATE, lw=0.9, label="line pressure")
        axes.set_ylim(0.0, max(1e-6, 1.15e-6 * float(np.nanmax(pressure["fluid_pressure"]))))
    if supervisor is not None and demand is not None and (gain := _brake_gain(demand, supervisor)) > 0.0:
        aim = 1e-6 * supervisor["torque_set_point"] / gain
        axes.plot(supervisor.time, aim, color="tab:green", lw=0.8, label="set-point of the law")
    if demand is not None:
        axes.plot(demand.time, 1e-6 * demand["pressure"], color=DEMAND, lw=1.0, ls="--", label="driver's demand")
        axes.set_ylim(0.0, max(axes.get_ylim()[1], 1.1e-6 * float(np.nanmax(demand["pressure"]))))
        if supervisor is not None and (gain := _brake_gain(demand, supervisor)) > 0.0:
            per_megapascal = 1e6 * gain
            torque = axes.secondary_yaxis(
                "right", functions=(lambda p: np.asarray(p) * per_megapascal, lambda t: np.asarray(t) / per_megapascal)
            )
            torque.set_ylabel("brake torque [N m]")
    axes.set_ylabel("brake pressure [MPa]")


def _brake_gain(demand: Series, supervisor: Series) -> float:
    """Gain k of T_b = k p [N m/Pa], as the supervisor applies it to the demand; 0 where there was none."""
    pressure, torque = float(np.nanmax(demand["pressure"])), float(np.nanmax(supervisor["demand_torque"]))
    return torque / pressure if pressure > 0.0 and np.isfinite(torque) else 0.0


def _strip(axes: Axes, time: Array, values: Array, colours: dict[int, str], span: tuple[float, float]) -> None:
    """Fill a horizontal strip with the colour of each value."""
    edges = np.concatenate([[0], np.flatnonzero(np.diff(values)) + 1, [time.size - 1]])
    for begin, end in pairwise(edges):
        colour = colours.get(int(values[begin]), UNKNOWN_BAND)
        axes.fill_between([time[begin], time[end]], *span, color=colour, lw=0.0)


def _legend_of_bands(axes: Axes, texts: dict[int, str], colours: dict[int, str]) -> None:
    for code, text in texts.items():
        axes.fill_between([], [], color=colours[code], label=text)


def _finish(axes: list[Axes]) -> None:
    for each in axes:
        each.grid(visible=True, lw=0.3)
        if each.get_legend_handles_labels()[1]:
            each.legend(loc="upper left", bbox_to_anchor=(1.0 if each.child_axes == [] else 1.09, 1.0), fontsize=8)
    axes[-1].set_xlabel("time since the first sample [s]")


def _save(figure: Figure, path: Path) -> Path:
    FigureCanvasAgg(figure)
    figure.savefig(path, dpi=110)
    return path
