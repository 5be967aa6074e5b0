"""Brake pressures against the accelerometer: sign, unit, delay, gain and fade, and signals that do not brake.

While a brake is applied the throttle is closed, and f = -(sum of k p / r) / m - drag, whatever the slope: the reading
is the force of the tyres over the mass. That force follows the pressure within 2 ms; so pressure and accelerometer tell
age and gain, and the accelerometer's own age and scale beside the wheels are taken off.
"""

from dataclasses import replace
from math import hypot, isfinite, log

import numpy as np

from vehicle_doctor.checks.accelerometer import AGE_FLOOR, age_of_teeth, wheel_lag, without_pitch
from vehicle_doctor.comparison import Shift, shift, stretches
from vehicle_doctor.drive import Array, Drive, pressure_topic
from vehicle_doctor.findings import Finding, Verdict, against_file, failure
from vehicle_doctor.motion import Motion, NDArrayBool, pressure_threshold
from vehicle_models.vehicle import Vehicle, deviation_of, specified_stddev

_UNITS = {"Pa": 1.0, "kPa": 1e-3, "bar": 1e-5, "MPa": 1e-6, "mbar": 1e-2, "psi": 1.0 / 6894.76}
_NEAR = log(2.5)
"""Logarithm of a gain over that of the file up to which it is a unit's; a wrong gain is closer than a wrong unit."""
_GAIN_FLOOR = 0.005
_FADED = 0.08
_FADE_ENDS = (0.15, 0.3, 0.5, 1.0)
"""Shares of the work of the drive after which the gain falls no more."""
_BRAKES = -1.0
"""Acceleration [m/s^2] below which a car is braking."""
_ROLLS = 0.5
"""Time [s] with the brake released that its pressure at rest needs: a wheel that is released in a stop gives less."""


def check(drive: Drive, motion: Motion, accelerometer: Shift | None) -> list[Finding]:
    """Return the findings; `accelerometer` is its age and scale beside the wheels."""
    vehicle = drive.vehicle
    there = [i for i in range(len(vehicle.wheels)) if np.isfinite(motion.pressure[:, i]).any()]
    if not there:
        return [
            Finding(
                "pressure", "brake_pressure", Verdict.NOTE, "is not recorded: no friction_slope, no curve of a wheel"
            )
        ]
    found, motion, sound = _signals(drive, motion, there)
    if not sound or accelerometer is None:
        if sound:
            found.append(Finding("gain", "brakes", Verdict.NOTE, "not determined without the accelerometer"))
        return found
    motion = replace(motion, force=without_pitch(drive, motion))
    applied = (motion.pressure[:, sound] > pressure_threshold(motion.pressure)[sound]).all(axis=1)
    where = stretches(motion, applied & motion.moving & np.isfinite(motion.force), 0.5, 5.0)
    return found + _ages(drive, motion, accelerometer, sound, where) + _gain(drive, motion, accelerometer, sound, where)


