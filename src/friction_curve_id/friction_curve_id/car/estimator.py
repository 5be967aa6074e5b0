"""The friction curve of a car that is not known exactly, sample by sample.

One curve is fitted for all wheels of the car: that they are on the same road is an assumption. While the car brakes,
each family of curves takes one Gauss-Newton step in turn, with four wheels every 18 ms at most whatever the rate, 9 ms
while a fit is far from where it goes; in between, the present slip is followed with the last fit. What leaves the
window of the newest second stays as a quadratic, which fades. While no brake acts, wheels that spin under the engine
tell of mu_max (traction.py).
"""

from math import inf, isfinite

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.car.answers import answers
from friction_curve_id.car.braking import CAPACITY, Braking
from friction_curve_id.car.braking_samples import BrakingSamples
from friction_curve_id.car.car_constants import CarConstants
from friction_curve_id.car.car_sample import CarGate, CarSample, Checked
from friction_curve_id.car.gain_over_mass import GainOverMassLearner
from friction_curve_id.car.lateral_motion import LateralMotion
from friction_curve_id.car.parameters import CarEstimatorParameters
from friction_curve_id.car.traction import Traction
from friction_curve_id.interface import CurveEstimate, Refusal, RestartCause
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Vehicle

Array = NDArray[np.float64]
Answers = tuple[CurveEstimate | Refusal, ...]

_INTERVAL = 0.0045
"""Least time between two samples of the window [s]; faster ones are averaged."""
_BEFORE = 0.4
"""Time before the braking that is kept [s]."""
_LEAST_BEFORE = 0.1
_LIFT = 0.15
"""The throttle is taken as closed for this time before the brakes act [s]."""
_BRAKES, _RELEASED = 0.2, 0.15
"""Deceleration by the brakes at which a braking begins, and ends [m/s^2]."""
_RELEASE_TIME = 0.15
_COMES_BACK, _FAR_BEHIND = 0.6, 0.8
"""A braking goes on for so long without brakes [s] while a wheel is slower than this share of the car."""


