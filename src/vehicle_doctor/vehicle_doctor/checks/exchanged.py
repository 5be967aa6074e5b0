"""Wheels with the signals of others: left and right by the curves, front and rear by which axle the engine drives."""

import numpy as np

from vehicle_doctor.accelerations import correlation
from vehicle_doctor.drive import WHEEL_STATES, Array, Drive
from vehicle_doctor.finding import Finding, failure
from vehicle_doctor.motion import Motion
from vehicle_doctor.rolling import rolling_of
from vehicle_models.vehicle import Wheel

_FOLLOWS = 0.6
"""Correlation from which a difference of wheels is that of a curve."""
_SURE = 5.0
"""Deviations of a difference of slips from which an axle is driven."""
_DRIVEN = 2e-3
"""Least slip over acceleration of a driven axle beyond that of the other [s^2/m]; that of a common tyre is 8e-3."""
_REMEDY = "exchange their fields in the signal map, or their joints in the vehicle file"


def check(drive: Drive, motion: Motion) -> list[Finding]:
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
