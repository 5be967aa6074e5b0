"""Accelerometer against freely rolling wheels: delay, scale factor, bias, mounting.

A wheel without drive or brake has the speed of the car. So its speed is the integral of the accelerometer, but for
slope and bias, which a polynomial over some seconds takes up; steps of the throttle then tell age and scale. The
body's pitch is in both: it belongs to how the accelerometer is mounted.
"""

from math import hypot

import numpy as np

from sensor_monitor.signal_age import SignalAge
from vehicle_doctor.comparison import Shift, ratio, shift, stretches
from vehicle_doctor.drive import IMU, Array, Drive
from vehicle_doctor.findings import Finding, Verdict, against_file
from vehicle_doctor.motion import Motion, free_rims, spread_of_rest
from vehicle_models.constants import GRAVITY
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import absolute_deviation, deviation_of, specified_stddev

FLAT, CIRCUIT, UNKNOWN = "flat", "out-and-back", "unknown"
ROADS = (UNKNOWN, FLAT, CIRCUIT)
"""What the user knows of the road: nothing, no slope anywhere, or an end as high as the beginning."""
AGE_FLOOR = 3e-3
"""Deviation of an age [s] that hills and the transient of the pitch leave."""
_COARSE_AGE = 0.2
"""Deviation of an age [s] that is compared at some ages only."""
_LEAST_AGE = 0.01
"""Least deviation of the age that is expected [s]."""
_FORCELESS, _SLIP, _LARGEST_SLIP = 0.6, 0.02, 0.5
"""Deceleration [m/s^2] at which free wheels slip by so much [-] on soft snow; at twice as much they may lock."""
_CURVE = 0.005
"""Share by which free wheels may differ from the speed: curves."""
_STRAIGHT = 2.0
"""Lateral acceleration [m/s^2] from which the car's sideways motion is in the axis along it."""
_VAGUE = 0.05
"""Deviation of an age [s] with which nothing is compared."""
_SCALE_FLOOR = 0.004
_STIFFNESS = 25.0
"""Slip stiffness of a common tyre over its load."""


def check(drive: Drive, motion: Motion, road: str) -> tuple[list[Finding], Shift | None]:
    """Return the findings, and age and scale of the accelerometer."""
    if not np.isfinite(motion.force).any():
        return [], None
    accelerometer = drive.vehicle.accelerometer
    if late := _long_after_the_wheels(drive, motion):
        return [late], None
    found = _mounting(drive, motion)
    compared = against_wheels(drive, motion)
    if compared is not None and compared.late_stddev > _VAGUE:
        compared = None
        text = "age and scale not determined: its noise hides the changes of speed"
        found.append(Finding("accelerometer", IMU, Verdict.NOTE, text, remedy="drive with changes of speed"))
        gain = accelerometer.scale
    elif compared is None:
        text = "age and scale not determined: too few stretches without braking"
        found.append(Finding("accelerometer", IMU, Verdict.NOTE, text, remedy="drive with changes of speed"))
        gain = accelerometer.scale
    else:
        found += _age_and_scale(drive, compared, age_of_teeth(drive, motion))
        gain = compared.gain
    found.append(_bias(drive, motion, gain, road))
    return found, compared


def _long_after_the_wheels(drive: Drive, motion: Motion) -> Finding | None:
    """Return the finding of an accelerometer that is of no use for the present motion."""
    mounting, rims = drive.vehicle.accelerometer, free_rims(drive, motion)
    watch = SignalAge(max(absolute_deviation(mounting.deviations, "delay"), _LEAST_AGE), accelerometer=True)
    force = np.nan_to_num(motion.force)
    travelled = np.cumsum(force) * motion.step
    delay = round(mounting.delay * NANOSECONDS)
    drift = motion.step * spread_of_rest(motion.force[np.isfinite(motion.force)]) ** 2
    slips = np.minimum(_SLIP * (np.maximum(-force, 0.0) / _FORCELESS) ** 4, _LARGEST_SLIP)
    for number in np.flatnonzero(np.isfinite(motion.force) & motion.complete & np.isfinite(rims)).tolist():
        stamp, speed = round((number + 1) * motion.step * NANOSECONDS), float(rims[number])
        watch.follow(stamp, speed)
        variance = (slips[number] ** 2 + _CURVE**2) * speed**2
        watch.compare(stamp - delay, float(travelled[number]), float(force[number]), float(variance), drift)
    if not watch.text:
        return None
    text = f"{watch.text}: not usable for the present motion"
    remedy = "look for a filter, or a queue, between the sensor and its messages; wheel_slip goes by the wheels"
    return Finding("skew", IMU, Verdict.FAIL, text, 1e3 * watch.late, 1e3 * _COARSE_AGE, "ms", remedy)


