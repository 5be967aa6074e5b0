"""Units and signs of wheels, accelerometer and speed sensor: three measurements of one motion.

Every combination of mistaken units gets a cost: how far the sensors are apart with it, how unusual the drive would be,
and a cost for each mismatch. The cheapest is reported.
"""

from dataclasses import dataclass, replace
from itertools import product
from math import inf, isfinite, log, pi

import numpy as np

from vehicle_doctor.comparison import correlation, ratio
from vehicle_doctor.drive import IMU, SPEED, WHEEL_STATES, Drive
from vehicle_doctor.findings import Finding, Verdict
from vehicle_doctor.motion import Motion

_PRICE = 6.0
"""Of a mistaken unit, in squared deviations."""
_TOLERANCE = 0.02
"""Deviation of the ratio of two sound sensors: radii, scale and pitch of the accelerometer."""
_SAME = 0.03
"""Relative difference at which two units can be distinguished, given the errors of the radii."""
_ACCELERATIONS = {"m/s^2": 1.0, "g": 1.0 / 9.81, "mm/s^2": 1e3}
_FOLLOWS = 0.7
"""Correlation of accelerometer and wheels below which unit and sign are not judged."""
_SPEEDS = {"m/s": 1.0, "km/h": 3.6, "mph": 2.23694, "kn": 1.94384}
_FASTEST, _SLOWEST = 90.0, 4.0
"""Top speeds of a drive [m/s] beyond which a unit is wrong."""
_HARDEST, _GENTLEST = 16.0, 0.5
"""Largest accelerations of a drive [m/s^2], likewise."""


@dataclass(frozen=True)
class _Choice:
    wheels: str
    acceleration: str
    speed: str


def check(drive: Drive, motion: Motion) -> tuple[list[Finding], Motion]:
    """Return the findings, and the motion in SI units with signs put right."""
    radius, teeth = float(np.mean(drive.vehicle.radii)), drive.vehicle.wheels[0].encoder_teeth
    rotations = {
        "rad/s": 1.0, "rpm": 30.0 / pi, "rev/s": 0.5 / pi, "deg/s": 180.0 / pi, "edges/s": 0.5 * teeth / pi,
        "m/s": radius, "km/h": 3.6 * radius, "mph": 2.23694 * radius,
    }  # fmt: skip
    # By wheels of 0.28 m, km/h and rad/s are the same numbers.
    rotations = {name: factor for name, factor in rotations.items() if name == "rad/s" or abs(factor - 1.0) > _SAME}
    sure = motion.moving
    calm = np.abs(np.nan_to_num(motion.rate, nan=inf)) < 0.08 * np.nanpercentile(motion.speed, 90)
    force, force_stddev = ratio(motion, motion.force, motion.rate, sure)
    fast = (
        calm & np.isfinite(motion.measured) & (np.nan_to_num(motion.speed) > 0.3 * np.nanpercentile(motion.speed, 95))
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        measured = float(np.median((motion.measured / motion.speed)[fast])) if fast.any() else np.nan
    hard = float(np.nanpercentile(np.abs(motion.rate[sure]), 99.5)) if sure.any() else np.nan
    top = float(np.nanpercentile(motion.speed, 99.5))
    follows = correlation(motion, motion.force, motion.rate, sure)
    known_force = abs(follows) > _FOLLOWS and isfinite(force) and force_stddev < 0.3 * abs(force)
    accelerations = _ACCELERATIONS if known_force else {"m/s^2": 1.0}
    speeds = _SPEEDS if isfinite(measured) else {"m/s": 1.0}

    def cost(choice: _Choice) -> float:
        wheels = rotations[choice.wheels]
        total = _PRICE * sum((choice.wheels != "rad/s", choice.acceleration != "m/s^2", choice.speed != "m/s"))
        if known_force:
            tolerance = (_TOLERANCE**2 + (force_stddev / force) ** 2) ** 0.5
            total += min(log(abs(force) * wheels / accelerations[choice.acceleration]) ** 2 / tolerance**2, 1e3)
        if isfinite(measured):
            total += min(log(abs(measured) * wheels / speeds[choice.speed]) ** 2 / _TOLERANCE**2, 1e3)
        for value, low, high in ((top / wheels, _SLOWEST, _FASTEST), (hard / wheels, _GENTLEST, _HARDEST)):
            if isfinite(value) and value > 0.0:
                total += 40.0 * max(log(value / high), log(low / value), 0.0)
        return total

    best = min((_Choice(*each) for each in product(rotations, accelerations, speeds)), key=cost)
    found = []
    if best.wheels != "rad/s":
        factor = rotations[best.wheels]
        other = f", or its radii {100.0 * (factor - 1.0):+.0f} % wrong" if 0.8 < factor < 1.25 else ""
        text = f"is in {best.wheels}{other}: its values are {factor:.3g} times those in rad/s"
        found.append(_unit(WHEEL_STATES, text, factor, best.wheels))
        motion = motion.with_wheel_factors(np.full(motion.rims.shape[1], 1.0 / factor))
    if best.speed != "m/s":
        factor = speeds[best.speed]
        found.append(_unit(SPEED, f"is in {best.speed}: {factor:.3g} times the rims", factor, best.speed))
        motion = replace(motion, measured=motion.measured / factor)
    if known_force:
        factor = accelerations[best.acceleration]
        if factor != 1.0:
            text = f"is in {best.acceleration}: {abs(force):.3g} times the value from the wheels"
            found.append(_unit(IMU, text, factor, best.acceleration))
            motion = replace(motion, force=motion.force / factor, axes=motion.axes / factor)
        if force < 0.0:
            sign = -drive.vehicle.accelerometer.sign
            found.append(
                Finding(
                    "sign",
                    IMU,
                    Verdict.FAIL,
                    "counts backwards: it rises when the car slows",
                    remedy=f"'accelerometer: {{sign: {sign:.0f}}}' in the vehicle file (--write)",
                    learned={"accelerometer.sign": (sign, 0.0)},
                )
            )
            motion = replace(motion, force=-motion.force)
    if isfinite(measured) and measured < 0.0:
        found.append(
            Finding(
                "sign",
                SPEED,
                Verdict.FAIL,
                "is negative while the car drives forward",
                remedy="'sign: -1' in the signal map",
            )
        )
        motion = replace(motion, measured=-motion.measured)
    if abs(follows) <= _FOLLOWS:
        text = f"cannot be judged: it does not follow the acceleration of the wheels (correlation {follows:.2f})"
        found.append(Finding("unit", IMU, Verdict.NOTE, text, remedy="look at its axis, and at the field in the map"))
    witnesses = [name for name, there in ((IMU, known_force), (SPEED, isfinite(measured))) if there]
    if not found:
        text = f"agree with {' and '.join(witnesses)}" if witnesses else "not determined: no other sensor of the motion"
        found.append(Finding("unit", WHEEL_STATES, Verdict.OK if witnesses else Verdict.NOTE, text))
    return found, motion


def _unit(topic: str, text: str, factor: float, unit: str) -> Finding:
    return Finding("unit", topic, Verdict.FAIL, text, factor, remedy=f"'unit: {unit}' in the signal map")
