"""Checks of the wheel speeds: missing, frozen, copied or exchanged wheels, and missing encoder teeth."""

import numpy as np

from vehicle_doctor.checks.radii import rolling_of
from vehicle_doctor.comparison import correlation
from vehicle_doctor.drive import WHEEL_STATES, Array, Drive
from vehicle_doctor.findings import Finding, Verdict, failure
from vehicle_doctor.motion import Motion, median_known
from vehicle_models.vehicle import Wheel

_COPY = 0.98
"""Share of samples of a moving car in which two wheels are equal that only a copy has."""


def check_signals(drive: Drive, motion: Motion) -> tuple[list[Finding], Motion]:
    """Return the findings, and the motion with signs put right and without the wheels whose signal is none."""
    names = drive.vehicle.wheel_names
    found: list[Finding] = []
    size = median_known(np.abs(motion.rims))
    rolls = np.nan_to_num(size) > 1e-3
    factors = np.ones(len(names))
    for i, name in enumerate(names):
        rim = motion.rims[rolls, i]
        known = rim[np.isfinite(rim)]
        if not known.size:
            found.append(failure("wheel", name, "has no speed in wheel_states", "name its joint in the vehicle file"))
        elif np.ptp(known) == 0.0:
            factors[i] = np.nan
            found.append(failure("wheel", name, "never changes its speed", "look at its sensor"))
        elif np.median(known) < 0.0:
            factors[i] = -1.0
            found.append(failure("sign", name, "turns backwards while the car drives", "'sign: -1' in the signal map"))
    recorded = drive.topics[WHEEL_STATES].values
    changed = np.abs(np.diff(recorded, axis=0, prepend=recorded[:1])).max(axis=1) > 0.0
    live = recorded[changed]
    for i, first in enumerate(names):
        for j in range(i + 1, len(names)):
            pair = live[:, [i, j]]
            pair = pair[np.isfinite(pair).all(axis=1)]
            if pair.shape[0] > 50 and (pair[:, 0] == pair[:, 1]).mean() > _COPY:
                text = (
                    f"is a copy of {first}: equal in {100.0 * (pair[:, 0] == pair[:, 1]).mean():.0f} % of the samples"
                )
                remedy = "give each wheel its own field in the signal map"
                factors[j] = np.nan
                found.append(failure("duplicate", names[j], text, remedy))
    return found, motion.with_wheel_factors(factors)


_FOLLOWS = 0.6
"""Correlation from which a difference of wheels is that of a curve."""
_SURE = 5.0
"""Deviations of a difference of slips from which an axle is driven."""
_DRIVEN = 2e-3
"""Least slip over acceleration of a driven axle beyond that of the other [s^2/m]; that of a common tyre is 8e-3."""
_REMEDY = "exchange their fields in the signal map, or their joints in the vehicle file"


def check_exchanged(drive: Drive, motion: Motion) -> list[Finding]:
    """Return the findings; none where the drive has no curves, or all wheels are driven."""
    return [*_left_and_right(drive, motion), *_front_and_rear(drive, motion)]


def _left_and_right(drive: Drive, motion: Motion) -> list[Finding]:
    """The outer wheel of an axle is the faster one: its difference follows the yaw rate, or lateral over speed."""
    axles = {}
    for axle in ("front", "rear"):
        sides = {wheel.side: i for i, wheel in enumerate(drive.vehicle.wheels) if wheel.axle == axle}
        if len(sides) == 2:
            axles[axle] = sides["left"], sides["right"]
    turns = {axle: motion.rims[:, right] - motion.rims[:, left] for axle, (left, right) in axles.items()}
    follows = {axle: _of_curves(motion, turn) for axle, turn in turns.items()}
    names = drive.vehicle.wheel_names
    wrong = [axle for axle, value in follows.items() if value < -_FOLLOWS]
    if len(wrong) == len(axles) == 2:
        text = "turn as if left and right were exchanged on both axles, or the IMU turned: its left is their right"
        return [failure("exchanged", WHEEL_STATES, text, f"{_REMEDY}; else 'sign: -1' of the IMU's lateral axes")]
    found = []
    for axle in wrong:
        left, right = axles[axle]
        text = f"and {names[right]} are exchanged: in curves the inner one is the faster"
        found.append(failure("exchanged", names[left], text, _REMEDY))
    if not wrong and len(turns) == 2 and not any(abs(value) > _FOLLOWS for value in follows.values()):
        front, rear = turns.values()
        if correlation(motion, front, rear, motion.moving & ~motion.braking) < -_FOLLOWS:
            text = "left and right are exchanged on one axle: front and rear turn against each other in curves"
            found.append(failure("exchanged", WHEEL_STATES, text, _REMEDY))
    return found


