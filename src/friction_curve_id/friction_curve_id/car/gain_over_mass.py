"""Brake gain over mass of the axles, learned from braking to braking by the forces against the accelerometer.

In means over 40 ms, with D_front, D_rear the decelerations that nominal brakes give a nominal car,

    a = b - (1 + c) (exp(f - m) D_front + exp(r - m) D_rear + exp(j - m) sum of J omega_dot / (r m) + d + roll + air)
        + G p - tau rate of D

with the unknowns f, r, m, j: ln of front and rear gain, mass and inertia over their values in the vehicle file; c, b:
scale and offset of the accelerometer; d: engine drag over mass; tau: delay of the pressures less that of the
accelerometer; and the delay of the wheel speeds. It is an extended Kalman filter. Neither slope nor friction of the
road nor load of a wheel is in the equation: the accelerometer measures specific force. The radius of the wheel acts as
gain does, and counts as part of it.

A braking that speaks for the vehicle file and against what was learned, by more than _CHANGED in ln of the likelihood,
begins the learning anew; one that neither explains is not learned from.
"""

from dataclasses import dataclass
from math import exp, hypot, inf, isfinite, log, nan, sqrt

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.car.car_sample import Checked
from friction_curve_id.car.prior import radius_deviation
from vehicle_models.constants import AIR_DENSITY, GRAVITY
from vehicle_models.reason import Reason
from vehicle_models.vehicle import FRONT, REAR, Vehicle, absolute_deviation, mass_deviation, relative_deviation

Array = NDArray[np.float64]

_BLOCK = 0.04
_NOISE = 0.15
"""Standard deviation of a mean: accelerometer, pitch and what the equation leaves out [m/s^2]."""
_BEGIN, _END = 0.4, 0.2
"""Nominal deceleration by the brakes at which a braking begins, and ends [m/s^2]."""
_LIFT = 0.1
"""Time from its begin on in which the engine may still drive [s]."""
_RELEASED = 0.15
"""Time below _END that ends a braking [s]."""
_LONGEST = 5.0
"""Time of a braking that is learned from [s]: the offset of the speed and the heat of the brakes grow."""
_LOWEST_SPEED = 3.0
_TURNING = 0.3
"""Least speed of a wheel over that of the car: brakes that hold a locked wheel do not act with their torque."""
_AFTER_LOCK = 0.02
"""Time for which wheel speeds come from before the wheel turned again [s]."""
_PITCH_TIME = 0.1
_WHEEL_DELAY = 0.006
"""Standard deviation of the delay of wheel speeds [s]."""
_LEAST_BLOCKS = 5
_CHANGED = 5.0
_MISFIT = 2.0
"""Largest mean of the squared innovations over their variances."""
_FORGOTTEN = 0.03
"""Share of what is known that is forgotten with each braking: pads wear in and cool."""
_MEMORY = 3600.0
"""Time with which it fades [s]: passengers and luggage change."""
_FRONT, _REAR, _MASS, _INERTIA, _SCALE, _OFFSET, _DRAG, _DELAY, _WHEELS = range(9)


@dataclass(frozen=True)
class GainOverMass:
    """Brake gain of a wheel over the mass of the car [N m/(Pa kg)], mean of the axle; NaN of an axle that is not."""

    front: float
    front_stddev: float
    rear: float
    rear_stddev: float
    front_change: float
    """ln of the gain over mass over that of the vehicle file."""
    rear_change: float
    brakings: int
    """Brakings learned from since the learning began."""
    refused: int
    """Brakings that neither the vehicle file nor what was learned explains."""
    restarts: int
    """Times the learning began anew, because brakes or load had changed."""
    reason: Reason


@dataclass(frozen=True)
class _State:
    """Estimate of the unknowns with its covariance, and ln of the likelihood of the braking."""

    mean: Array
    covariance: Array
    log_likelihood: float = 0.0
    misfit: float = 0.0
    """Sum of the squared innovations over their variances."""