class CarEstimator:
    """Estimator of the curve of all wheels of a car."""

    def __init__(self, vehicle: Vehicle, parameters: CarEstimatorParameters = CarEstimatorParameters()) -> None:
        """Take the car with its deviations."""
        self._vehicle, self._p = vehicle, parameters
        self.learner = GainOverMassLearner(vehicle)
        """What is learned from braking to braking."""
        self._gate = CarGate(vehicle, parameters.max_gap)
        self._radii = np.array(vehicle.radii)
        self._gain = np.array([wheel.brake_gain for wheel in vehicle.wheels])
        self._cause = RestartCause.NONE
        self._lateral = LateralMotion(vehicle)
        self._traction = Traction(vehicle, parameters.families(), parameters.minimum_speed)
        self._begin_again(())

    def reset(self) -> None:
        """Forget everything; the next estimate reports a restart on request."""
        self._gate.reset()
        self.learner.reset()
        self._traction.reset()
        self._cause = RestartCause.REQUEST
        self._begin_again(())

    def update(self, sample: CarSample) -> Answers:
        """Take the next sample and answer for each wheel; never raises on bad data."""
        checked = self._gate.admit(sample)
        count = len(self._vehicle.wheels)
        if isinstance(checked, Refusal):
            return (checked,) * count
        self.learner.update(checked)
        spinning = self._traction.update(checked, self._braking is not None or self._unknown_start)
        present = tuple(int(each) for each in np.flatnonzero(np.isfinite(checked.wheel_speed)))
        if checked.after_gap:
            if self._braking:
                self._cause = RestartCause.GAP
            self._begin_again(present)
        elif present != self._present:
            if self._braking and set(self._present) - set(present):
                missing = ", ".join(self._vehicle.wheel_names[each] for each in set(self._present) - set(present))
                return (Refusal(Reason.BAD_INPUT, f"wheel speed or brake pressure of {missing} is missing"),) * count
            if not self._braking:
                self._begin_again(present)
        if not self._present:
            return (Refusal(Reason.BAD_INPUT, "no wheel has both a speed and a brake pressure"),) * count
        braking = self._braking
        if braking and self._with_accelerometer and not isfinite(checked.acceleration):
            return (Refusal(Reason.NO_ACCELERATION, "acceleration is missing: check imu/data"),) * count
        if braking and braking.measured_across and not isfinite(checked.yaw_rate):
            return (
                Refusal(Reason.NO_ACCELERATION, "yaw rate or lateral acceleration is missing: check imu/data"),
            ) * count
        answer = self._take(checked)
        if isinstance(answer, Refusal):
            otherwise, told = answer, zip(self._traction.driven, spinning, strict=False)
        else:
            otherwise = Refusal(Reason.BAD_INPUT, "wheel speed or brake pressure is missing")
            told = zip(self._present, answer, strict=True)
        by_wheel: list[CurveEstimate | Refusal] = [otherwise] * count
        for each, estimate in told:
            by_wheel[each] = estimate
        return tuple(by_wheel)

    def _begin_again(self, present: tuple[int, ...]) -> None:
        """Forget the samples; go on with these wheels."""
        self._present = present
        self._braking: Braking | None = None
        self._with_accelerometer = True
        self._unknown_start = False
        self._released_at = inf
        index = list(present)
        self._index = index
        self._samples = BrakingSamples(max(len(index), 1), CAPACITY)
        self._gathered_time = 0.0
        self._gathered_turn = np.zeros(len(index))
        self._gained = 0.0
        self._last: Checked | None = None
        self._lateral.reset()
        if present:
            self._car = CarConstants(self._vehicle, present)
            self._per_torque = 1.0 / (self._radii[index] * self._car.mass * self._car.carried_share)

    def _take(self, sample: Checked) -> list[CurveEstimate] | Refusal:
        """Take a sample of the present wheels."""
        index, last = self._index, self._last
        speed, torque = sample.wheel_speed[index], sample.brake_pressure[index] * self._gain[index]
        braking_by = float(self._per_torque @ torque)
        if not self._braking:
            self._with_accelerometer = isfinite(sample.acceleration)
        acceleration = sample.acceleration
        interval = 0.0 if last is None else sample.time - last.time
        if not self._with_accelerometer:
            growth, mean_torque = np.zeros_like(speed), torque
            if last is not None:
                growth = (speed - last.wheel_speed[index]) / interval
                mean_torque = 0.5 * (torque + last.brake_pressure[index] * self._gain[index])
            acceleration = -float(self._per_torque @ (self._car.inertia[:, 0] * growth + mean_torque))
        before = acceleration if last is None or not isfinite(last.acceleration) else last.acceleration
        self._gained += interval * 0.5 * (acceleration + before if self._with_accelerometer else 2.0 * acceleration)
        turned = bool(self._car.partner) and self._with_accelerometer and isfinite(sample.yaw_rate)
        if turned:
            self._gained += interval * sample.yaw_rate * self._lateral.sideways
        self._gathered_time += interval
        self._gathered_turn += interval * speed
        self._last = sample._replace(acceleration=acceleration)
        complete = self._samples.count == 0 or self._gathered_time >= _INTERVAL
        if complete:
            mean = speed
            if self._p.wheel_speed_is_interval_mean and self._gathered_time > 0.0:
                mean = self._gathered_turn / self._gathered_time
            before_it = float(self._samples.time[-1]) if self._samples.count else sample.time
            self._keep(sample.time, mean, torque, acceleration)
            if turned:
                self._turn_with(sample, sample.time - before_it, speed)
            self._gathered_time, self._gained = 0.0, 0.0
            self._gathered_turn = np.zeros(len(index))
        if float((self._radii[index] * speed).max()) < self._p.minimum_speed and not self._braking:
            return Refusal(Reason.LOW_SPEED, f"waiting for a speed above {self._p.minimum_speed} m/s")
        self._watch_brakes(sample.time, braking_by, speed, turned)
        if not self._braking:
            if self._unknown_start:
                return Refusal(Reason.NO_EXCITATION, "waiting for the next braking: the speed before this is unknown")
            return Refusal(Reason.NO_EXCITATION, "waiting for a braking")
        if complete and self._braking.move(sample.time):
            self._cause = RestartCause.SURFACE
        cause, self._cause = self._cause, RestartCause.NONE
        return answers(self._braking, sample.time, speed, self._gained, cause)

    def _keep(self, time: float, speed: Array, torque: Array, acceleration: float) -> None:
        samples = self._samples
        if self._braking:
            self._braking.make_room()
        else:
            while (samples.count > 1 and time - samples.time[1] > _BEFORE) or samples.count == CAPACITY:
                samples.drop_oldest(max(int(np.searchsorted(samples.time, time - _BEFORE)) - 1, 1))
        samples.append(time, speed, torque, acceleration, self._gained, self._braking is not None)

    def _turn_with(self, sample: Checked, interval: float, speed: Array) -> None:
        """Follow the motion across the car, and add it to the newest sample of the window."""
        car_speed = float((self._radii[self._index] * speed).mean())
        if self._braking:
            car_speed = max(self._braking.car_speed(), 1.0)
        self._lateral.update(interval, car_speed, sample.yaw_rate, sample.leftward, self._braking is not None)
        self._samples.turn(sample.yaw_rate, sample.leftward, self._lateral.turned, self._lateral.rolled)

    def _watch_brakes(self, time: float, braking_by: float, speed: Array, turned: bool) -> None:
        """Begin and end brakings; `turned`: the motion across the car is measured."""
        if not self._braking and not self._unknown_start:
            if braking_by > _BRAKES:
                if time - self._samples.time[0] >= _LEAST_BEFORE and self._samples.count >= 5:
                    self._begin_braking(time, turned)
                else:
                    self._unknown_start = True
            return
        if braking_by > _RELEASED:
            self._released_at = inf
        elif self._released_at == inf:
            self._released_at = time
        released_for = time - self._released_at
        comes_back = False
        if self._braking and released_for < _COMES_BACK:  # an anti-lock system has opened a brake, not the driver
            slowest = float((self._radii[self._index] * speed).min())
            comes_back = slowest < _FAR_BEHIND * self._braking.car_speed()
        if released_for > _RELEASE_TIME and not comes_back:
            self._begin_again(self._present)

    def _begin_braking(self, time: float, turned: bool) -> None:
        self._samples.close_throttle(time - _LIFT)
        self._braking = Braking(
            self._vehicle,
            self._p,
            self._car,
            self._present,
            self._samples,
            time,
            self._lateral,
            self._with_accelerometer,
            turned,
        )
