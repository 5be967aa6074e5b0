"""Curves taken out of the wheel speeds, so that a steady turn is no difference of radii.

With the yaw rate r, speed v of the middle of the rear axle, wheelbase l and track t, the rims of the left and right
wheels roll with

    rear:   v -+ r t / 2
    front:  sqrt((v -+ r t / 2)^2 + w^2),  w = l r - v a_y / (C g),  a_y = v r

The sideways speed w of the front axle is that of the turn less what the rear axle slips outwards.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from vehicle_doctor.comparison import block_means
from vehicle_doctor.drive import IMU, Array, Drive
from vehicle_doctor.findings import Finding, failure
from vehicle_doctor.motion import Motion, NDArrayBool
from vehicle_models.constants import GRAVITY
from vehicle_models.vehicle import Vehicle

_CORNERING = 15.0
"""C: cornering stiffness of a common tyre over its load [1/rad]."""
_YAW_BIAS, _LATERAL_BIAS = 2e-3, 0.2
"""Deviation of the zero of a gyroscope that was not heard at rest [rad/s], and of a lateral axis with the road's
crossfall [m/s^2]."""
_RADII = 0.01
"""Deviation of the radii of two sides, relative."""
_APART = 0.03
"""Deviation of the yaw rates by wheels and by a sensor in half a second [rad/s]: slip, roll, crossfall."""
_LIKE = 0.25
"""Share by which the wheels' yaw rate over that of a sensor may differ from 1: track and slip."""
_REST = 1.0
"""Time at rest by which the zero of the gyroscope is known [s]."""


def straighten(drive: Drive, motion: Motion) -> tuple[list[Finding], Motion]:
    """Return findings on the yaw rate, and the motion with rims as on a straight road where the turning is known.

    An axle whose differential is locked does not follow the turning, and nothing is taken out of its sides.
    """
    vehicle = drive.vehicle
    wheels = _turning_of_wheels(vehicle, motion)
    use = motion.moving & ~motion.braking
    if not wheels or not use.any():
        return [], motion
    found: list[Finding] = []
    rate, stddev = _without_zero(motion)
    with np.errstate(invalid="ignore", divide="ignore"):
        lateral = motion.axes[:, 1] / motion.speed
    speed = float(np.median(motion.speed[use]))
    for signal, uncertainty, name in ((rate, stddev, "yaw rate"), (lateral, _LATERAL_BIAS / speed, "lateral axis")):
        known = use & np.isfinite(signal)
        if known.sum() < 0.5 * use.sum() or np.ptp(signal[known]) == 0.0:
            continue  # not measured
        gains = {axle: _gain(vehicle, motion, signal, each, known) for axle, each in wheels.items()}
        follows = {axle: abs(k - 1.0) <= max(_LIKE, 3.0 * of_k) for axle, (k, of_k) in gains.items()}
        if any(follows.values()):
            sides = {axle: 1.0 if follows[axle] else float(np.clip(gains[axle][0], 0.0, 1.0)) for axle in gains}
            return found, _straight(vehicle, motion, motion.smooth(signal, 0.1), uncertainty, sides)
        found += _misread(name, max((k for k, _ in gains.values()), key=abs))
    return found, motion


def _gain(vehicle: Vehicle, motion: Motion, signal: Array, wheels: Array, use: NDArrayBool) -> tuple[float, float]:
    """Return k and its deviation of: turning of the wheels = k signal + b v / t, b the difference of the radii."""
    columns = [block_means(motion, each, use) for each in (signal, motion.speed / vehicle.track, wheels)]
    blocks = np.column_stack(columns)
    x, y = np.split(blocks[np.isfinite(blocks).all(axis=1)], [2], axis=1)
    information = x.T @ x / _APART**2 + np.diag([1e-9, 1.0 / _RADII**2])
    return (
        float(np.linalg.solve(information, x.T @ y / _APART**2)[0, 0]),
        float(np.sqrt(np.linalg.inv(information)[0, 0])),
    )


def _misread(name: str, gain: float) -> list[Finding]:
    """Return the finding of a yaw rate that is no multiple of one; the lateral axis is judged by its mounting."""
    if name != "yaw rate" or abs(gain) < 0.005 or abs(gain + 1.0) < _LIKE:
        return []  # a sign is a matter of the wheels, too, which may be exchanged: it is judged with them
    if abs(abs(gain) - np.pi / 180.0) < 0.3 * np.pi / 180.0:
        return [failure("unit", f"{IMU} yaw rate", "is in deg/s by the wheels", "'unit: deg/s' in the signal map")]
    text = f"is {1.0 / gain:.3g} times that of the wheels: not used for the radii"
    return [failure("unit", f"{IMU} yaw rate", text, "look at its unit, and at the track in the vehicle file")]


def _without_zero(motion: Motion) -> tuple[Array, float]:
    """Return the yaw rate [rad/s], (N,), less what it reads at rest, and the deviation of its zero."""
    rests = np.isfinite(motion.turning) & (np.nan_to_num(np.abs(motion.rims), nan=1.0).max(axis=1) == 0.0)
    if rests.sum() * motion.step < _REST:
        return motion.turning, _YAW_BIAS
    return motion.turning - float(np.median(motion.turning[rests])), 0.2 * _YAW_BIAS


def _turning_of_wheels(vehicle: Vehicle, motion: Motion) -> dict[str, Array]:
    """Return the yaw rate by the difference of the wheels of each axle [rad/s], (N,), with the radii of the file."""
    found = {}
    for axle in ("front", "rear"):
        sides = {wheel.side: i for i, wheel in enumerate(vehicle.wheels) if wheel.axle == axle}
        if len(sides) == 2:
            turning = (motion.rims[:, sides["right"]] - motion.rims[:, sides["left"]]) / vehicle.track
            if np.isfinite(turning).any():
                found[axle] = turning
    return found


def _straight(vehicle: Vehicle, motion: Motion, turning: Array, stddev: float, sides: Mapping[str, float]) -> Motion:
    """Return the motion without the turning [rad/s], (N,), of which the sides of an axle follow a share.

    Where it is not known, nothing is changed.
    """
    turn = np.nan_to_num(turning)
    speed = np.nan_to_num(motion.speed)
    across = vehicle.wheelbase * turn - speed * speed * turn / (_CORNERING * GRAVITY)
    rims = motion.rims.copy()
    for i, wheel in enumerate(vehicle.wheels):
        side = sides.get(wheel.axle, 1.0) * 0.5 * vehicle.track * turn * (1.0 if wheel.side == "left" else -1.0)
        if wheel.axle == "front":
            rims[:, i] = np.sqrt(np.maximum(rims[:, i] ** 2 - across**2, 0.0)) * np.sign(rims[:, i])
        rims[:, i] += side
    return replace(motion, rims=rims, turned=turn, turning_stddev=stddev)