def against_wheels(drive: Drive, motion: Motion) -> Shift | None:
    """Return by how much the accelerometer is later than the wheels, and its reading over the car's acceleration."""
    straight = np.abs(motion.turned * np.nan_to_num(motion.speed)) < _STRAIGHT
    rolls = motion.moving & ~motion.braking & np.isfinite(motion.force) & motion.complete & straight
    rims = free_rims(drive, motion)
    force = np.nan_to_num(without_pitch(drive, motion))
    travelled = np.cumsum(force) * motion.step - 0.5 * motion.step * force
    noise = spread_of_rest(motion.force[np.isfinite(motion.force)])
    found = shift(motion, travelled, rims, stretches(motion, rolls, 3.0, 8.0), order=3, rate_noise=noise)
    if found is None or not found.gain > 0.0:
        return None
    scale = 1.0 / found.gain
    return Shift(
        wheel_lag(drive, motion) - found.late, found.late_stddev, scale, scale * found.gain_stddev / found.gain
    )


def wheel_lag(drive: Drive, motion: Motion) -> float:
    """Return the time by which a free wheel follows the car, and a tyre's force its brake [s].

    J v / (r^2 C) with the slip stiffness C [N]: the slip that turns the wheel faster has to build up.
    """
    vehicle = drive.vehicle
    load = GRAVITY * vehicle.mass / len(vehicle.wheels)
    inertia = float(np.mean([wheel.inertia / wheel.radius**2 for wheel in vehicle.wheels]))
    return inertia * float(np.median(motion.speed[motion.moving])) / (_STIFFNESS * load)


def age_of_teeth(drive: Drive, motion: Motion) -> float:
    """Deviation of the age of the wheel speeds themselves [s].

    Speeds made from teeth are as old as half of a sample and half a tooth, those of other sensors are not: which they
    are is not known, so both are within two deviations.
    """
    wheel = drive.vehicle.wheels[0]
    tooth = 2.0 * np.pi * wheel.radius / wheel.encoder_teeth / float(np.median(motion.speed[motion.moving]))
    return 0.25 * (motion.step + tooth)


def without_pitch(drive: Drive, motion: Motion) -> Array:
    """Reading [m/s^2], (N,), without the gravity that the pitch of the body adds, by the vehicle file."""
    vehicle = drive.vehicle
    rate = np.nan_to_num(motion.rate)
    count = rate.size
    omega = 2.0 * np.pi * vehicle.pitch_frequency
    s = 2j * np.pi * np.fft.rfftfreq(2 * count, motion.step) / omega  # twice as long: the end does not meet the begin
    angle = np.fft.irfft(np.fft.rfft(rate, 2 * count) / (1.0 + 2.0 * vehicle.pitch_damping * s + s**2), 2 * count)[
        :count
    ]
    return np.asarray(motion.force - GRAVITY * vehicle.accelerometer.pitch_gain * angle)