def _of_curves(motion: Motion, turn: Array) -> float:
    """Correlation of a difference of right and left with the turning of the IMU, or with its lateral axis."""
    use = motion.moving & ~motion.braking
    with np.errstate(invalid="ignore", divide="ignore"):
        lateral = motion.axes[:, 1] / motion.speed
    for signal in (motion.turning, lateral):
        found = correlation(motion, turn, signal, use & np.isfinite(signal))
        if abs(found) > _FOLLOWS:
            return found
    return 0.0


def _front_and_rear(drive: Drive, motion: Motion) -> list[Finding]:
    """The wheels that the engine drives slip with its force, the others do not."""
    wheels = drive.vehicle.wheels
    driven = np.array([wheel.driven for wheel in wheels])
    rolling = rolling_of(drive, motion) if driven.any() and not driven.all() else None
    if rolling is None:
        return []
    slip, stddev = rolling.force_slip, rolling.force_slip_stddev
    exchanged: list[tuple[Wheel, Wheel]] = []
    for i in np.flatnonzero(~driven):
        for j in np.flatnonzero(driven):
            more = slip[i] - slip[j]
            if wheels[i].side == wheels[j].side and more > max(_DRIVEN, _SURE * float(np.hypot(stddev[i], stddev[j]))):
                exchanged.append((wheels[i], wheels[j]))
    if len(exchanged) == int(driven.sum()) > 1:
        text = "front and rear are exchanged, or the other axle is driven: it slips with the engine's force"
        remedy = f"{_REMEDY}; else 'driven' in the vehicle file"
        return [failure("exchanged", WHEEL_STATES, text, remedy)]
    return [
        failure("exchanged", free.name, f"and {rear.name} are exchanged: it slips as a driven wheel does", _REMEDY)
        for free, rear in exchanged
    ]


_REVOLUTIONS = 5.0
_STRETCHES = 10
"""Least number of stretches."""
_SAMPLES = 5.0
"""Least number of samples in a revolution."""
_TOOTH = 0.5
"""Share of a tooth from which one is missing."""


def check_missing_teeth(drive: Drive, motion: Motion) -> list[Finding]:
    """Return a finding for each wheel whose speed falls once in every revolution.

    A gap of m teeth among N makes a short dip whose harmonics all have the amplitude 2 m / N; a wheel that is out of
    round has one of a few thousandths. Stretches of some revolutions are examined alone: the angle is the integral of a
    speed that is itself too low.
    """
    found = []
    use = motion.moving & ~motion.braking
    for i, wheel in enumerate(drive.vehicle.wheels):
        missing = 0.5 * wheel.encoder_teeth * _once_a_revolution(motion, motion.rims[:, i], wheel.radius, use)
        if missing > _TOOTH:
            share = 100.0 * missing / wheel.encoder_teeth
            text = f"falls once in every revolution, as if it lacked {missing:.1f} of {wheel.encoder_teeth} teeth"
            text += f"; its radius then seems {share:.1f} % larger"
            remedy = "inspect its encoder ring, or configure the gap in the sender"
            found.append(Finding("teeth", wheel.name, Verdict.WARN, text, missing, remedy=remedy))
    return found


def _once_a_revolution(motion: Motion, rim: Array, radius: float, use: np.ndarray) -> float:
    """Median over stretches of the amplitude at the frequency of the wheel, over its speed; 0 where it is not seen."""
    speed = np.where(use & np.isfinite(rim) & (rim > 0.0), rim, np.nan)
    angle = np.cumsum(np.nan_to_num(speed)) * motion.step / radius
    seen = 2.0 * np.pi * radius / (speed * motion.step) > _SAMPLES
    number = (angle / (2.0 * np.pi * _REVOLUTIONS)).astype(int)
    ends = np.flatnonzero(np.diff(number)) + 1
    amplitudes = []
    for begin, end in zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True):
        if not seen[begin:end].all():
            continue
        at = angle[begin:end]
        line = np.vander(np.linspace(-1.0, 1.0, at.size), 4)
        columns = np.column_stack([line, np.cos(at), np.sin(at)])
        fit = np.linalg.lstsq(columns, speed[begin:end], rcond=None)[0]
        amplitudes.append(float(np.hypot(fit[-1], fit[-2])) / float(np.mean(speed[begin:end])))
    return float(np.median(amplitudes)) if len(amplitudes) >= _STRETCHES else 0.0