def _signals(drive: Drive, motion: Motion, there: list[int]) -> tuple[list[Finding], Motion, list[int]]:
    """Judge each pressure by itself; return the findings, pressures in Pa, and the wheels whose pressure brakes."""
    vehicle = drive.vehicle
    slow = motion.smooth(motion.rate, 0.3)
    brakes = motion.moving & (slow < _BRAKES)
    rolls = motion.moving & (slow > 0.2)
    found: list[Finding] = []
    sound: list[int] = []
    pressure = motion.pressure.copy()
    if not brakes.any():
        return [Finding("pressure", "brakes", Verdict.NOTE, "not determined: the car never brakes")], motion, []
    ratios: dict[int, float] = {}
    for i in there:
        topic = pressure_topic(vehicle.wheel_names[i])
        signal = motion.smooth(pressure[:, i], 0.1)
        enough = np.isfinite(signal[rolls]).sum() * motion.step >= _ROLLS
        rest = np.nanmedian(signal[rolls]) if enough else 0.0
        change = _correlation(signal - rest, slow, motion.moving)
        size = float(np.nanmedian((signal - rest)[brakes]))
        if not isfinite(change) or abs(change) < 0.4 or size * change >= 0.0:
            text = "does not brake: it does not rise and fall with the car's deceleration"
            found.append(failure("pressure", topic, text, "look at its sensor, and at the field in the signal map"))
            continue
        if change > 0.0:
            found.append(failure("sign", topic, "falls when the car brakes", "'sign: -1' in the signal map"))
            pressure[:, i] *= -1.0
            rest, size = -rest, -size
        if abs(rest) > 0.1 * abs(size):
            text = f"is {rest:.3g} Pa with the brake released, {100.0 * rest / size:.0f} % of an ordinary braking"
            found.append(
                Finding(
                    "pressure offset",
                    topic,
                    Verdict.WARN,
                    text,
                    float(rest),
                    unit="Pa",
                    remedy="'offset' in the signal map",
                )
            )
        pressure[:, i] -= rest
        ratios[i] = float(np.nanmedian(-slow[brakes]) / size) / expected_gain(vehicle)
        sound.append(i)
    for i, ratio in ratios.items():
        name = min(_UNITS, key=lambda each: abs(log(ratio * _UNITS[each])))
        if name != "Pa" and abs(log(ratio)) > _NEAR:
            topic = pressure_topic(vehicle.wheel_names[i])
            text = f"is in {name}: the car brakes {ratio:.3g} times as hard as the file expects of Pa"
            found.append(failure("unit", topic, text, f"'unit: {name}' in the signal map"))
            pressure[:, i] /= _UNITS[name]
    return found, replace(motion, pressure=pressure), sound


def expected_gain(vehicle: Vehicle) -> float:
    """Deceleration over pressure [m/s^2/Pa] of all brakes with one pressure, by the file."""
    return sum(wheel.brake_gain / wheel.radius for wheel in vehicle.wheels) / vehicle.mass


def _correlation(x: Array, y: Array, use: NDArrayBool) -> float:
    """Correlation where both are known."""
    known = use & np.isfinite(x) & np.isfinite(y)
    if known.sum() < 20 or np.std(x[known]) == 0.0:
        return np.nan
    return float(np.corrcoef(x[known], y[known])[0, 1])


def _ages(drive: Drive, motion: Motion, accelerometer: Shift, sound: list[int], where: list[slice]) -> list[Finding]:
    vehicle = drive.vehicle
    specified = specified_stddev(vehicle.deviations, "brake_pressure_delay")
    found = []
    of_wheels, lag = age_of_teeth(drive, motion), wheel_lag(drive, motion)
    for i in sound:
        topic = pressure_topic(vehicle.wheel_names[i])
        # how much later the accelerometer is than this pressure, and than the wheels
        compared = shift(motion, motion.pressure[:, i], motion.force, where)
        if compared is None or not compared.late_stddev < 0.02:
            text = f"age not determined by {len(where)} brakings"
            found.append(Finding("skew", topic, Verdict.NOTE, text, remedy="brake more often, with a quick foot"))
            continue
        age = accelerometer.late - (compared.late - lag)
        uncertainty = hypot(hypot(accelerometer.late_stddev, compared.late_stddev), AGE_FLOOR)
        delay = vehicle.brake_pressure_delay
        verdict = against_file(age, hypot(uncertainty, of_wheels), delay, specified, 6e-3)
        text = f"{1e3 * age:+.1f} ms later than the wheels, {1e3 * delay:.1f} ms in the file"
        remedy = "--write, or 'latency' in the signal map" if verdict is Verdict.WARN else ""
        learned = {"brake_pressure_delay": (age, uncertainty)} if 0.0 <= age < 0.5 else {}
        found.append(Finding("skew", topic, verdict, text, 1e3 * age, 1e3 * uncertainty, "ms", remedy, learned))
    return found


