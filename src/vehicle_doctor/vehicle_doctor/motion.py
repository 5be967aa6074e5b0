"""A drive on one time axis: the basis of all physical checks.

Signals are resampled linearly onto the stamps of an even grid; where a signal has a gap it is NaN.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vehicle_doctor.drive import IMU, SPEED, WHEEL_STATES, Array, Drive, Recorded, pressure_topic

NDArrayBool = NDArray[np.bool_]

_FASTEST = 200.0
"""Rate of the grid [Hz], where the wheels are not slower."""
_LONGEST_STEP = 0.15
"""Longer steps between samples [s] are gaps, and so are those of more than `_STEPS` ordinary ones."""
_STEPS = 4.0
_SMOOTH = 0.1
"""Half of the time [s] over which accelerations are taken."""
ROLLS = 3.0
"""Speed above which the wheels are judged [m/s]."""
_SLIDES = 0.06
"""Share by which a wheel that slides, and hardly one that grips in a curve, leaves its usual ratio to the others."""
_LASTS = 0.15
"""Time over which that is looked at [s]."""
_SELDOM = 0.2
"""Share of the time beyond which a wheel that does so has a bad signal."""


@dataclass(frozen=True)
class Motion:
    """A drive of n wheels on N samples of an even grid."""

    step: float
    """Time between samples [s]."""
    time: Array
    """[s], (N,)"""
    rims: Array
    """Speeds of the wheels times the radii of the vehicle file [m/s], (N, n)."""
    pressure: Array
    """[Pa], (N, n); NaN of a wheel without the signal."""
    force: Array
    """Reading of the accelerometer's axis after the sign of the vehicle file [m/s^2], (N,); NaN without one."""
    axes: Array
    """All axes of it, as read [m/s^2], (N, 3)."""
    turning: Array
    """Yaw rate [rad/s], (N,); NaN without one."""
    measured: Array
    """Speed of the sensor [m/s], (N,); NaN without one."""
    turned: Array
    """Yaw rate that has been taken out of the rims [rad/s], (N,); zero where none has."""
    turning_stddev: float
    """Deviation of its zero [rad/s]; NaN: it is not known, and curves are in the rims."""

    @property
    def complete(self) -> NDArrayBool:
        """Where all wheels that have a signal have a speed, (N,)."""
        known = np.isfinite(self.rims)
        return np.asarray(known[:, known.any(axis=0)].all(axis=1) & known.any(axis=1))

    @property
    def speed(self) -> Array:
        """Median of the rims [m/s], (N,)."""
        return median_known(self.rims)

    @property
    def rate(self) -> Array:
        """Acceleration of the rims' median [m/s^2], (N,), over twice 0.1 s."""
        return self.slope(self.speed)

    @property
    def moving(self) -> NDArrayBool:
        """Where the car rolls faster than 3 m/s and no wheel slides, (N,)."""
        speed = self.speed
        rolls = np.nan_to_num(speed) > ROLLS
        if not rolls.any():
            return rolls
        # a tooth that is missing is no slide, which lasts
        ratios = self.smooth(self.rims, _LASTS)[rolls] / self.smooth(speed, _LASTS)[rolls, None]
        far = np.abs(ratios - median_known(ratios.T)[None, :]) > _SLIDES
        slides = np.zeros_like(rolls)
        slides[rolls] = far[:, far.mean(axis=0) < _SELDOM].any(axis=1)
        return rolls & ~spread(slides, round(0.3 / self.step))

    @property
    def braking(self) -> NDArrayBool:
        """Where a brake is applied, or the car slows as only brakes do, (N,), with 0.3 s around it."""
        level = np.nan_to_num(self.pressure) > pressure_threshold(self.pressure)
        applied = level.any(axis=1) | (np.nan_to_num(self.rate) < -1.5)
        return spread(applied, round(0.3 / self.step))

    def slope(self, signal: Array) -> Array:
        """Rate of change of a signal (N,) or (N, k), in its unit per second."""
        half = max(round(_SMOOTH / self.step), 1)
        found = np.full_like(signal, np.nan)
        found[half:-half] = (signal[2 * half :] - signal[: -2 * half]) / (2.0 * half * self.step)
        return found

    def smooth(self, signal: Array, time: float) -> Array:
        """Mean of a signal over a time [s] around each sample; NaN near gaps and ends."""
        width = 2 * round(0.5 * time / self.step) + 1
        return moving_mean(signal, width)

    def with_wheel_factors(self, factors: Array) -> "Motion":
        """Return the motion with the rims multiplied, (n,); NaN leaves a wheel out."""
        return replace(self, rims=self.rims * factors)