def _mounting(drive: Drive, motion: Motion) -> list[Finding]:
    named = "xyz".index(drive.vehicle.accelerometer.axis)
    gains = []
    for axis in range(3):
        gain, stddev = ratio(motion, motion.axes[:, axis], motion.rate, motion.moving)
        gains.append((gain, stddev))
    own, own_uncertainty = gains[named]
    if not np.isfinite(own) or own_uncertainty > 0.2:
        return []
    for axis, (gain, stddev) in enumerate(gains):
        if axis != named and np.isfinite(gain) and abs(gain) > max(0.15, 5.0 * stddev):
            angle = float(np.degrees(np.arctan2(abs(gain), abs(own))))
            text = f"is turned: {'xyz'[axis]} has {gain:.2f} and {'xyz'[named]} {own:.2f} of the car's acceleration"
            far = abs(own) < 0.5
            remedy = f"'accelerometer: {{axis: {'xyz'[axis]}}}' in the vehicle file" if far else "turn it along the car"
            return [
                Finding("mounting", IMU, Verdict.FAIL if far else Verdict.WARN, text, angle, unit="deg", remedy=remedy)
            ]
    return []


def _age_and_scale(drive: Drive, compared: Shift, of_wheels: float) -> list[Finding]:
    accelerometer = drive.vehicle.accelerometer
    specified = accelerometer.deviations
    age, stddev = compared.late, hypot(compared.late_stddev, AGE_FLOOR)
    verdict = against_file(
        age, hypot(stddev, of_wheels), accelerometer.delay, specified_stddev(specified, "delay"), 4e-3
    )
    text = f"{1e3 * age:+.1f} ms later than the wheels, {1e3 * accelerometer.delay:.1f} ms in the file"
    learned = {"accelerometer.delay": (max(age, 0.0), stddev)} if age < 0.1 else {}
    remedy = "--write, or 'latency' in the signal map" if verdict is Verdict.WARN else ""
    findings = [Finding("skew", IMU, verdict, text, 1e3 * age, 1e3 * stddev, "ms", remedy, learned)]
    scale, stddev = compared.gain, hypot(compared.gain_stddev, _SCALE_FLOOR)
    of_pitch = GRAVITY * deviation_of(specified, "pitch_gain", 0.0)
    verdict = against_file(
        scale, hypot(stddev, of_pitch), accelerometer.scale, specified_stddev(specified, "scale"), 0.02
    )
    text = f"reads {scale:.3f} of the wheels' acceleration, without pitch ({accelerometer.scale:.3f})"
    learned = {"accelerometer.scale": (scale, hypot(stddev, of_pitch))}
    remedy = "--write, or 'scale' in the signal map" if verdict is Verdict.WARN else ""
    findings.append(Finding("scale", IMU, verdict, text, scale, hypot(stddev, of_pitch), "", remedy, learned))
    return findings


def _bias(drive: Drive, motion: Motion, gain: float, road: str) -> Finding:
    """Mean of what is left of the reading; over the distance, as hills that end where they began cancel over it."""
    if road == UNKNOWN:
        text = "cannot be distinguished from the grade: give --road flat or --road out-and-back if it was so"
        return Finding("bias", IMU, Verdict.NOTE, text)
    rest = without_pitch(drive, motion) - gain * motion.rate
    use = motion.moving & np.isfinite(rest)
    if use.sum() * motion.step < 5.0:
        return Finding("bias", IMU, Verdict.NOTE, "not determined: the car hardly moves")
    weight = motion.speed[use] if road == CIRCUIT else np.ones(int(use.sum()))
    bias, stddev = _mean(rest[use], weight)
    accelerometer = drive.vehicle.accelerometer
    verdict = against_file(bias, stddev, accelerometer.bias, specified_stddev(accelerometer.deviations, "bias"), 0.05)
    text = f"reads {bias:+.3f} m/s^2 on a level road, {accelerometer.bias:+.3f} in the file"
    remedy = "take the value into the vehicle file (--write)" if verdict is Verdict.WARN else ""
    return Finding("bias", IMU, verdict, text, bias, stddev, "m/s^2", remedy, {"accelerometer.bias": (bias, stddev)})


def _mean(values: Array, weight: Array) -> tuple[float, float]:
    """Weighted mean and its deviation, by leaving out each tenth."""
    parts = np.arange(values.size) * 10 // values.size
    up = np.bincount(parts, values * weight, 10)
    down = np.bincount(parts, weight, 10)
    without = (up.sum() - up) / (down.sum() - down)
    return float(up.sum() / down.sum()), float(np.hypot(np.sqrt(9.0 * np.var(without)), 5e-3))