def _gain(drive: Drive, motion: Motion, accelerometer: Shift, sound: list[int], where: list[slice]) -> list[Finding]:
    vehicle = drive.vehicle
    wheels = [vehicle.wheels[i] for i in sound]
    if len(sound) < len(vehicle.wheels):
        return [Finding("gain", "brakes", Verdict.NOTE, "not determined: not every pressure brakes")]
    expected = motion.pressure[:, sound] @ np.array([each.brake_gain / each.radius for each in wheels]) / vehicle.mass
    compared = shift(motion, expected, motion.force, where, order=0)
    if compared is None:
        return [Finding("gain", "brakes", Verdict.NOTE, f"not determined by {len(where)} brakings")]
    rotating = sum(each.inertia / each.radius**2 for each in wheels) / vehicle.mass  # the brakes stop the wheels, too
    ratio = -compared.gain / accelerometer.gain * (1.0 + rotating)
    uncertainty = abs(ratio) * hypot(
        hypot(compared.gain_stddev / compared.gain, accelerometer.gain_stddev / accelerometer.gain), _GAIN_FLOOR
    )
    mass_stddev = deviation_of(vehicle.deviations, "mass", 0.0)
    specified = max(deviation_of(w.deviations, "brake_gain", 0.0) / w.brake_gain for w in wheels)
    uncertainty_of_file = hypot(specified, mass_stddev / vehicle.mass)
    verdict = against_file(ratio, uncertainty, 1.0, uncertainty_of_file, 0.05)
    text = f"{ratio:.3f} times the gains of the file, at its mass of {vehicle.mass:.0f} kg"
    remedy = "take the gains into the vehicle file (--write), or correct its mass" if verdict is Verdict.WARN else ""
    # gain over mass is what was measured: with another mass the gain is another
    of_gain = hypot(uncertainty, ratio * mass_stddev / vehicle.mass)
    learned = {f"wheels.{w.name}.brake_gain": (ratio * w.brake_gain, of_gain * w.brake_gain) for w in wheels}
    found = [Finding("gain", "brakes", verdict, text, ratio, uncertainty, "", remedy, learned)]
    return found + _fade(motion, expected, compared, where)


def _fade(motion: Motion, expected: Array, whole: Shift, where: list[slice]) -> list[Finding]:
    """Gain over the work of the brakes so far: a line to some share of it, as pads that are hot fade no more."""
    work = np.cumsum(np.nan_to_num(np.clip(expected, 0.0, None) * motion.speed)) * motion.step
    rows = []
    for part in where:
        late = round(whole.late / motion.step)
        x, y = np.roll(expected, late)[part], motion.force[part]
        known = np.isfinite(x) & np.isfinite(y)
        if known.sum() > 20 and (size := float(np.var(x[known]))) > 0.05:
            slope = float(np.cov(x[known], y[known])[0, 1]) / size
            rows.append((float(work[part].mean()), slope / whole.gain, size * known.sum()))
    if len(rows) < 5:
        return [Finding("fade", "brakes", Verdict.NOTE, f"not determined by {len(rows)} brakings")]
    at, gain, weight = np.array(rows).T
    done = (at - at.min()) / max(float(np.ptp(at)), 1e-9)
    root = np.sqrt(weight)

    def lost(end: float, keep: NDArrayBool) -> tuple[float, float]:
        """Share of the gain that is lost until `end` of the work, and what is left unexplained."""
        design = np.column_stack([np.ones_like(done), np.minimum(done / end, 1.0)])[keep] * root[keep, None]
        aim = gain[keep] * root[keep]
        (first, change), *_ = np.linalg.lstsq(design, aim, rcond=None)
        return -float(change / first), float(((aim - design @ (first, change)) ** 2).sum())

    every = np.ones(at.size, dtype=bool)
    end = min(_FADE_ENDS, key=lambda each: lost(each, every)[1])
    share, _ = lost(end, every)
    without = [lost(end, np.arange(at.size) != k)[0] for k in range(at.size)]
    uncertainty = float(np.sqrt((at.size - 1) * np.var(without)))
    faded = share > max(_FADED, 3.0 * uncertainty)
    text = f"loses {100.0 * share:.0f} % of the gain as the brakes get hot"
    remedy = "drive with cool brakes, or take the mean gain with a wider deviation" if faded else ""
    verdict = Verdict.WARN if faded else Verdict.OK
    return [Finding("fade", "brakes", verdict, text, 100.0 * share, 100.0 * uncertainty, "%", remedy)]