def free_rims(drive: Drive, motion: Motion) -> Array:
    """Mean rim speed of the wheels that the engine does not drive, of all where it drives all [m/s], (N,)."""
    free = [i for i, wheel in enumerate(drive.vehicle.wheels) if not wheel.driven] or list(range(motion.rims.shape[1]))
    sound = np.flatnonzero(np.isfinite(motion.rims).any(axis=0))
    kept = [i for i in free if i in sound] or sound.tolist()
    return np.asarray(motion.rims[:, kept].mean(axis=1))


def median_known(table: Array) -> Array:
    """Median of what is known in each row of (N, n), (N,); NaN where nothing is."""
    found = np.full(table.shape[0], np.nan)
    some = np.isfinite(table).any(axis=1)
    found[some] = np.nanmedian(table[some], axis=1)
    return found


def moving_mean(signal: Array, width: int) -> Array:
    """Centred mean of an odd number of samples along the first axis; NaN at the ends and where one is NaN."""
    if signal.shape[0] < width:
        return np.full_like(signal, np.nan)
    if signal.ndim == 2:
        return np.stack([moving_mean(column, width) for column in signal.T], axis=1)
    known = np.isfinite(signal)
    total = np.concatenate([[0.0], np.cumsum(np.where(known, signal, 0.0))])
    count = np.concatenate([[0], np.cumsum(known)])
    found = np.full_like(signal, np.nan)
    half = width // 2
    inside = count[width:] - count[:-width] == width
    found[half : signal.size - half] = np.where(inside, (total[width:] - total[:-width]) / width, np.nan)
    return found


def spread(flags: NDArrayBool, samples: int) -> NDArrayBool:
    """Set the samples around each set one, too."""
    if not flags.any():
        return flags
    width = 2 * samples + 1
    return np.convolve(flags.astype(np.float64), np.ones(width), "same") > 0.5


def pressure_threshold(pressure: Array) -> Array:
    """Pressure [Pa] above which a brake is applied, (n,): its rest plus a twentieth of what is usual in braking."""
    found = np.full(pressure.shape[1], np.inf)
    for wheel, signal in enumerate(pressure.T):
        known = signal[np.isfinite(signal)]
        if known.size and (high := np.percentile(known, 98)) > (low := np.percentile(known, 20)):
            found[wheel] = low + max(0.05 * (high - low), 6.0 * spread_of_rest(known))
    return found


def spread_of_rest(signal: Array) -> float:
    """Standard deviation of the noise of a signal, by its steps from sample to sample."""
    steps = np.abs(np.diff(signal))
    return float(np.median(steps) / 0.954) if steps.size else 0.0


def motion_of(drive: Drive) -> Motion | None:
    """Bring a drive onto one time axis; None where it holds no second of wheel speeds."""
    wheels = drive.topics.get(WHEEL_STATES)
    if wheels is None or wheels.stamp.size < 10:
        return None
    vehicle = drive.vehicle
    stamps = np.unique(wheels.stamp)
    if stamps.size < 10 or stamps[-1] - stamps[0] < 1.0:
        return None
    step = max(float(np.median(np.diff(stamps))), 1.0 / _FASTEST)
    count = min(int((stamps[-1] - stamps[0]) / step) + 1, 4_000_000)
    time = stamps[0] + step * np.arange(count)
    radii = np.array(vehicle.radii)

    def at(topic: str, columns: int) -> Array:
        recorded = drive.topics.get(topic)
        return np.full((count, columns), np.nan) if recorded is None else resampled(recorded, time)

    imu = at(IMU, 4)
    accelerometer = vehicle.accelerometer
    return Motion(
        step=step,
        time=time,
        rims=at(WHEEL_STATES, len(vehicle.wheels)) * radii,
        pressure=np.hstack([at(pressure_topic(name), 1) for name in vehicle.wheel_names]),
        force=accelerometer.sign * imu[:, "xyz".index(accelerometer.axis)],
        axes=imu[:, :3],
        turning=imu[:, 3],
        measured=at(SPEED, 1)[:, 0],
        turned=np.zeros(count),
        turning_stddev=np.nan,
    )


def resampled(recorded: Recorded, time: Array) -> Array:
    """Values at times [s], (N, k), linear between samples; NaN in gaps and beyond the ends.

    Each column has its own samples: senders that share a topic bring some wheels each.
    """
    found = np.full((time.size, recorded.values.shape[1]), np.nan)
    for column, values in enumerate(recorded.values.T):
        there = np.isfinite(values)
        stamps, first = np.unique(recorded.stamp[there], return_index=True)
        if stamps.size < 2:
            continue
        place = np.clip(np.searchsorted(stamps, time), 1, stamps.size - 1)
        gap = stamps[place] - stamps[place - 1]
        longest = max(_LONGEST_STEP, _STEPS * float(np.median(np.diff(stamps))))
        known = (gap <= longest) & (time >= stamps[0]) & (time <= stamps[-1])
        found[known, column] = np.interp(time[known], stamps, values[there][first])
    return found