class GainOverMassLearner:
    """Learns from every braking in which all wheels and the acceleration are measured."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Begin with the vehicle file."""
        mounting, wheels = vehicle.accelerometer, vehicle.wheels
        self._vehicle = vehicle
        self._radii = np.array(vehicle.radii)
        front = np.array([wheel.axle == FRONT for wheel in wheels])
        per_pressure = np.array([wheel.brake_gain for wheel in wheels]) / (self._radii * vehicle.mass)
        self._by_pressure = np.array([per_pressure * front, per_pressure * ~front])
        inertia = np.array([wheel.inertia for wheel in wheels])
        self._by_wheel = inertia / (self._radii * vehicle.mass)
        drag = sum(1.0 / wheel.radius for wheel in wheels if wheel.driven) / vehicle.mass
        self._mean, deviation = np.zeros(9), np.zeros(9)
        radius = radius_deviation(vehicle)
        for unknown, axle in ((_FRONT, FRONT), (_REAR, REAR)):
            gain = max((relative_deviation(wheel, "brake_gain") for wheel in wheels if wheel.axle == axle), default=0.0)
            deviation[unknown] = hypot(gain, radius) if gain else 0.0
        deviation[_MASS] = mass_deviation(vehicle)
        deviation[_INERTIA] = max(relative_deviation(wheel, "inertia") for wheel in wheels)
        self._mean[_SCALE] = mounting.scale - 1.0
        deviation[_SCALE] = hypot(
            absolute_deviation(mounting.deviations, "scale"),
            GRAVITY * absolute_deviation(mounting.deviations, "pitch_gain"),
        )
        deviation[_OFFSET] = absolute_deviation(mounting.deviations, "bias")
        self._mean[_DRAG] = drag * vehicle.engine_drag_torque
        deviation[_DRAG] = drag * absolute_deviation(vehicle.deviations, "engine_drag_torque")
        self._mean[_DELAY] = vehicle.brake_pressure_delay - mounting.delay
        deviation[_DELAY] = hypot(
            absolute_deviation(vehicle.deviations, "brake_pressure_delay"),
            absolute_deviation(mounting.deviations, "delay"),
        )
        deviation[_WHEELS] = _WHEEL_DELAY
        self._covariance = np.diag(deviation**2)
        self._roll = vehicle.rolling_resistance * GRAVITY
        self._air = 0.5 * AIR_DENSITY * vehicle.drag_area / vehicle.mass
        self._pitch = GRAVITY * mounting.pitch_gain
        self.reset()

    def reset(self) -> None:
        """Forget everything that was learned."""
        self._learned = _State(self._mean, self._covariance)
        self._learned_at: float | None = None
        self._brakings = self._refused = self._restarts = 0
        self._last: Checked | None = None
        self._began_at = self._braked_at = self._locked_at = -inf
        self._speed = self._pitched = 0.0
        self._braking: bool = False
        self._candidates = [self._learned]
        self._rows: list[tuple[float, ...]] = []
        self._wait()

    def update(self, sample: Checked) -> None:
        """Take the next sample of all wheels."""
        measured = bool(np.isfinite(sample.wheel_speed).all() and np.isfinite(sample.brake_pressure).all())
        measured = measured and isfinite(sample.acceleration)
        last, self._last = self._last, sample if measured else None
        if sample.after_gap or last is None or not measured:
            self._end()
            return
        nominal = self._by_pressure @ sample.brake_pressure
        braking_by = float(nominal.sum())
        wheel_speeds = self._radii * sample.wheel_speed
        speed, interval = float(wheel_speeds.max()), sample.time - last.time
        if not self._braking:
            if braking_by < _END:
                self._released = True
            if self._released and braking_by > _BEGIN and speed > _LOWEST_SPEED:
                self._begin(sample.time, speed)
            return
        if braking_by > _END:
            self._braked_at = sample.time
        self._speed = max(self._speed + sample.acceleration * interval, speed)
        self._pitched += (sample.acceleration - self._pitched) * min(interval / _PITCH_TIME, 1.0)
        since = sample.time - self._began_at
        if sample.time - self._braked_at > _RELEASED or self._speed < _LOWEST_SPEED or since > _LONGEST:
            self._end()
            return
        if since < _LIFT or sample.time > self._braked_at:
            self._rows = []  # the engine may drive
            return
        if float(wheel_speeds.min()) < _TURNING * self._speed:
            self._locked_at = sample.time
        spin = float(self._by_wheel @ sample.wheel_speed)
        row = (sample.time, float(nominal[0]), float(nominal[1]), spin, sample.acceleration, self._speed, self._pitched)
        self._rows.append(row)
        if row[0] - self._rows[0][0] >= _BLOCK - 1e-6:
            if self._rows[0][0] > self._locked_at + _AFTER_LOCK:
                self._take(np.array(self._rows))
            self._rows = [row]

    @property
    def brakings(self) -> tuple[int, int]:
        """Brakings learned from since the learning began, and refused."""
        return self._brakings, self._refused

    @property
    def found(self) -> GainOverMass:
        """What is known now; before the first braking that of the vehicle file."""
        mean, covariance = self._learned.mean, self._learned.covariance
        values = []
        for unknown, axle in ((_FRONT, FRONT), (_REAR, REAR)):
            gains = [wheel.brake_gain for wheel in self._vehicle.wheels if wheel.axle == axle]
            nominal = sum(gains) / len(gains) / self._vehicle.mass if gains else nan
            change = float(mean[unknown] - mean[_MASS])
            variance = covariance[unknown, unknown] + covariance[_MASS, _MASS] - 2.0 * covariance[unknown, _MASS]
            value = nominal * exp(change)
            values.append((value, value * sqrt(max(float(variance), 0.0)), change))
        (front, front_stddev, front_change), (rear, rear_stddev, rear_change) = values
        return GainOverMass(
            front,
            front_stddev,
            rear,
            rear_stddev,
            front_change,
            rear_change,
            self._brakings,
            self._refused,
            self._restarts,
            Reason.OK if self._brakings else Reason.NOTHING_LEARNED,
        )

    def _wait(self) -> None:
        """Wait for the next braking."""
        self._braking = self._released = False
        self._rows = []
        self._blocks = 0

    def _begin(self, time: float, speed: float) -> None:
        self._wait()
        self._braking = True
        self._began_at = self._braked_at = time
        self._locked_at = -inf
        self._speed, self._pitched = speed, 0.0
        elapsed = 0.0 if self._learned_at is None else max(time - self._learned_at, 0.0)
        self._learned_at = time
        self._learned = self._forgotten(self._learned, (1.0 - _FORGOTTEN) * exp(-2.0 * elapsed / _MEMORY))
        # what was learned, and the vehicle file
        self._candidates = [self._learned, _State(self._mean, self._covariance)]

    def _forgotten(self, state: _State, kept: float) -> _State:
        """Let a state go back towards the vehicle file, whose deviations it never exceeds; the gear is a new one."""
        mean = self._mean + sqrt(kept) * (state.mean - self._mean)
        covariance = kept * state.covariance + (1.0 - kept) * self._covariance
        mean[_DRAG] = self._mean[_DRAG]
        covariance[_DRAG], covariance[:, _DRAG] = self._covariance[_DRAG], self._covariance[:, _DRAG]
        return _State(mean, covariance)

    def _take(self, rows: Array) -> None:
        """Let the candidates learn from a block of samples, columns as in `update`."""
        time = rows[:, 0]
        duration = float(time[-1] - time[0])
        weights = np.diff(time) / duration
        front, rear, _, reading, speed, pitched = (weights @ (0.5 * (rows[1:, 1:] + rows[:-1, 1:]))).tolist()
        rate = float(rows[-1, 1] + rows[-1, 2] - rows[0, 1] - rows[0, 2]) / duration
        spins = np.diff(rows[:, 3]) / np.diff(time)
        spin, quarter = float(rows[-1, 3] - rows[0, 3]) / duration, max(spins.size // 4, 1)
        spin_rate = float(spins[-quarter:].mean() - spins[:quarter].mean()) / duration
        resistance = self._roll + self._air * speed**2
        self._blocks += 1
        for number, state in enumerate(self._candidates):
            x = state.mean
            by_front, by_rear, by_spin = (exp(x[each] - x[_MASS]) for each in (_FRONT, _REAR, _INERTIA))
            turned = spin + x[_WHEELS] * spin_rate
            brakes = by_front * front + by_rear * rear + by_spin * turned
            force, scale = brakes + resistance + x[_DRAG], 1.0 + x[_SCALE]
            row = np.zeros(9)
            row[_FRONT], row[_REAR] = -scale * by_front * front, -scale * by_rear * rear
            row[_MASS], row[_INERTIA] = scale * brakes, -scale * by_spin * turned
            row[_SCALE], row[_OFFSET], row[_DRAG], row[_DELAY] = -force, 1.0, -scale, -rate
            row[_WHEELS] = -scale * by_spin * spin_rate
            expected = x[_OFFSET] - scale * force + self._pitch * pitched - x[_DELAY] * rate
            gain = state.covariance @ row
            variance = float(row @ gain) + _NOISE**2
            innovation = reading - expected
            misfit = float(innovation**2 / variance)
            self._candidates[number] = _State(
                x + gain * (innovation / variance),
                state.covariance - np.outer(gain, gain) / variance,
                state.log_likelihood - 0.5 * (misfit + log(variance)),
                state.misfit + misfit,
            )

    def _end(self) -> None:
        """Keep what a braking has taught, if there is one."""
        blocks, braked = self._blocks, self._braking
        self._wait()
        if not braked or blocks < _LEAST_BLOCKS:
            return
        carried, fresh = self._candidates
        anew = self._brakings > 0 and fresh.log_likelihood > carried.log_likelihood + _CHANGED
        state = fresh if anew else carried
        if state.misfit > _MISFIT * blocks:
            self._refused += 1
            return
        self._learned = _State(state.mean, state.covariance)
        self._brakings = 1 if anew else self._brakings + 1
        self._restarts += anew
