"""Lines over time, strips of codes, friction curves and the track of a recorded run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from friction_msgs.msg import BrakeCommand, SupervisorState
from numpy.typing import NDArray

from friction_bags.results.braking_rows import Fit, fits_of
from friction_bags.results.recorded_run import VEHICLE, WHY, Array, RecordedRun, Series
from friction_runtime.reports import INTERVAL_95, plain_reason
from vehicle_models.nanoseconds import NANOSECONDS

_GRIP_DELAY = 0.1
"""Age [s] of the friction used at its stamp: half of the time over which it is a mean."""
SIGNS = {-1: "beyond the peak", 0: "not known", 1: "stable side"}
STATES = {
    SupervisorState.S0: "S0, no braking",
    SupervisorState.S1: "S1, stable side: increase",
    SupervisorState.S21: "S21, beyond the peak: the release begins to act",
    SupervisorState.S22: "S22, beyond the peak: decrease",
}
"""States of Figure 8.1; the name stands before the comma."""
LAWS = {SupervisorState.LAW_SLOPE_SIGN: "slope sign", SupervisorState.LAW_CURVE: "curve"}
COMMANDS = {
    BrakeCommand.NONE: "none",
    BrakeCommand.INCREASE: "increase",
    BrakeCommand.HOLD: "hold",
    BrakeCommand.DECREASE: "decrease",
}
VERDICTS = {0: "no release asked for", 1: "release allowed", 2: "release refused", 3: "limit"}
"""Verdict of the intervention on what the law asks for."""
INTERVENTION = {0: "standby", 1: "active", 2: "return"}
DRIVER = "driver"
"""Stands for the name of a wheel in what the driver asks for."""


@dataclass(frozen=True)
class Line:
    """A quantity over time, or a band around it."""

    panel: str
    label: str
    of: str
    """Wheel, VEHICLE or DRIVER."""
    kind: str
    """estimate, points (an estimate a revolution), bound, truth, sensor, aim (of the supervisor's law) or demand."""
    topic: str
    time: Array
    """[s], shape (n,)."""
    values: Array
    """Shape (n,); NaN where there is none."""
    band: tuple[Array, Array] | None = None
    """Lower and upper end of the 95 % interval, each of shape (n,)."""


@dataclass(frozen=True)
class Strip:
    """Codes over time, such as states."""

    panel: str
    group: str
    """Heading above the strips of one kind."""
    of: str
    """Wheel or VEHICLE."""
    time: Array
    """[s], shape (n,)."""
    codes: Array
    """Shape (n,)."""
    meanings: Mapping[int, str]


@dataclass(frozen=True)
class Curves:
    """Friction curves of a wheel or the vehicle, each in force from its time on."""

    label: str
    of: str
    """Wheel or VEHICLE."""
    kind: str
    """estimate or truth."""
    time: Array
    """[s], shape (n,)."""
    columns: Mapping[str, Array]
    """theta_1 to theta_3, lambda_max, mu_max and their standard deviations, each of shape (n,)."""


@dataclass(frozen=True)
class Track:
    """Where the car was, and what the road was known to have there."""

    time: Array
    """[s], shape (n,)."""
    east: Array
    """[m], shape (n,); NaN where no place is known."""
    north: Array
    values: Mapping[str, Array]
    """Friction by name, each of shape (n,)."""


def track_of(run: RecordedRun) -> Track | None:
    """Return the track of a run, None where places or the grip are missing."""
    grip = run.get("grip")
    if grip is None:
        return None
    east, north = run.places().metres(run.start + np.round(grip.time * NANOSECONDS).astype(np.int64))
    if not np.any(np.isfinite(east)):
        return None
    return Track(grip.time, east, north, {name: grip[name] for name in ("mu_proven", "mu_lower")})


def lines_of(run: RecordedRun) -> Iterator[Line]:
    """Yield every line that a run can hold, also those without any value."""
    yield from _speeds(run)
    for wheel in run.wheels:
        yield from _slips(run, wheel)
        yield from _brake(run, wheel)
        yield from _forces(run, wheel)
    yield from _peaks(run)
    yield from _grip(run)
    yield from _demands(run)


def strips_of(run: RecordedRun) -> Iterator[Strip]:
    """Yield every strip of a run."""
    slopes = {wheel: slope for wheel in run.wheels if (slope := run.get(f"{wheel}/friction_slope")) is not None}
    signed = {wheel: slope for wheel, slope in slopes.items() if np.any(slope["valid"] > 0.0)}
    for wheel, slope in signed.items():
        time = _own_time(slope)
        order = np.argsort(time, kind="stable")
        yield Strip("sign", "estimated", wheel, time[order], signs(slope)[order], SIGNS)
    for wheel in run.wheels if signed or not slopes else ():
        if (truth := run.get(f"truth/{wheel}/friction_slope")) is not None:
            yield Strip("sign", "true", wheel, truth.time, truth["sign"], SIGNS)
    for group, meanings in (("state", STATES), ("law", LAWS), ("intervention", INTERVENTION)):
        for wheel in run.wheels:
            if (supervisor := run.get(f"{wheel}/abs_supervisor")) is not None:
                yield Strip("supervisor", group, wheel, supervisor.time, supervisor[group], meanings)
    for wheel in run.wheels:
        if (supervisor := run.get(f"{wheel}/abs_supervisor")) is not None:
            yield Strip("supervisor", "release", wheel, supervisor.time, verdicts(supervisor), VERDICTS)
    for wheel in run.wheels:
        if (command := run.get(f"{wheel}/brake_command")) is not None:
            yield Strip("supervisor", "command", wheel, command.time, command["command"], COMMANDS)
    yield from _validities(run)


def curves_of(run: RecordedRun) -> Iterator[Curves]:
    """Yield the valid friction curves of each wheel and the vehicle, then the true ones where they change."""
    for fit in fits_of(run, ""):
        if np.any(valid := fit.curve["valid"] > 0.0):
            yield _curves(fit, "estimate", valid)
    for fit in fits_of(run, "truth/"):
        theta = np.stack([fit.curve[f"theta_{i}"] for i in (1, 2, 3)], axis=1)
        yield _curves(fit, "truth", np.any(np.diff(theta, axis=0, prepend=np.nan) != 0.0, axis=1))


def _own_time(slope: Series) -> Array:
    """Return the times [s] at which the signs were those of the wheel: stamp minus delay."""
    delay = slope["delay"]
    known = np.isfinite(delay)
    return slope.time - np.where(known, delay, np.median(delay[known]) if known.any() else 0.0)


def signs(slope: Series) -> Array:
    """Return the key of SIGNS at every sample of a friction_slope: 0 where it is not valid."""
    return np.where(slope["valid"] > 0.0, slope["sign"], 0.0)


def verdicts(supervisor: Series) -> Array:
    """Return the key of VERDICTS at every sample of an abs_supervisor: the limit in force, else the evidence."""
    release = supervisor["release"]
    asked = np.where(release == SupervisorState.RELEASE_REFUSED, 2.0, 1.0)
    judged = np.where(release == SupervisorState.RELEASE_NOT_WANTED, 0.0, asked)
    return np.where(supervisor["limit"] == SupervisorState.LIMIT_NONE, judged, 3.0)


def _speeds(run: RecordedRun) -> Iterator[Line]:
    for wheel in run.wheels:
        if (slip := run.get(f"{wheel}/slip")) is not None:
            label = f"{wheel}, ω r"
            yield Line("speed", label, wheel, "estimate", f"{wheel}/slip", slip.time, _circumference(slip))
    for wheel in run.wheels:
        if (slip := run.get(f"{wheel}/slip")) is not None and np.any(np.isfinite(slip["vehicle_speed"])):
            values = slip["vehicle_speed"]
            yield Line("speed", "car, estimated", VEHICLE, "estimate", f"{wheel}/slip", slip.time, values)
            break
    for topic, label, kind in (
        ("vehicle_velocity", "car, speed sensor", "sensor"),
        ("truth/vehicle_velocity", "car, true", "truth"),
    ):
        if (velocity := run.get(topic)) is not None:
            yield Line("speed", label, VEHICLE, kind, topic, velocity.time, velocity["twist.twist.linear.x"])


def _circumference(slip: Series) -> Array:
    """Return the speed of a wheel's circumference [m/s], by the radius that the valid slips were made with."""
    rolling = (slip["valid"] > 0.0) & (slip["wheel_speed"] > 0.0) & np.isfinite(slip["slip"])
    if not np.any(rolling):
        return np.full(slip.time.shape, np.nan)
    circumference = slip["vehicle_speed"][rolling] * (1.0 - slip["slip"][rolling])
    return slip["wheel_speed"] * float(np.median(circumference / slip["wheel_speed"][rolling]))


def _slips(run: RecordedRun, wheel: str) -> Iterator[Line]:
    if (slip := run.get(f"{wheel}/slip")) is not None:
        values = np.where(slip["valid"] > 0.0, slip["slip"], np.nan)
        yield Line("slip", wheel, wheel, "estimate", f"{wheel}/slip", slip.time, values)
    if (supervisor := run.get(f"{wheel}/abs_supervisor")) is not None:
        values = supervisor["slip_set_point"]
        yield Line("slip", f"{wheel}, set-point", wheel, "aim", f"{wheel}/abs_supervisor", supervisor.time, values)
    if (truth := run.get(f"truth/{wheel}/slip")) is not None:
        yield Line("slip", f"{wheel}, true", wheel, "truth", f"truth/{wheel}/slip", truth.time, truth["slip"])


def _peaks(run: RecordedRun) -> Iterator[Line]:
    for panel in ("lambda_max", "mu_max"):
        for fit in fits_of(run, ""):
            yield _banded(panel, fit.label, fit.of, "estimate", fit.topic, fit.curve, panel, 1.0)
        for fit in fits_of(run, "truth/"):
            yield Line(panel, f"{fit.label}, true", fit.of, "truth", fit.topic, fit.curve.time, fit.curve[panel])


def _grip(run: RecordedRun) -> Iterator[Line]:
    grip = run.get("grip")
    if grip is None:
        return
    yield _used("grip", "used", VEHICLE, "sensor", "grip", grip, "vehicle")
    yield Line("grip", "proven within 100 m", VEHICLE, "estimate", "grip", grip.time, grip["mu_proven"])
    for name in ("lower", "upper"):
        yield Line("grip", f"{name} bound", VEHICLE, "bound", "grip", grip.time, grip[f"mu_{name}"])
    for wheel in run.wheels:
        if (of_wheel := run.get(topic := f"{wheel}/grip")) is not None:
            yield _used("wheel_grip", wheel, wheel, "estimate", topic, of_wheel, "used")


def _used(panel: str, label: str, of: str, kind: str, topic: str, grip: Series, part: str) -> Line:
    """Return the friction in use of a part, at its own time, with its 95 % interval."""
    used, reach = grip[f"{part}.mu_used"], INTERVAL_95 * grip[f"{part}.mu_used_stddev"]
    return Line(panel, label, of, kind, topic, grip.time - _GRIP_DELAY, used, (used - reach, used + reach))


def _brake(run: RecordedRun, wheel: str) -> Iterator[Line]:
    if (pressure := run.get(f"{wheel}/brake_pressure")) is not None:
        values = 1e-6 * pressure["fluid_pressure"]
        yield Line("pressure", wheel, wheel, "sensor", f"{wheel}/brake_pressure", pressure.time, values)
    if (debug := run.get(topic := f"{wheel}/abs_supervisor_debug")) is not None:
        values = debug["torque_set_point"]
        yield Line("torque", f"{wheel}, set-point", wheel, "aim", topic, debug.time, values)
    if (supervisor := run.get(topic := f"{wheel}/abs_supervisor")) is not None:
        values = supervisor["demand_torque"]
        yield Line("torque", f"{wheel}, driver's demand", wheel, "demand", topic, supervisor.time, values)


def _demands(run: RecordedRun) -> Iterator[Line]:
    if (demand := run.get("brake_demand")) is not None:
        values = 1e-6 * demand["pressure"]
        yield Line("pressure", "driver's demand", DRIVER, "demand", "brake_demand", demand.time, values)


def _forces(run: RecordedRun, wheel: str) -> Iterator[Line]:
    for panel in ("fx", "fz"):
        if (force := run.get(topic := f"{wheel}/tyre_force")) is not None:
            yield _banded(panel, wheel, wheel, "points", topic, force, panel, 1e-3)
        if (truth := run.get(topic := f"truth/{wheel}/tyre_force")) is not None:
            yield Line(panel, f"{wheel}, true", wheel, "truth", topic, truth.time, 1e-3 * truth[panel])


def _banded(panel: str, label: str, of: str, kind: str, topic: str, series: Series, column: str, unit: float) -> Line:
    """Return a line of valid values with their 95 % interval."""
    values = unit * np.where(series["valid"] > 0.0, series[column], np.nan)
    reach = INTERVAL_95 * unit * series[f"{column}_stddev"]
    return Line(panel, label, of, kind, topic, series.time, values, (values - reach, values + reach))


def _validities(run: RecordedRun) -> Iterator[Strip]:
    judged = [(topic, series) for topic, series in run.series.items() if WHY in series.columns]
    for topic, series in sorted(judged, key=lambda item: (item[0].rpartition("/")[2], item[0])):
        if topic.startswith("truth/"):
            continue
        of, _, name = topic.rpartition("/")
        meanings = {0: "valid", **{k + 1: plain_reason(text, of) for k, text in enumerate(series.reasons)}}
        yield Strip("validity", name, of or VEHICLE, series.time, series[WHY], meanings)


def _curves(fit: Fit, kind: str, rows: NDArray[np.bool_]) -> Curves:
    names = ("theta_1", "theta_2", "theta_3", "lambda_max", "mu_max", "lambda_max_stddev", "mu_max_stddev")
    return Curves(fit.label, fit.of, kind, fit.curve.time[rows], {name: fit.curve[name][rows] for name in names})
